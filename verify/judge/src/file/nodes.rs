//! Nodes and quadratures from their keys: `path-fitted` and `galerkin`.

use super::super::expression::Rounding;
use super::super::nodes::Nodes;
use super::super::tableau::Coefficient;
use super::coefficients::{required, rounding, values};
use super::document::Document;
use super::error::Fault;

const FITTED: &str = "path fitting has `nodes`, those between the ends of a step, in (0, 1)";

pub(super) fn path_fitted(document: &mut Document, digits: Option<u32>) -> Result<(Nodes, Rounding), Fault> {
    let nodes = required(document, "nodes", None, FITTED)?;
    let rounding = rounding(digits, nodes.iter());
    let at: Vec<usize> = nodes.iter().map(|(scalar, _)| scalar.at).collect();
    let nodes = values(&nodes, rounding)?;
    for (node, at) in nodes.iter().zip(&at) {
        let x = node.real.to_f64();
        if !(x > 0.0 && x < 1.0) {
            return Err(Fault::new(*at, format!("the node `{}` is not between 0 and 1", node.text)).hint(FITTED));
        }
    }
    check_distinct(&nodes, &at, FITTED)?;
    Ok((Nodes { degree: nodes.len() + 1, nodes, weights: None }, rounding))
}

/// Refuses nodes that coincide.
fn check_distinct(nodes: &[Coefficient], at: &[usize], hint: &str) -> Result<(), Fault> {
    for (k, (node, at)) in nodes.iter().zip(at).enumerate() {
        if let Some(other) = nodes[..k].iter().find(|other| (&other.real - &node.real).may_be_zero()) {
            let reason = format!("the nodes `{}` and `{}` coincide", other.text, node.text);
            return Err(Fault::new(*at, reason).hint(format!("nodes differ from each other; {hint}")));
        }
    }
    Ok(())
}

const GALERKIN: &str =
    "a Galerkin integrator has `degree`, that of the path, and the `nodes` and `weights` of a quadrature";

pub(super) fn galerkin(document: &mut Document, digits: Option<u32>) -> Result<(Nodes, Rounding), Fault> {
    let nodes = required(document, "nodes", None, GALERKIN)?;
    let weights = required(document, "weights", Some(nodes.len()), GALERKIN)?;
    let rounding = rounding(digits, nodes.iter().chain(&weights));
    let at: Vec<usize> = nodes.iter().map(|(scalar, _)| scalar.at).collect();
    let most = nodes.len() as u32;
    let sees = "with as many nodes as the degree, the quadrature tells every velocity of the path from rest; with fewer it does not";
    let degree = document.count("degree", 1, most).map_err(|fault| fault.hint(sees))?.unwrap_or(most) as usize;
    let nodes = values(&nodes, rounding)?;
    check_distinct(&nodes, &at, GALERKIN)?;
    Ok((Nodes { degree, nodes, weights: Some(values(&weights, rounding)?) }, rounding))
}

#[cfg(test)]
mod tests {
    use super::super::MethodFile;

    #[test]
    fn the_ends_of_a_step_are_no_nodes_of_path_fitting() {
        for node in ["0", "1", "-1/2"] {
            let text = format!("kind = 'path-fitted'\nnodes = ['1/3', '{node}']\n");
            let Err(error) = MethodFile::parse("m.toml", "m", &text) else { panic!("{node}") };
            assert!(error.to_string().contains("is not between 0 and 1"), "{error}");
        }
    }
}
