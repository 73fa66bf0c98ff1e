//! Whether steps see how f depends on time.

use lsvi::VectorField;
use lsvi::quadrature::Quadrature;
use nalgebra::{DMatrix, DVector};
use verify::measure::norm::{distance, larger, max_norm};
use verify::problem::Problem;

use super::beware::BEYOND;
use super::equation::{DENSE, jacobian};
use crate::cli::layout::number;

/// Values of f that are looked at in a run at most, milliseconds of a small system. Of larger ones a value is dearer, and each step has one panel:
/// as much as its own evaluations.
const VALUES: f64 = 2e6;

/// Nodes of Gauss' rule, in each panel and for methods of high order in a step.
const NODES: usize = 5;

/// The order up to which methods see of f(t) no more than Simpson's rule does, with its nodes at the ends and the middle, where two runs
/// with h and h/2 look.
const LOW_ORDER: u32 = 4;

/// Part of the solution that the difference comes to where f is not resolved.
const PART: f64 = 1e-3;

/// Steps that miss most of f in which another run has to stop.
const PLACES: usize = 64;

/// What two quadratures of f(t, v) in t make of it along a run, v as it is at the start of each step: one with few nodes, as the steps have
/// them, and one with many panels. Two runs with h and h/2 may see one phase alone of what is periodic, or both pass over what f does for
/// a moment, and agree.
pub(super) struct Forcing<'a> {
    problem: &'a dyn Problem,
    field: Box<dyn VectorField + 'a>,
    /// Nodes in parts of a step, or of a panel, and their weights.
    coarse: Vec<(f64, f64)>,
    fine: Vec<(f64, f64)>,
    /// Panels in a unit of time.
    density: f64,
    /// Values of f that may still be looked at.
    left: f64,
    last: Option<(f64, Vec<f64>)>,
    /// The difference so far, as far as it is not forgotten, and the largest of it at any time.
    difference: Vec<f64>,
    largest: f64,
    /// What the steps miss that miss most of f, the largest first.
    missed: Vec<Missed>,
}

/// What a step misses of f.
#[derive(Debug, Clone, Copy)]
struct Missed {
    /// The difference of the two quadratures.
    difference: f64,
    /// When f is farthest from what it is at the start of the step, and by how much.
    t: f64,
    height: f64,
}

/// That steps do not see f.
#[derive(Debug)]
pub(super) struct Unseen {
    pub(super) text: String,
    /// Times in the steps that miss most of it, in their order.
    pub(super) places: Vec<f64>,
}

impl<'a> Forcing<'a> {
    /// Of a run of a method of this order from 0 to `t_end`, over which the panels are of one width or of the steps where these are shorter.
    pub(super) fn new(problem: &'a dyn Problem, order: u32, t_end: f64) -> Self {
        let field = problem.field();
        // Half of the values, as each step takes some for the nodes of the method too.
        let of_small = 0.5 * VALUES / ((NODES * field.dim().max(1)) as f64 * t_end);
        let density = if field.dim() <= DENSE { of_small } else { 0.0 };
        let coarse = if order <= LOW_ORDER { Quadrature::lobatto(3) } else { Quadrature::gauss(NODES) };
        // Rules of a few nodes exist.
        let [coarse, fine] = [coarse, Quadrature::gauss(NODES)].map(|rule| rule.map_or_else(|_| Vec::new(), pairs));
        let left = if field.is_autonomous() || problem.ode().is_autonomous() { 0.0 } else { VALUES };
        let difference = vec![0.0; problem.ode().dim()];
        Self { problem, field, coarse, fine, density, left, last: None, difference, largest: 0.0, missed: Vec::new() }
    }

    /// Nodes in parts of a step with so many panels, and the weight of each in the difference of the two rules.
    fn rule(&self, panels: f64) -> impl Iterator<Item = (f64, f64)> {
        let of_panel = move |panel: usize| {
            self.fine.iter().map(move |(node, weight)| ((panel as f64 + node) / panels, weight / panels))
        };
        let coarse = self.coarse.iter().map(|(node, weight)| (*node, -weight));
        coarse.chain((0..panels as usize).flat_map(of_panel))
    }

    /// The next row of a run.
    pub(super) fn add(&mut self, t: f64, state: &[f64]) {
        if self.left <= 0.0 {
            return;
        }
        let (n, ode) = (state.len(), self.problem.ode());
        let Some((before, v)) = self.last.replace((t, state.to_vec())).filter(|_| n == ode.dim()) else { return };
        let h = t - before;
        let panels = (self.density * h).floor().max(1.0);
        // As numbers: steps of next to nothing have more panels than there are integers.
        let values = n as f64 * (self.coarse.len() as f64 + self.fine.len() as f64 * panels);
        if self.left < values {
            return;
        }
        self.left -= values;
        // The references' f may be dear, as a convolution of all modes is.
        if self.depends_on_time(before, h, panels, &v) {
            let (mut f, mut of_step, mut moment) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
            let mut start = vec![0.0; n];
            ode.rhs(before, &v, &mut start);
            let mut missed = Missed { difference: 0.0, t: before, height: 0.0 };
            for (node, weight) in self.rule(panels) {
                ode.rhs(before + node * h, &v, &mut f);
                let height = distance(&f, &start);
                if height > missed.height {
                    (missed.t, missed.height) = (before + node * h, height);
                }
                of_step.iter_mut().zip(&f).for_each(|(sum, f)| *sum += h * weight * f);
                moment.iter_mut().zip(&f).for_each(|(sum, f)| *sum += h * (1.0 - node) * h * weight * f);
            }
            // What is not finite is said elsewhere.
            if of_step.iter().chain(&moment).all(|x| x.is_finite()) {
                let missed = Missed { difference: max_norm(&of_step), ..missed };
                let place = self.missed.partition_point(|other| other.difference >= missed.difference);
                self.missed.insert(place, missed);
                self.missed.truncate(PLACES);
                self.difference.iter_mut().zip(of_step).for_each(|(sum, x)| *sum += x);
                self.carry(before, h, &v, moment);
            }
            self.largest = larger(self.largest, max_norm(&self.difference));
        }
    }

    /// What the equation makes of the difference g within a step and leaves of it after, with J its Jacobian. e' = J e + g ends with ∫ g and
    /// J ∫ (h − s) g(s) ds, a first moment that a force in resonance with the steps has too. By implicit Euler, where that damps: a stiff
    /// component forgets its force.
    fn carry(&mut self, t: f64, h: f64, v: &[f64], moment: Vec<f64>) {
        if v.len() > DENSE {
            return;
        }
        let jacobian = jacobian(self.problem, t, v);
        let factors = (DMatrix::identity(v.len(), v.len()) - h * &jacobian).lu();
        // Where it does not damp, nothing is forgotten; of a singular matrix, at h λ = 1, nothing is told.
        let damped = |x: DVector<f64>| match factors.solve(&x) {
            // NaN is no less.
            Some(left) if max_norm(left.as_slice()) < max_norm(x.as_slice()) => left,
            _ => x,
        };
        // Twice, as what is stiff makes next to nothing of its moment: J⁻¹ times the force at the end of the step is all that it keeps.
        let made = damped(damped(jacobian * DVector::from_vec(moment)));
        // What overflows is passed over.
        if made.iter().all(|x| x.is_finite()) {
            self.difference.iter_mut().zip(made.iter()).for_each(|(sum, x)| *sum += x);
        }
        let left = damped(DVector::from_column_slice(&self.difference));
        self.difference.copy_from_slice(left.as_slice());
    }

    /// Whether the method's own f differs at any node of a step, `v` as it is.
    fn depends_on_time(&self, t: f64, h: f64, panels: f64, v: &[f64]) -> bool {
        if self.field.dim() != v.len() {
            return true;
        }
        let (mut first, mut f) = (vec![0.0; v.len()], vec![0.0; v.len()]);
        self.field.rhs(t, v, &mut first);
        self.rule(panels).any(|(node, _)| {
            self.field.rhs(t + node * h, v, &mut f);
            f != first
        })
    }

    /// That the run does not see f, where its largest error is estimated to be `estimate` and its largest component is `size`.
    pub(super) fn unresolved(&self, is_adaptive: bool, estimate: f64, size: f64) -> Option<Unseen> {
        if self.largest <= BEYOND * estimate || self.largest <= PART * size {
            return None;
        }
        let most = self.missed.first()?;
        let remedy = if is_adaptive {
            // As long as what has its height and its area.
            format!(
                "tolerances do not tell, and `--h`, the longest step, does where it is {} or less",
                number(most.difference / most.height)
            )
        } else {
            "a step that is no multiple of its period, or a smaller one, tells".into()
        };
        let text = format!(
            "f changes in time faster than the steps, as at t = {}: its integral over them is another than their nodes make of it, and the \
             estimate, {}, may not know; {remedy}",
            number(most.t),
            number(estimate)
        );
        let mut places: Vec<f64> = self.missed.iter().map(|missed| missed.t).collect();
        places.sort_by(f64::total_cmp);
        Some(Unseen { text, places })
    }
}

/// The nodes of a rule with their weights.
fn pairs(rule: Quadrature) -> Vec<(f64, f64)> {
    rule.nodes().iter().copied().zip(rule.weights().iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use verify::problem::model::Model;

    /// A run of `steps` steps of 1, of those that a run to `t_end` has, along which x is 0, with x' = `rate`.
    fn followed<T>(rate: &str, order: u32, (steps, t_end): (u32, f64), told: impl Fn(&Forcing) -> T) -> T {
        let problem = Model::of_text(&format!("u_i {{ x = 0 }} F_i {{ {rate} }}"), &[], Some(t_end)).expect("a model");
        let mut forcing = Forcing::new(&problem, order, t_end);
        (0..=steps).for_each(|k| forcing.add(f64::from(k), &[0.0]));
        told(&forcing)
    }

    /// Simpson's rule makes −1/3 of a period of cos 2πt + 10 sin 2πt, and the moment of its error is 1/6 + 10/(2π). Where J damps, each
    /// step leaves 1/(1 − hJ) of all before; where it does not, all of it.
    #[test]
    fn what_the_nodes_of_steps_make_of_a_force_adds_up_and_is_forgotten_as_the_equation_does() {
        let (force, run) = ("cos(6.283185307179586*t) + 10*sin(6.283185307179586*t)", (100, 100.0));
        let moment = 1.0 / 6.0 + 10.0 / std::f64::consts::TAU;
        let largest = |rate: &str, order: u32| followed(&format!("{rate} + {force}"), order, run, |it| it.largest);
        let damped = (1.0 / 3.0 - 0.1 * moment / 1.1_f64.powi(2)) / 0.1;
        let growing = (1.0 / 3.0 + 0.1 * moment) * 100.0;
        for (rate, expected) in [("-0.1*x", damped), ("0.1*x", growing)] {
            let found = largest(rate, 4);
            assert!((found / expected - 1.0).abs() < 0.01, "{rate}: {found} for {expected}");
        }
        // Where f is infinite, from 49 to 51, nothing is counted.
        let found = largest("-0.1*x + 1e-300/(t - 50)", 4);
        assert!((found / damped - 1.0).abs() < 0.01, "{found} for {damped}");
        // Five nodes see a period of a cosine.
        let found = followed("cos(6.283185307179586*t)", 5, run, |it| it.largest);
        assert!(found < 0.01, "{found}");
    }

    /// Of a pulse in the first step the next leaves half: the largest part is that of the first.
    #[test]
    fn what_is_forgotten_by_the_end_was_there() {
        let found = followed("-x + 10*exp(-400*(t - 0.25)*(t - 0.25))", 4, (30, 30.0), |it| it.largest);
        let area = 0.5 * std::f64::consts::PI.sqrt();
        let expected = 0.5 * (area - 0.25 * 0.75 * area);
        assert!((found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
    }

    /// Of a large system too, whose f is dear.
    #[test]
    fn a_large_system_has_a_panel_in_each_step() {
        let looked = |n: usize| {
            let entries = |entry: &str| vec![entry; n].join(", ");
            let text = format!("u_i {{ {} }} F_i {{ {} }}", entries("1"), entries("cos(t)"));
            let problem = Model::of_text(&text, &[], Some(10.0)).expect("a model");
            let mut forcing = Forcing::new(&problem, 2, 10.0);
            (0..=10).for_each(|k| forcing.add(f64::from(k), &vec![1.0; n]));
            (VALUES - forcing.left) / n as f64
        };
        assert_eq!(looked(DENSE + 1), 10.0 * (3.0 + 5.0));
        assert!(looked(DENSE) * DENSE as f64 > 0.4 * VALUES);
    }

    /// Of more steps than there are panels each has one.
    #[test]
    fn short_steps_have_a_panel_each() {
        let found = followed("t", 2, (10, 1e7), |it| it.largest);
        assert!(found < 1e-12, "{found}");
    }

    #[test]
    fn a_force_is_not_resolved_beyond_the_estimate_and_a_part_of_the_solution() {
        let problem = verify::problem::build("linear-drag", &[]).expect("registered");
        let missed = vec![Missed { difference: 1.0, t: 0.5, height: 4.0 }];
        let forcing = Forcing { largest: 1.0, missed, ..Forcing::new(&*problem, 2, 1.0) };
        let told = |estimate: f64, size: f64| forcing.unresolved(false, estimate, size).is_some();
        assert_eq!([told(0.33, 1.0), told(0.34, 1.0), told(0.0, 990.0), told(0.0, 1010.0)], [true, false, true, false]);
    }

    #[test]
    fn a_flat_pulse_is_told_where_it_begins() {
        let rate = "heaviside(t - 3.6)*heaviside(3.9 - t)";
        let t = followed(rate, 2, (5, 5.0), |forcing| forcing.missed[0].t);
        assert!((3.6..3.6 + 1e-3).contains(&t), "{t}");
    }

    /// A pulse of height 10 that comes to 1.77 at t = 7.25, and one of half its height; of few steps all are places, of many the 64 that miss most.
    #[test]
    fn places_are_those_where_most_is_missed() {
        let pulses = "10*exp(-100*(t - 7.25)*(t - 7.25)) + 5*exp(-100*(t - 3.3)*(t - 3.3)) + 0.01*sin(t)";
        let told = |steps: u32| {
            followed(&format!("-0.01*x + {pulses}"), 4, (steps, f64::from(steps)), |it| {
                it.unresolved(true, 0.0, 1.0).expect("missed")
            })
        };
        let few = told(10);
        assert!([7.25, 3.3].iter().all(|t| few.places.iter().any(|place| (place - t).abs() < 1e-3)), "{few:?}");
        assert!(few.places.is_sorted() && few.text.contains("as at t = 7.2") && few.text.contains("`--h`"), "{few:?}");
        // Its area over its height, √π/10.
        assert!(few.text.contains("where it is 0.17"), "{few:?}");
        assert_eq!(told(200).places.len(), PLACES);
    }

    /// The same force in twice the time, in steps of 2.
    #[test]
    fn what_is_missed_does_not_depend_on_the_unit_of_time() {
        let largest = |rate: &str, h: f64| {
            let problem = Model::of_text(&format!("u_i {{ x = 0 }} F_i {{ ({rate})/{h} }}"), &[], Some(20.0 * h))
                .expect("a model");
            let mut forcing = Forcing::new(&problem, 4, 20.0 * h);
            (0..=20).for_each(|k| forcing.add(h * f64::from(k), &[0.0]));
            [forcing.largest, (forcing.missed[0].t / h).fract()]
        };
        let force = |h: f64| format!("-0.1*x + cos(6.283185307179586*t/{h}) + 10*sin(6.283185307179586*t/{h})");
        let [one, two] = [1.0, 2.0].map(|h| largest(&force(h), h));
        // Farthest from 1, which it starts from, is −√101, at atan(10) + π.
        let place = 0.5 + 10.0_f64.atan() / std::f64::consts::TAU;
        assert!(one[0] > 0.1 && (one[1] - place).abs() < 0.01, "{one:?}");
        assert!(one.iter().zip(&two).all(|(one, two)| (two / one - 1.0).abs() < 1e-3), "{one:?}, {two:?}");
    }

    /// Of a pulse in the first of 30 steps the others have nothing.
    #[test]
    fn steps_in_which_f_does_not_change_miss_nothing() {
        let missed = followed("-x + 10*exp(-4000*(t - 0.25)*(t - 0.25))", 4, (30, 30.0), |it| it.missed.len());
        assert_eq!(missed, 1);
    }

    /// Simpson's rule misses a third of each of ten steps, of which a large damping leaves next to nothing.
    #[test]
    fn of_a_large_system_nothing_is_forgotten() {
        let largest = |n: usize| {
            let rates = (0..n).map(|k| format!("-9*x{k} + cos(6.283185307179586*t)")).collect::<Vec<_>>().join(", ");
            let start = (0..n).map(|k| format!("x{k} = 0")).collect::<Vec<_>>().join(", ");
            let problem =
                Model::of_text(&format!("u_i {{ {start} }} F_i {{ {rates} }}"), &[], Some(10.0)).expect("a model");
            let mut forcing = Forcing::new(&problem, 4, 10.0);
            (0..=10).for_each(|k| forcing.add(f64::from(k), &vec![0.0; n]));
            forcing.largest
        };
        let [small, large] = [DENSE, DENSE + 1].map(largest);
        assert!(small < 0.5 && (large - 10.0 / 3.0).abs() < 0.01, "{small}, {large}");
    }
}
