//! Whether what is advised is about the cheapest, and as accurate as it is told to be.

use lsvi::Structure;

use super::{Advice, Refusal, Trial, advise_beside};
use crate::experiment::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::{Extremes, common_distance, larger, max_norm};
use crate::problem::{self, Problem};
use crate::reference;
use crate::run::run;
use crate::theory::methods_for;

/// What is advised on a problem, up to its own horizon, beside every method that suits.
#[derive(Debug, Clone)]
pub struct Advised {
    /// The problem, in its small version.
    pub problem: &'static str,
    /// The accuracy that is asked for.
    pub accuracy: f64,
}

/// What became of it.
#[derive(Debug)]
pub struct Found {
    /// The run that is recommended, or both of a tie.
    pub told: Vec<Told>,
    /// Why none is recommended.
    pub refusal: Option<Refusal>,
    /// The error to reach.
    pub target: f64,
    /// The method that gets there with the least work, whether or not its errors follow its order.
    pub cheapest: Option<(String, f64)>,
    /// The runs that get there with errors of their order.
    pub predictable: usize,
}

/// A run that is told.
#[derive(Debug)]
pub struct Told {
    /// Its method.
    pub method: String,
    /// Its steps.
    pub steps: u64,
    /// Its work, in evaluations of f.
    pub work: f64,
    /// The error that is told.
    pub error: f64,
    /// That of the same run made anew.
    pub remade: Error,
}

/// The largest error at the ends of the steps of a run.
#[derive(Debug)]
pub struct Error {
    /// Against what.
    pub truth: &'static str,
    /// The error.
    pub size: f64,
    /// How far that may be off.
    pub bound: f64,
}

/// Unknowns of the largest system with a dense matrix, an accurate run of which takes a tenth of a second.
const SMALL: usize = 20;

/// Those of the problems that methods are paired with on which an accurate run takes no longer.
///
/// # Errors
/// [`NameError`](crate::names::NameError) for none that is registered.
pub fn is_quick(name: &str) -> Result<bool, StudyError> {
    let problem = problem::small(name)?;
    let field = problem.field();
    Ok(field.structure() != Structure::Dense || field.dim() <= SMALL)
}

impl Experiment for Advised {
    const ID: &'static str = "advised";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let problem = problem::small(self.problem)?;
        let mut others = methods_for(&*problem);
        others.retain(|method| !super::CANDIDATES.contains(&method.name().as_str()));
        let advice = advise_beside(&*problem, problem.horizon(), self.accuracy, &others, &mut |_| {})?;
        let count = match &advice.refusal {
            None => 1,
            Some(Refusal::Tie { .. }) => 2,
            Some(_) => 0,
        };
        let told =
            advice.predictable().take(count).map(|trial| Told::of(&*problem, trial)).collect::<Result<_, _>>()?;
        let (cheapest, predictable) = of_all(&advice);
        context.tick();
        Ok(Found { told, cheapest, predictable, target: advice.target, refusal: advice.refusal })
    }
}

impl Told {
    fn of(problem: &dyn Problem, trial: &Trial) -> Result<Self, StudyError> {
        let Trial { method, steps, cost, error, .. } = trial;
        let remade = Error::of(problem, trial)?;
        Ok(Self { method: method.clone(), steps: *steps, work: *cost, error: *error, remade })
    }
}

impl Error {
    /// That of the run which a trial recommends, by a closed form or by another library: `radau-adaptive`, which trials are measured by, is neither.
    fn of(problem: &dyn Problem, trial: &Trial) -> Result<Self, StudyError> {
        let (method, horizon) = (trial.built()?, problem.horizon());
        let h = if method.traits().is_adaptive { trial.longest.unwrap_or(horizon) } else { trial.setting };
        let (mut times, mut states) = (Vec::new(), Vec::new());
        run(problem, &*method, h, horizon, |state| {
            times.push(state.t);
            states.push(state.q.clone());
        })?;
        // The first is the start.
        let (times, states) = (&times[1..], &states[1..]);
        let limit = problem.limit(Principle::Equation);
        let exact: Option<Vec<Vec<f64>>> = times.iter().map(|t| (limit.exact)(*t)).collect();
        let (truth, known, bound) = if let Some(known) = exact {
            // A few elementary functions, each to an ulp or two.
            let bound = 16.0 * f64::EPSILON * known.iter().map(|state| max_norm(state)).fold(0.0, larger);
            ("exact", known, bound)
        } else {
            let suited = |stiff_ok: bool| stiff_ok || !problem.is_stiff();
            let references = reference::all().into_iter().filter(|it| suited(it.stiff_ok()));
            let mut solved =
                references.filter_map(|it| Some((it.name(), it.solve(limit.ode, 0.0, &limit.initial, times).ok()?)));
            let (name, sampled) = solved.next().ok_or("no reference solves the problem")?;
            (name, sampled.states, max_norm(&sampled.bound))
        };
        let size = states.iter().zip(&known).map(|(state, known)| common_distance(state, known)).largest();
        Ok(Self { truth, size, bound })
    }
}

/// The cheapest of all runs that reach the accuracy, with its work, and how many of them have errors of their order.
fn of_all(advice: &Advice) -> (Option<(String, f64)>, usize) {
    let all = || advice.trials.iter().chain(&advice.rivals);
    let cheapest = all().min_by(|a, b| a.cost.total_cmp(&b.cost));
    let predictable = all().filter(|trial| trial.unpredictable(advice.uncertainty).is_none()).count();
    (cheapest.map(|trial| (trial.method.clone(), trial.cost)), predictable)
}

#[cfg(test)]
mod tests {
    use super::super::Character;
    use super::super::tests::trial;
    use super::*;
    use crate::problem::model::Model;

    /// Of a coarse tolerance and of short steps, which are far more accurate than it.
    #[test]
    fn a_run_is_made_anew_with_its_longest_step() {
        let problem = Model::of_text("u_i { x = 1 } F_i { -x + sin(3 * t) }", &[], Some(10.0)).expect("a model");
        let error = |longest| {
            let trial = Trial {
                method: "radau-adaptive".into(),
                setting: 1e-3,
                atol: Some(vec![1e-3]),
                longest,
                is_strict: false,
                steps: 1,
                error: 0.0,
                times: Vec::new(),
                cost: 1.0,
                falls: None,
            };
            Error::of(&problem, &trial).expect("it runs").size
        };
        let [short, chosen] = [Some(0.05), None].map(error);
        assert!(short < 1e-7 && chosen > 1e-6, "{short} and {chosen}");
    }

    /// The fourth accuracy, which the report does not show, and the one system that it shows at one accuracy alone.
    #[test]
    fn what_is_advised_takes_at_most_twice_the_work_of_the_cheapest() {
        let slow = problem::paired().filter(|spec| is_quick(spec.name).is_ok_and(|is_quick| !is_quick));
        let slow = slow.flat_map(|spec| [1e-5, 1e-7].map(|accuracy| (spec.name, accuracy)));
        let settings = problem::paired().map(|spec| (spec.name, 1e-4)).chain(slow);
        let settings: Vec<_> = settings.map(|(problem, accuracy)| Advised { problem, accuracy }).collect();
        let found = Context::silent().get_each(settings.clone()).expect("registered");
        for (setting, found) in settings.iter().zip(&found) {
            let least = found.cheapest.as_ref().expect("one is advised").1;
            assert!(!found.told.is_empty(), "{setting:?}: {:?}", found.refusal);
            for told in &found.told {
                assert!(told.work <= 2.0 * least, "{setting:?}: {told:?}, where {:?}", found.cheapest);
            }
        }
    }

    #[test]
    fn runs_of_methods_that_are_no_candidates_count() {
        // The errors of one fall by order 0.5, those of the rival by order 4, its own.
        let trials = vec![trial("rk4", 10.0, [1e-4, 0.7e-4])];
        let rivals = vec![trial("kutta", 9.0, [1e-4, 1e-4 / 16.0])];
        let character = Character::unseen(&*problem::small("logistic").expect("registered"));
        let advice = Advice { character, trials, rivals, uncertainty: 0.0, target: 1e-3, refusal: None };
        assert_eq!(of_all(&advice), (Some(("kutta".into(), 9.0)), 1));
    }

    /// Methods that are no candidates are looked at, and of those none that takes more work than what is told.
    #[test]
    fn rivals_are_others_that_take_no_more_work() {
        let problem = problem::small("prothero-robinson").expect("registered");
        let rivals = |names: &[&str]| {
            let others: Vec<_> = names.iter().map(|name| crate::method::parse(name).expect("registered")).collect();
            let advice = advise_beside(&*problem, problem.horizon(), 1e-3, &others, &mut |_| {}).expect("registered");
            let most = advice.recommended().expect("one").cost;
            assert!(advice.rivals.iter().all(|trial| trial.cost <= most), "{:?}", advice.rivals);
            advice.rivals.iter().map(|trial| trial.method.clone()).collect::<Vec<_>>()
        };
        assert_eq!(rivals(&["implicit-euler", "sdirk2"]), ["implicit-euler"]);
        assert!(rivals(&[]).is_empty());
    }
}
