//! The files that come along, by name.

use super::{FileError, MethodFile};
use crate::names::NameError;

/// A file that comes along.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// Its path below `verify/methods`, without its ending.
    pub name: &'static str,
    text: &'static str,
}

macro_rules! shipped {
    ($name:literal) => {
        Shipped { name: $name, text: include_str!(concat!("../../../methods/", $name, ".toml")) }
    };
}

/// All of them, those with published misprints last.
pub const SHIPPED: &[Shipped] = &[
    shipped!("bogacki-shampine"),
    shipped!("cash-karp"),
    shipped!("crouzeix3"),
    shipped!("dormand-prince"),
    shipped!("fehlberg45"),
    shipped!("gauss1"),
    shipped!("gauss2"),
    shipped!("gauss3"),
    shipped!("gauss4"),
    shipped!("heun2"),
    shipped!("implicit-euler"),
    shipped!("kutta-38"),
    shipped!("lobatto-iiia2"),
    shipped!("lobatto-iiia3"),
    shipped!("lobatto-iiib3"),
    shipped!("lobatto-iiic3"),
    shipped!("lobatto-iiid3"),
    shipped!("lobatto-iiie3"),
    shipped!("radau-ia2"),
    shipped!("radau-ia3"),
    shipped!("radau-iia2"),
    shipped!("radau-iia3"),
    shipped!("rk4"),
    shipped!("sdirk2"),
    shipped!("ssp-rk3"),
    shipped!("tr-bdf2"),
    shipped!("misprints/fehlberg45-a63"),
    shipped!("misprints/kraaijevanger-spijker"),
    shipped!("misprints/rk4-a44"),
];

impl Shipped {
    /// The file of that name.
    ///
    /// # Errors
    /// [`NameError`] for an unknown name.
    pub fn by_name(name: &str) -> Result<Self, NameError> {
        let found = SHIPPED.iter().find(|file| file.name == name).copied();
        found.ok_or_else(|| NameError::unknown("method file", name, SHIPPED.iter().map(|file| file.name)))
    }

    /// Reads it.
    ///
    /// # Errors
    /// [`FileError`], which a test excludes.
    pub fn read(self) -> Result<MethodFile, FileError> {
        MethodFile::parse(self.name, self.name, self.text)
    }
}
