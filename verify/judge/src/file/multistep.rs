//! The coefficients of a multistep method from their keys.

use super::super::expression::Rounding;
use super::super::multistep::Multistep;
use super::coefficients::{required, rounding, values};
use super::document::Document;
use super::error::Fault;
use super::{Body, Shipped};

const HINT: &str =
    "a multistep method has `rho` and `sigma`, the oldest step first, and maybe `start`, a method of one step";

const TURNED: &str = "the newest step seems to be listed first: `rho` and `sigma` have the oldest step first";

/// What starts a method unless its file says otherwise: of order 5, and damping.
const START: &str = "radau-iia3";

pub(super) fn read(document: &mut Document, digits: Option<u32>) -> Result<(Multistep, Rounding), Fault> {
    let rho = required(document, "rho", None, HINT)?;
    let at = rho[0].0.at;
    if rho.len() < 2 {
        return Err(Fault::new(at, "`rho` has one entry: a method of no steps").hint(HINT));
    }
    let sigma = required(document, "sigma", Some(rho.len()), HINT)?;
    let rounding = rounding(digits, rho.iter().chain(&sigma));
    let start = document.scalar("start")?;
    let (name, start_at) = start.map_or((START.to_owned(), 0), |start| (start.text, start.at));
    let refused = |reason: String| {
        Fault::new(start_at, reason).hint("`start` is a Runge–Kutta method among `verify list method-files`")
    };
    let file = Shipped::by_name(&name).map_err(|error| refused(error.to_string()))?;
    let file = file.read().map_err(|error| refused(error.to_string()))?;
    let Body::RungeKutta(start) = file.body else {
        return Err(refused(format!("`{name}` is no Runge–Kutta method")));
    };
    let method = Multistep { rho: values(&rho, rounding)?, sigma: values(&sigma, rounding)?, start, start_name: name };
    let lead = method.rho.last().is_some_and(|lead| !lead.real.may_be_zero());
    if !lead {
        let is_turned = !method.rho[0].real.may_be_zero();
        let fault = Fault::new(at, "the last entry of `rho`, that of the new step, is zero");
        return Err(fault.hint(if is_turned { TURNED } else { HINT }));
    }
    Ok((method, rounding))
}
