//! The impulsively started lid, with steps that do not resolve its first moments.

use rayon::prelude::*;

use super::{PROJECTION, cavity, cavity_by, named, rms};
use crate::experiment::{Context, Experiment, StudyError};
use crate::run::run;

/// The Reynolds number.
pub const RE: f64 = 100.0;
/// All methods, and pressure correction.
pub const METHODS: [&str; 7] =
    ["method-i", "trapezoidal", "implicit-midpoint", "tr-bdf2", "bdf2", "implicit-euler", PROJECTION];
/// Step sizes.
pub const STEPS: [f64; 2] = [0.5, 0.25];
/// After one step, and later.
pub const TIMES: [f64; 2] = [0.5, 2.0];

/// Runs of all methods from rest.
#[derive(Debug)]
pub struct StartedLid {
    /// Cells along a side.
    pub cells: usize,
}

/// A run.
#[derive(Debug)]
pub struct Case {
    /// Step size.
    pub h: f64,
    /// Time.
    pub t: f64,
    /// Name of the method.
    pub method: &'static str,
    /// Root mean square of the error of the velocities.
    pub error: f64,
    /// Velocities on the grid.
    pub velocities: Vec<f64>,
}

/// Small steps of RK4.
#[derive(Debug)]
pub struct Reference {
    /// Time.
    pub t: f64,
    /// Velocities on the grid.
    pub velocities: Vec<f64>,
    /// A third of the difference from steps twice as long: no less than its error, whatever the jump leaves of the order.
    pub error: f64,
}

/// Everything.
#[derive(Debug)]
pub struct Found {
    /// A run each.
    pub cases: Vec<Case>,
    /// What the runs are compared with.
    pub references: Vec<Reference>,
}

impl Experiment for StartedLid {
    const ID: &'static str = "started-lid";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(2);
        let by = |method: &str, h: f64, t: f64| cavity_by(method, false, (RE, self.cells), (h, (t / h).round() as u32));
        let references: Vec<Reference> = TIMES
            .par_iter()
            .map(|t| {
                let ((coarse, _), (velocities, _)) = (by("rk4", 1.0 / 64.0, *t)?, by("rk4", 1.0 / 128.0, *t)?);
                Ok(Reference { t: *t, error: rms(&coarse, &velocities) / 3.0, velocities })
            })
            .collect::<Result<_, StudyError>>()?;
        context.tick();
        let mut cases = Vec::new();
        for h in STEPS {
            cases.extend(references.iter().flat_map(|truth| METHODS.map(|method| (h, truth, method))));
        }
        let cases = cases
            .into_par_iter()
            .map(|(h, truth, method)| {
                let (velocities, _) = by(method, h, truth.t)?;
                Ok(Case { h, t: truth.t, method, error: rms(&velocities, &truth.velocities), velocities })
            })
            .collect::<Result<_, StudyError>>()?;
        context.tick();
        Ok(Found { cases, references })
    }
}

/// Stream functions after the start, by Method I.
#[derive(Debug)]
pub struct StartUp {
    /// Cells along a side.
    pub cells: usize,
}

impl StartUp {
    /// The step size.
    pub const H: f64 = 0.25;
    /// When the flow is looked at.
    pub const TIMES: [f64; 4] = [0.25, 1.0, 4.0, 16.0];
}

impl Experiment for StartUp {
    const ID: &'static str = "start-up";
    /// ψ at the interior corners, for each time.
    type Found = Vec<Vec<f64>>;

    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        context.announce(1);
        let problem = cavity(RE, self.cells)?;
        let mut found = Vec::new();
        let [.., last] = Self::TIMES;
        run(&*problem, &*named("method-i")?, Self::H, last, |state| {
            if Self::TIMES.contains(&state.t) {
                found.push(state.q.clone());
            }
        })?;
        context.tick();
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_states_after_the_start_are_those_of_their_times() {
        let found = StartUp { cells: 4 }.measure(&Context::quick()).expect("it starts");
        let (problem, method) = (cavity(RE, 4).expect("known"), named("method-i").expect("known"));
        assert_eq!(found.len(), StartUp::TIMES.len());
        for (t, psi) in StartUp::TIMES.into_iter().zip(found) {
            let end = run(&*problem, &*method, 0.25, t, |_| {}).expect("it runs").end;
            assert_eq!(end.q, psi, "t = {t}");
        }
    }

    #[test]
    fn errors_after_the_start_are_absolute_and_that_of_the_reference_is_a_third_of_what_halving_changes() {
        let found = StartedLid { cells: 4 }.measure(&Context::quick()).expect("it starts");
        let by =
            |method, h: f64, t: f64| cavity_by(method, false, (RE, 4), (h, (t / h).round() as u32)).expect("it runs").0;
        assert_eq!((found.references.len(), found.cases.len()), (2, 28));
        for (truth, t) in found.references.iter().zip(TIMES) {
            let [coarse, fine] = [64.0, 128.0].map(|steps| by("rk4", 1.0 / steps, t));
            assert_eq!((truth.t, &truth.velocities), (t, &fine));
            approx::assert_relative_eq!(3.0 * truth.error, rms(&coarse, &fine), max_relative = 1e-12);
        }
        for case in &found.cases {
            let truth = found.references.iter().find(|truth| truth.t == case.t).expect("a time");
            let end = by(case.method, case.h, case.t);
            assert_eq!((case.error, &case.velocities), (rms(&end, &truth.velocities), &end), "{}", case.method);
        }
    }
}
