//! Nodes and quadratures from their keys: `path-fitted` and `galerkin`.

use super::super::expression::Rounding;
use super::super::nodes::Nodes;
use super::coefficients::{required, rounding, values};
use super::document::Document;
use super::error::Fault;

const FITTED: &str = "path fitting has `nodes`, those between the ends of a step, in (0, 1)";

pub(super) fn path_fitted(document: &mut Document, digits: Option<u32>) -> Result<(Nodes, Rounding), Fault> {
    let nodes = required(document, "nodes", None, FITTED)?;
    let rounding = rounding(digits, nodes.iter());
    let at: Vec<usize> = nodes.iter().map(|(scalar, _)| scalar.at).collect();
    let nodes = values(&nodes, rounding)?;
    for (node, at) in nodes.iter().zip(at) {
        let x = node.real.to_f64();
        if !(x > 0.0 && x < 1.0) {
            return Err(Fault::new(at, format!("the node `{}` is not between 0 and 1", node.text)).hint(FITTED));
        }
    }
    Ok((Nodes { degree: nodes.len() + 1, nodes, weights: None }, rounding))
}

const GALERKIN: &str =
    "a Galerkin integrator has `degree`, that of the path, and the `nodes` and `weights` of a quadrature";

pub(super) fn galerkin(document: &mut Document, digits: Option<u32>) -> Result<(Nodes, Rounding), Fault> {
    let nodes = required(document, "nodes", None, GALERKIN)?;
    let weights = required(document, "weights", Some(nodes.len()), GALERKIN)?;
    let rounding = rounding(digits, nodes.iter().chain(&weights));
    let degree = document.count("degree", 1, nodes.len() as u32)?.unwrap_or(nodes.len() as u32) as usize;
    Ok((Nodes { degree, nodes: values(&nodes, rounding)?, weights: Some(values(&weights, rounding)?) }, rounding))
}
