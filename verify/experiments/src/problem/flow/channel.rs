//! Start-up of the flow between two walls, in two dimensions.

use super::confined::Given;
use super::problem::InRectangle;
use super::staggered::{Closed, Rectangle};
use crate::names::Parameter;
use crate::problem::{Spec, poiseuille_series};

pub(in crate::problem) const SPEC: Spec = Spec {
    name: "channel-2d",
    summary: "start-up of plane Poiseuille flow in two dimensions, periodic in x over 0 < x < 2, |y| < 1, centre speed 1",
    parameters: &[
        Parameter { name: "cells", default: "16", meaning: "number of cells N across" },
        Parameter { name: "length", default: "8", meaning: "number of cells along" },
        Parameter {
            name: "re",
            default: "1",
            meaning: "Reynolds number Re > 0 of the steady centre speed and half the width",
        },
    ],
    build: |p| {
        let (across, along) = (p.count("cells", 2..=512)?, p.count("length", 2..=512)?);
        let nu = 1.0 / p.positive("re")?;
        let rectangle =
            Rectangle { origin: [0.0, -1.0], size: [2.0, 2.0], cells: [along, across], closed: Closed::Walls };
        Ok(Box::new(InRectangle::new(rectangle, nu, pressure(nu))))
    },
};

/// What the channel is given.
pub(super) fn pressure(nu: f64) -> impl Given {
    Pressure { nu }
}

/// The pressure gradient γ = 2ν that drives the steady profile 1 − y².
#[derive(Debug)]
struct Pressure {
    nu: f64,
}

impl Given for Pressure {
    fn force(&self, _at: [f64; 2], _t: f64) -> Option<[f64; 2]> {
        Some([2.0 * self.nu, 0.0])
    }

    fn exact(&self, [_, y]: [f64; 2], t: f64) -> Option<[f64; 2]> {
        // The arguments are in the domain of the series.
        poiseuille_series::velocity(2.0, y, self.nu * t).ok().map(|u| [u, 0.0])
    }
}
