//! The literature that the report cites by keys.

use maud::{Markup, html};

/// Key and source.
const SOURCES: [(&str, &str); 6] = [
    (
        "S24",
        "S. Sungkeetanon and others, Unconditionally stable symplectic integrators for the Navier–Stokes equations and \
         other dissipative systems. Preprint, 2024, arXiv:2411.13569, doi:10.31224/4107.",
    ),
    (
        "KY21",
        "X. Kong and X. Yang, Variational integrators for mechanical systems based on Lagrange interpolation polynomial \
         fitting (in Chinese). Journal of Dynamics and Control, 2021, doi:10.6052/1672-6553-2020-077.",
    ),
    (
        "MW01",
        "J. Marsden and M. West, Discrete mechanics and variational integrators. Acta Numerica 10, 2001, doi:10.1017/S096249290100006X.",
    ),
    (
        "HNW93",
        "E. Hairer, S. Nørsett and G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. Springer, 1993.",
    ),
    ("HW96", "E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd ed. Springer, 1996."),
    ("HLW06", "E. Hairer, C. Lubich and G. Wanner, Geometric Numerical Integration, 2nd ed. Springer, 2006."),
];

/// Sources that the report cites by their authors.
const BY_NAME: [&str; 6] = [
    "U. Ghia, K. N. Ghia and C. T. Shin, High-Re solutions for incompressible flow using the Navier–Stokes equations and a \
     multigrid method. Journal of Computational Physics 48, 1982, doi:10.1016/0021-9991(82)90058-4.",
    "O. Botella and R. Peyret, Benchmark spectral results on the lid-driven cavity flow. Computers & Fluids 27, 1998, \
     doi:10.1016/S0045-7930(98)00002-4.",
    "C. H. Marchi, R. Suero and L. K. Araki, The lid-driven square cavity flow: numerical solution with a 1024 × 1024 grid. \
     Journal of the Brazilian Society of Mechanical Sciences and Engineering 31, 2009, doi:10.1590/S1678-58782009000300004.",
    "F. Mazzia and C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4. University of Bari, 2008.",
    "I. B. Celik and others, Procedure for estimation and reporting of uncertainty due to discretization in CFD applications. \
     Journal of Fluids Engineering 130, 2008, doi:10.1115/1.2960953.",
    "L. Eça and M. Hoekstra, A procedure for the estimation of the numerical uncertainty of CFD calculations based on grid \
     refinement studies. Journal of Computational Physics 262, 2014, doi:10.1016/j.jcp.2014.01.006.",
];

/// The keys in `text` that no source explains: `[HW96]`.
pub(super) fn unknown(text: &str) -> impl Iterator<Item = &str> {
    let keys = text.split('[').skip(1).filter_map(|rest| Some(rest.split_once(']')?.0));
    let is_key = |key: &&str| {
        let letters = key.trim_end_matches(|c: char| c.is_ascii_digit());
        key.len() == letters.len() + 2 && !letters.is_empty() && letters.bytes().all(|b| b.is_ascii_uppercase())
    };
    keys.filter(is_key).filter(|key| SOURCES.iter().all(|(known, _)| known != key))
}

pub(super) fn write() -> Markup {
    html! {
        section #_bibliography {
            h2 { "Bibliography" }
            dl { @for (key, source) in SOURCES { dt id=(format!("_{key}")) { "[" (key) "]" } dd { (source) } } }
            ul.sources { @for source in BY_NAME { li { (source) } } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_told_from_other_brackets() {
        let found: Vec<_> = unknown("[S24] §3, [HW96] IV.8, [XY07], in [0, 1], [a12], x[K] [N07").collect();
        assert_eq!(found, ["XY07"]);
    }
}
