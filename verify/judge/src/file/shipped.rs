//! The files that come along, by name.

use super::{FileError, MethodFile};
use experiments::names::NameError;

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
    shipped!("stormer-verlet"),
    shipped!("symplectic-euler"),
    shipped!("lobatto-iiia-iiib3"),
    shipped!("ruth3"),
    shipped!("forest-ruth"),
    shipped!("verlet-nystrom"),
    shipped!("nystrom4"),
    shipped!("nystrom5"),
    shipped!("blanes-moan"),
    shipped!("bdf1"),
    shipped!("bdf2"),
    shipped!("bdf3"),
    shipped!("bdf4"),
    shipped!("bdf5"),
    shipped!("bdf6"),
    shipped!("bdf7"),
    shipped!("adams-bashforth2"),
    shipped!("adams-bashforth4"),
    shipped!("adams-moulton3"),
    shipped!("method-i"),
    shipped!("method-ii"),
    shipped!("fitted-pade"),
    shipped!("fitted-exponential"),
    shipped!("path-fitted3"),
    shipped!("path-fitted3-gauss"),
    shipped!("galerkin-gauss2"),
    shipped!("galerkin-simpson2"),
    shipped!("galerkin-radau2"),
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
