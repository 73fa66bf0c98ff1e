//! The kinds `path-fitted`, \[KY21\] (8), and `galerkin`, \[MW01\]: variational integrators of mechanics, by their nodes.

use std::sync::Arc;

use lsvi::Integrator;

use super::analysis::{Analysis, Trial};
use super::claim::Property;
use super::exhibits::{coefficient_row, table};
use super::facts::Facts;
use super::polynomial::Polynomial;
use super::real::{Real, dot};
use super::tableau::Coefficient;
use super::tree::power;
use super::verdict::Finding;
use evidence::{Cell, Table};
use experiments::kinds::Symplecticity;
use experiments::measure::norm::larger;
use experiments::method::{Method, Traits, mechanics};
use experiments::problem::Problem;

/// Nodes as a file states them.
#[derive(Debug, Clone)]
pub struct Nodes {
    /// Degree of the path.
    pub degree: usize,
    /// Interior nodes of a fitted path, or those of the quadrature.
    pub nodes: Vec<Coefficient>,
    /// Weights of the quadrature.
    pub weights: Option<Vec<Coefficient>>,
}

impl Nodes {
    pub(super) fn table(&self) -> Table {
        let columns: Vec<String> =
            std::iter::once(String::new()).chain((1..=self.nodes.len()).map(|j| j.to_string())).collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let mut rows = vec![coefficient_row("nodes", &self.nodes)];
        rows.extend(self.weights.as_ref().map(|weights| coefficient_row("weights", weights)));
        table("coefficients", "The coefficients as the file has them.", &columns, rows)
    }
}

/// All that follows from them.
#[derive(Debug)]
pub(super) struct NodesTheory {
    nodes: Nodes,
    degree: usize,
    is_fitted: bool,
    /// The moments that decide the order: ∫ M(t) t^{k−1} dt with M the polynomial of the nodes, or Σ b_i c_i^{k−1} − 1/k.
    moments: Vec<Real>,
    order: u32,
    /// Whether the nodes are symmetric about ½, and whether the weights are then too.
    symmetric: [bool; 2],
    symplectic: Symplecticity,
    method: Result<Box<dyn Method>, String>,
}

/// 1/k.
fn over(k: usize) -> Real {
    &Real::one() / &Real::from(k as i64)
}

/// ∫ M(t) t^{k−1} dt over [0, 1] for k from 1 to `count`, M with the zeros `c`.
pub(super) fn node_moments(c: &[Real], count: usize) -> Vec<Real> {
    let factor = |node: &Real| Polynomial::new(vec![-node, Real::one()]);
    let product = c.iter().fold(Polynomial::new(vec![Real::one()]), |p, node| p.times(&factor(node)));
    let moment = |k: usize| product.coefficients().iter().enumerate().map(|(j, x)| x * &over(j + k)).sum();
    (1..=count).map(moment).collect()
}

/// Σ b_i c_i^{k−1} − 1/k for k from 1 to `count`.
pub(super) fn quadrature_moments(c: &[Real], b: &[Real], count: usize) -> Vec<Real> {
    let power = |k: usize| c.iter().map(|c| (1..k).fold(Real::one(), |p, _| &p * c)).collect::<Vec<_>>();
    (1..=count).map(|k| &dot(b, &power(k)) - &over(k)).collect()
}

impl NodesTheory {
    pub(super) fn new(nodes: &Nodes) -> Self {
        let reals = |list: &[Coefficient]| list.iter().map(|x| x.real.clone()).collect::<Vec<_>>();
        let (c, b) = (reals(&nodes.nodes), nodes.weights.as_deref().map(reals));
        let doubles = |list: &[Real]| list.iter().map(Real::to_f64).collect::<Vec<_>>();
        let mirrored = |i: usize| c.iter().position(|x| (&(x + &c[i]) - &Real::one()).may_be_zero());
        let weighs = |i: usize, j: usize| b.as_ref().is_none_or(|b| (&b[i] - &b[j]).may_be_zero());
        let symmetric = [
            (0..c.len()).all(|i| mirrored(i).is_some()),
            (0..c.len()).all(|i| mirrored(i).is_none_or(|j| weighs(i, j))),
        ];
        let (moments, order, symplectic, method) = match &b {
            // Collocation of the Euler–Lagrange equations: the error at the ends is ∫ M r with a smooth r.
            None => {
                let moments = node_moments(&c, c.len() + 1);
                let free = moments.iter().take_while(|x| x.may_be_zero()).count();
                let symplectic = if free == c.len() { Symplecticity::ConstantMass } else { Symplecticity::Never };
                (moments, c.len() + free, symplectic, mechanics::path_fitted_on(&doubles(&c)))
            }
            Some(b) => {
                let moments = quadrature_moments(&c, b, 2 * c.len() + 1);
                let exact = moments.iter().take_while(|x| x.may_be_zero()).count();
                let order = galerkin_order(nodes.degree, exact);
                (moments, order, Symplecticity::Always, mechanics::galerkin_on(nodes.degree, &doubles(&c), &doubles(b)))
            }
        };
        Self {
            nodes: nodes.clone(),
            degree: nodes.degree,
            is_fitted: b.is_none(),
            moments,
            order: order as u32,
            symmetric,
            symplectic,
            method: match c.iter().position(|x| !(0.0..=1.0).contains(&x.to_f64())) {
                Some(i) => Err(format!("nodes[{}] lies outside of [0, 1], and the path of a step ends there", i + 1)),
                None => method.map_err(|error| error.to_string()),
            },
        }
    }

    /// What the order is made of, and the first condition that fails.
    fn why(&self) -> String {
        let count = self.moments.iter().take_while(|x| x.may_be_zero()).count();
        let next = |condition: &str, is: &str| {
            let next = self.moments.get(count).map(|x| format!("; {condition} {is} {:.3e}", x.to_f64()));
            next.unwrap_or_default()
        };
        let factor = |of: &str| if count == 0 { String::new() } else { format!(" {}", power(of, count)) };
        if self.is_fitted {
            let moment = format!("∫ M(t){} dt over [0, 1]", factor("t"));
            let s = self.degree - 1;
            return format!(
                "{s} from {s} nodes of collocation, and {count} from vanishing moments of M(t) = Π (t − c_i){}",
                next(&moment, "is")
            );
        }
        let (s, u, order) = (self.degree, count, self.order as usize);
        let bound = match (order == u, order == 2 * s) {
            (true, true) => "twice the degree, and the order of the quadrature".to_owned(),
            (true, false) => "that of the quadrature".to_owned(),
            (false, true) => format!("twice the degree, with a quadrature of order {u}"),
            (false, false) if order == 0 => {
                format!("a quadrature of order {u} does not determine paths of degree {s}")
            }
            (false, false) => format!("2(u − s + 1) with a quadrature of order u = {u} and paths of degree s = {s}"),
        };
        let right = if u == 0 { "1".to_owned() } else { format!("1/{}", u + 1) };
        bound + &next(&format!("Σ weights_i{} = {right}", factor("nodes_i")), "is off by")
    }

    fn is_symmetric(&self) -> bool {
        self.symmetric == [true; 2]
    }
}

/// The order of a Galerkin method of degree s with a quadrature of order u: min(2s, u, 2(u − s + 1)).
///
/// The action along the best path is off by h^{2s+1}, and its quadrature by h^{u+1}. The equations inside of the step test with variations
/// δq of degree s on the step's own scale, of which derivatives are 1/h larger: the quadrature meets them to h^{u+1−s}, so that the
/// path is off by h^{u+2−s}, and the action, which is stationary, by the square of that over h.
fn galerkin_order(degree: usize, quadrature: usize) -> usize {
    (2 * degree).min(quadrature).min(2 * (quadrature + 1).saturating_sub(degree))
}

impl Analysis for NodesTheory {
    fn kind(&self) -> &'static str {
        if self.is_fitted { "path-fitted" } else { "galerkin" }
    }

    fn headline(&self) -> String {
        let name = if self.is_fitted { "path fitting" } else { "Galerkin variational integrator" };
        format!("{name}, degree {}", self.degree)
    }

    fn order(&self) -> u32 {
        self.order
    }

    fn facts(&self) -> Facts {
        let not = |holds: bool, what: &str| if holds { what.to_owned() } else { format!("not {what}") };
        let symplectic = match self.symplectic {
            Symplecticity::Always => "symplectic",
            Symplecticity::ConstantMass => "symplectic where the mass is constant",
            Symplecticity::Never => "not symplectic",
        };
        let structure = format!("{symplectic}, {}", not(self.is_symmetric(), "symmetric"));
        vec![("order", format!("{}: {}", self.order, self.why())), ("structure", structure)]
    }

    fn find(&self, property: Property) -> Option<Finding> {
        Some(match property {
            Property::Order(p) => {
                let is = if p == self.order { String::new() } else { format!("the order is {}, ", self.order) };
                Finding::new(p == self.order, is + &self.why()).measured(self.order)
            }
            Property::Symplectic => {
                let why = match self.symplectic {
                    Symplecticity::Always => "it has a discrete Lagrangian",
                    Symplecticity::ConstantMass => {
                        "on Gauss nodes the path is collocation, where the mass is constant and forces depend on q alone"
                    }
                    Symplecticity::Never => "the nodes are not those of Gauss, and the path has no discrete Lagrangian",
                };
                Finding::new(self.symplectic != Symplecticity::Never, why)
            }
            Property::Symmetric => {
                let text = match (self.symmetric, self.is_fitted) {
                    ([false, _], _) => "the nodes are not",
                    ([true, false], _) => "the nodes are, and their weights are not,",
                    ([true, true], true) => "the nodes are",
                    ([true, true], false) => "nodes and weights are",
                };
                Finding::new(self.is_symmetric(), format!("{text} symmetric about ½"))
            }
            _ => return None,
        })
    }

    fn traits(&self) -> Traits {
        let method = self.method.as_ref().map(|method| method.traits());
        let base = method.unwrap_or_else(|_| {
            Traits::new(self.order, experiments::kinds::Principle::Hamilton, experiments::kinds::Stability::Conditional)
        });
        Traits { order: self.order, symplectic: self.symplectic, is_reversible: self.is_symmetric(), ..base }
    }

    fn momentum_roundoff(&self, steps: f64) -> f64 {
        self.method.as_ref().map_or(0.0, |method| method.momentum_roundoff(steps))
    }

    fn rounding_of_coefficients(&self, _size: f64, length: f64, _steps: f64) -> f64 {
        self.moments.iter().map(Real::radius).fold(0.0, larger) * length
    }

    fn moved(&self, by: f64) -> Vec<(f64, Arc<dyn Analysis>)> {
        let mut out: Vec<(f64, Arc<dyn Analysis>)> = Vec::new();
        let mut with = |coefficient: &Coefficient, change: &dyn Fn(&mut Nodes, Real)| {
            let mut moved = self.nodes.clone();
            change(&mut moved, &coefficient.real + &Real::double(by));
            out.push((coefficient.real.radius(), Arc::new(Self::new(&moved))));
        };
        for (i, node) in self.nodes.nodes.iter().enumerate().filter(|(_, node)| node.real.is_rough()) {
            with(node, &|nodes, x| nodes.nodes[i].real = x);
        }
        let weights = self.nodes.weights.iter().flatten().enumerate();
        for (i, weight) in weights.filter(|(_, weight)| weight.real.is_rough()) {
            with(weight, &|nodes, x| {
                if let Some(weights) = &mut nodes.weights {
                    weights[i].real = x;
                }
            });
        }
        out
    }

    fn on_problem<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, String> {
        let method = self.method.as_ref().map_err(Clone::clone)?;
        method.build(problem).map_err(|error| error.reason)
    }

    fn trials(&self) -> Vec<Trial> {
        let from = if self.is_fitted { "the moments of the nodes" } else { "degree and quadrature" };
        let problems =
            [("integrable", "pendulum"), ("oscillating", "henon-heiles"), ("not separable", "double-pendulum")];
        let trial = |(kind, name)| match self.obstacle() {
            Some(why) => Trial { kind, name, plan: Err(why) },
            None => Trial::on(kind, name, &[], self.order, from),
        };
        problems.map(trial).into()
    }

    fn obstacle(&self) -> Option<String> {
        self.method.as_ref().err().cloned()
    }

    fn has_structure(&self) -> bool {
        true
    }

    fn tables(&self) -> Vec<Table> {
        let row = |(k, x): (usize, &Real)| {
            let holds = if x.may_be_zero() { "vanishes" } else { "does not vanish" };
            let numbers = [x.to_f64(), x.radius()].map(Cell::Number);
            [Cell::Integer(k as i64 + 1)].into_iter().chain(numbers).chain([Cell::Text(holds.into())]).collect()
        };
        let caption = "The moments that decide the order.";
        let rows = self.moments.iter().enumerate().map(row).collect();
        vec![table("moments", caption, &["k", "moment", "uncertainty", "verdict"], rows)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::MethodFile;
    use super::*;

    /// A quadrature may have nodes outside of the step; a path has not.
    #[test]
    fn a_quadrature_that_leaves_the_step_is_not_run() {
        let text = "kind = 'galerkin'\nnodes = ['-1/4', '5/4']\nweights = ['1/2', '1/2']\n";
        let theory = MethodFile::parse("m.toml", "m", text).expect("well-formed").body.analyse(None, None);
        let why = "nodes[1] lies outside of [0, 1], and the path of a step ends there";
        assert_eq!((theory.order(), theory.converges()), (2, Err(why.to_owned())));
        assert_eq!(theory.traits().symplectic, Symplecticity::Always);
        assert!(theory.trials().into_iter().all(|trial| trial.plan.is_err_and(|reason| reason == why)));
    }

    fn theory(text: &str) -> Arc<dyn Analysis> {
        MethodFile::parse("m.toml", "m", text).expect("well-formed").body.analyse(None, None)
    }

    #[test]
    fn a_node_beyond_the_end_is_outside_and_what_has_no_order_does_not_converge() {
        let beyond = theory("kind = 'galerkin'\nnodes = ['1/4', '5/4']\nweights = ['3/4', '1/4']\n");
        let why = "nodes[2] lies outside of [0, 1], and the path of a step ends there";
        assert_eq!(beyond.converges(), Err(why.to_owned()));
        let without = theory("kind = 'galerkin'\ndegree = 2\nnodes = [0, '1/2', 1]\nweights = ['1/6', '1/3', '1/6']\n");
        assert_eq!(without.order(), 0);
        assert!(without.converges().is_err_and(|why| why.contains("its order is 0")));
    }

    /// Nodes about ½ with weights of their own, and two of which one moment vanishes where those of Gauss have two.
    #[test]
    fn structure_takes_weights_that_are_symmetric_too_and_all_nodes_of_gauss() {
        let lopsided = theory("kind = 'galerkin'\nnodes = ['1/4', '3/4']\nweights = ['1/4', '3/4']\n");
        let finding = lopsided.find(Property::Symmetric).expect("looked at");
        assert!(finding.why.starts_with("the nodes are, and their weights are not,"), "{}", finding.why);
        assert!(!lopsided.traits().is_reversible);
        let radau = theory("kind = 'path-fitted'\nnodes = ['1/4', '5/6']\n");
        assert_eq!((radau.order(), radau.traits().symplectic), (3, Symplecticity::Never));
    }

    /// Two nodes and two weights of six places.
    #[test]
    fn digits_of_nodes_and_of_weights_leave_runs_open() {
        let rounded = theory(
            "kind = 'galerkin'\nnodes = ['0.211325', '0.788675']\nweights = ['0.499999', '0.500001']\ndigits = 6\n",
        );
        assert_eq!(rounded.moved(1e-7).len(), 4);
        let open = rounded.rounding_of_coefficients(1.0, 1.0, 1.0);
        assert!(open > 1e-8 && rounded.rounding_of_coefficients(1.0, 10.0, 1.0) == 10.0 * open, "{open:e}");
    }

    /// The order is told by the bound that it is, with the first condition that fails: Gauss, Radau and Simpson rules, one of a single
    /// node too few, weights that do not add up, and interior nodes of a fitted path.
    #[test]
    fn an_order_is_told_by_its_bound_and_the_first_condition_that_fails() {
        let why = |text: &str| {
            let file = MethodFile::parse("m.toml", "m", text).expect(text);
            let theory = file.body.analyse(None, None);
            let claim = |p: u32| theory.find(Property::Order(p)).expect("looked at").why;
            (theory.order(), claim(theory.order()), claim(9))
        };
        let galerkin = |text: &str| why(&format!("kind = 'galerkin'\n{text}"));
        let simpson = "nodes = [0, '1/2', 1]\nweights = ['1/6', '2/3', '1/6']\n";
        let is_off = "Σ weights_i nodes_i⁴ = 1/5 is off by 8.333e-3";
        for (text, order, told) in [
            (format!("degree = 2\n{simpson}"), 4, format!("twice the degree, and the order of the quadrature; {is_off}")),
            (format!("degree = 1\n{simpson}"), 2, format!("twice the degree, with a quadrature of order 4; {is_off}")),
            (
                format!("degree = 2\n{}", simpson.replace("2/3", "1/3")),
                0,
                "that of the quadrature; Σ weights_i = 1 is off by -3.333e-1".into(),
            ),
            (
                "degree = 2\nnodes = ['1/3', 1]\nweights = ['3/4', '1/4']\n".into(),
                3,
                "that of the quadrature; Σ weights_i nodes_i³ = 1/4 is off by 2.778e-2".into(),
            ),
            (
                "degree = 3\nnodes = [0, '1/4', 1]\nweights = ['-1/6', '8/9', '5/18']\n".into(),
                2,
                "2(u − s + 1) with a quadrature of order u = 3 and paths of degree s = 3; Σ weights_i nodes_i³ = 1/4 is off by 4.167e-2"
                    .into(),
            ),
            (
                "degree = 3\nnodes = [0, '1/2', 1]\nweights = ['1/4', '1/2', '1/4']\n".into(),
                0,
                "a quadrature of order 2 does not determine paths of degree 3; Σ weights_i nodes_i² = 1/3 is off by 4.167e-2".into(),
            ),
        ] {
            assert_eq!(galerkin(&text), (order, told.clone(), format!("the order is {order}, {told}")), "{text}");
        }
        let told = "2 from 2 nodes of collocation, and 0 from vanishing moments of M(t) = Π (t − c_i); ∫ M(t) dt over [0, 1] is 5.556e-2";
        let fitted = why("kind = 'path-fitted'\nnodes = ['1/3', '2/3']\n");
        assert_eq!(fitted, (2, told.into(), format!("the order is 2, {told}")));
        let told = "3 from 3 nodes of collocation, and 1 from vanishing moments of M(t) = Π (t − c_i); ∫ M(t) t dt over [0, 1] is 7.292e-3";
        assert_eq!(why("kind = 'path-fitted'\nnodes = ['1/4', '1/2', '3/4']\n").1, told);
    }

    /// Gauss nodes, Lobatto nodes with and without one to spare, Radau nodes; Newton–Cotes rules of order 4 and 6 on paths of as high a
    /// degree as they have nodes, of which runs on Kepler's problem have shown 2 and 4; and a trapezoidal rule on cubic paths.
    #[test]
    fn the_order_of_galerkin_methods_is_bounded_by_what_the_quadrature_sees() {
        for (degree, quadrature, order) in [
            (2, 4, 4),
            (3, 6, 6),
            (2, 2, 2),
            (3, 4, 4),
            (4, 6, 6),
            (3, 5, 5),
            (4, 4, 2),
            (5, 6, 4),
            (3, 2, 0),
            (3, 1, 0),
        ] {
            assert_eq!(galerkin_order(degree, quadrature), order, "{degree} {quadrature}");
        }
    }

    #[test]
    fn symmetric_nodes_with_symmetric_weights_make_a_reversible_method() {
        for (weights, is_symmetric) in [("'1/2', '1/2'", true), ("'1/3', '2/3'", false)] {
            let text = format!("kind = 'galerkin'\ndegree = 1\nnodes = [0, 1]\nweights = [{weights}]\n");
            let theory = MethodFile::parse("m.toml", "m", &text).expect("well-formed").body.analyse(None, None);
            assert_eq!(theory.traits().is_reversible, is_symmetric, "{text}");
            assert!(theory.has_structure());
        }
    }
}
