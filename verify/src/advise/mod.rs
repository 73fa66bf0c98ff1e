//! What a system is like, and which method to take on it with which step size: from trial runs, never from a name.

mod character;
mod duration;
pub mod study;
mod trial;

use lsvi::Structure;
use lsvi::adaptive::Tolerances;

pub use character::{Character, Growth};
pub use duration::duration;
pub use trial::{Falls, Trial};

use crate::kinds::{Principle, Stability};
use crate::measure::norm::{Extremes, larger, max_norm};
use crate::method::{self, Method};
use crate::names::NameError;
use crate::problem::Problem;
use crate::problem::changes::changes;
use crate::reference;
use crate::run::{RunError, run_through};
use crate::theory::is_cheap;
use trial::{Truth, search};

/// What is tried: each stands for a family, and the cheapest of its family on some problem.
const CANDIDATES: [&str; 12] = [
    "method-i",
    "trapezoidal",
    "tr-bdf2",
    "rk4",
    "ls-galerkin(2,radau,2)",
    "ls-galerkin(3,radau,3)",
    "ls-galerkin(3,gauss,3)",
    "stormer-verlet",
    "blanes-moan",
    "path-fitted(4,gauss)",
    "galerkin-gauss(3)",
    "galerkin-gauss(5)",
];

/// The method that follows the solution with a tolerance.
const ADAPTIVE: &str = "radau-adaptive";

/// A method whose runs take so many times the work of the cheapest trial, and are not accurate enough, is tried no further.
const HOPELESS: f64 = 16.0;

/// Steps that a run of the adaptive method may try, several to each at whose end another method is looked at; one that slides along a jump of
/// f, which no step crosses, would try as many as there are times to double precision.
const TRIED: u64 = 8 * trial::MOST as u64;

/// The longest steps that the adaptive method is tried with, in parts of the run; and a shorter one, where f changes by itself between the times
/// at which these look.
const LONGEST: [f64; 3] = [1.0, 1.0 / 64.0, 1.0 / 1024.0];
const SHORTEST: f64 = 1.0 / 8192.0;

/// Components with an absolute tolerance of their own, as a command line takes them; those of a larger system have the least for all.
const LISTED: usize = 6;

/// Part of the error asked for within which another run has to confirm the solution.
pub const CONFIRMED: f64 = 0.1;

/// Solvers with steps of their own that confirm the solution where no fixed steps come near: the first that is compiled in and does.
const CONFIRMING: [&str; 2] = ["cvode-bdf", "diffsol-bdf"];

/// The tolerance of the run along which a system is looked at, where that of the accurate runs is smaller.
const LOOKING: f64 = 1e-10;

/// Two methods that differ by less in work do the same.
pub const CLEAR: f64 = 1.1;

/// What there is to say.
#[derive(Debug)]
pub struct Advice {
    /// What the system is like; of a large one without its matrices, of a matrix-free one only its size.
    pub character: Character,
    /// The trial runs that reach the accuracy, the least work first.
    pub trials: Vec<Trial>,
    /// Runs of other methods that do, with no more work than what is told.
    rivals: Vec<Trial>,
    /// How far apart two independent runs are, against which the errors were measured.
    pub uncertainty: f64,
    /// The largest error that is within what was asked for, as the errors of the trials are: in absolute terms.
    pub target: f64,
    /// Why no method is recommended, if none is.
    pub refusal: Option<Refusal>,
}

impl Advice {
    /// None, and nothing was tried.
    fn refused(character: Character, refusal: Refusal) -> Self {
        let (trials, rivals) = Default::default();
        Self { character, trials, rivals, uncertainty: f64::NAN, target: f64::NAN, refusal: Some(refusal) }
    }

    /// Whether there is no solution to measure trials by.
    fn has_no_truth(&self) -> bool {
        matches!(self.refusal, Some(Refusal::Lost(_) | Refusal::Parting { .. } | Refusal::Unresolved { .. }))
    }

    /// Whether the accurate runs that led to it may owe it to their tolerances.
    fn is_doubtful(&self, held: Held) -> bool {
        let factor = match self.character.growth {
            Growth::By(factor) => factor,
            Growth::Untold([a, b]) => larger(a, b),
            Growth::Lost(_) | Growth::Unseen => 1.0,
        };
        let spoils = factor * held.rtol > CONFIRMED * self.target;
        let is_coarse = matches!(self.refusal, Some(Refusal::OutOfReach { .. }));
        self.has_no_truth() || is_coarse || (self.refusal.is_some() && spoils)
    }

    /// The one of smaller tolerances instead, unless that has lost the solution: of two that have none the more accurate one tells how near they
    /// come to it.
    fn or_finer(self, finer: Self) -> Self {
        let is_lost = matches!(finer.refusal, Some(Refusal::Lost(_)));
        if is_lost || (finer.has_no_truth() && !self.has_no_truth()) { self } else { finer }
    }

    /// The recommendation: the first trial whose errors follow its order.
    pub fn recommended(&self) -> Option<&Trial> {
        self.predictable().next().filter(|_| self.refusal.is_none())
    }

    /// The trials that may be recommended, the least work first.
    pub fn predictable(&self) -> impl Iterator<Item = &Trial> {
        predictable(&self.trials, self.uncertainty)
    }
}

/// Those whose errors, known to within `uncertainty`, follow the order of their method, so that others can be told from them.
fn predictable(trials: &[Trial], uncertainty: f64) -> impl Iterator<Item = &Trial> {
    trials.iter().filter(move |trial| trial.unpredictable(uncertainty).is_none())
}

/// Why no method is recommended.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The solution cannot be followed.
    #[error("radau-adaptive, which the trials are measured by, cannot follow the solution to the end: {0}")]
    Lost(RunError),
    /// There is no matrix of the Jacobian.
    #[error(
        "the system is known by products with its Jacobian, and radau-adaptive, which the trials are measured by, needs the \
         matrix; `verify order` compares methods of fixed steps on it"
    )]
    MatrixFree,
    /// The solution stays within the accuracy of its start.
    #[error(
        "the solution moves by {moved:.1e} from its start, within the error of {target:.1e} that is asked for, so that standing still would do: \
         start it elsewhere, or ask for less"
    )]
    Constant {
        /// How far it moves.
        moved: f64,
        /// The error to reach.
        target: f64,
    },
    /// Accurate runs do not agree.
    #[error(
        "accurate runs of radau-adaptive, which the trials are measured by, end {difference:.1e} apart, too much to tell errors of {target:.1e}: \
         the solution is sensitive, as one that starts beside a state of rest from which it goes away, or f jumps"
    )]
    Parting {
        /// By so much.
        difference: f64,
        /// The error to reach.
        target: f64,
    },
    /// f is not finite where the solution starts.
    #[error("f is not finite at the start: component {component} of it is {value}")]
    Start {
        /// Its component.
        component: usize,
        /// NaN or infinite.
        value: f64,
    },
    /// No other run confirms the solution.
    #[error(
        "no trial with fixed steps, nor CVODE or diffsol, comes nearer to the solution of radau-adaptive, which the trials are measured by, \
         than {difference:.1e}, too much to tell errors of {target:.1e}: the solution is sensitive, or stiff for longer than they can be accurate, or not smooth, as where f jumps"
    )]
    Unresolved {
        /// By so much.
        difference: f64,
        /// The error to reach.
        target: f64,
    },
    /// No trial reaches the accuracy.
    #[error(
        "no method reaches {accuracy:e} in {most} steps, radau-adaptive with no tolerance that leaves the solution ten times as accurate"
    )]
    OutOfReach {
        /// What was asked for.
        accuracy: f64,
        /// So many steps were tried.
        most: u32,
    },
    /// The errors of no method follow its order, as those of the cheapest do not.
    #[error(
        "the errors of {method} fall with order {found:.1} where it has {nominal}: the solution is not smooth on the scale of its \
         steps, or so long that errors of phase add up, or the problem too stiff for its order there, and no error can be predicted"
    )]
    NotSmooth {
        /// The method.
        method: String,
        /// The order found.
        found: f64,
        /// Its nominal order.
        nominal: u32,
    },
    /// Two methods take the same work.
    #[error("no clear winner: {first} and {second} take the same work to a tenth")]
    Tie {
        /// The one.
        first: String,
        /// The other.
        second: String,
    },
}

/// Tolerances of accurate runs.
#[derive(Debug, Clone, Copy)]
pub struct Held {
    /// The relative one.
    rtol: f64,
    /// The absolute one as a multiple of it, in this unit.
    scale: f64,
    /// The least size that errors are relative to.
    unit: f64,
}

impl Held {
    /// For a solution of order one, to errors well below `accuracy`.
    pub fn to(accuracy: f64) -> Self {
        Self { rtol: (1e-6 * accuracy).max(1e-12), scale: 1.0, unit: 1.0 }
    }

    /// For one that keeps small components, from which it comes back, or multiplies errors: as accurate as rounding lets it be.
    const SMALL: Self = Self { rtol: 1e-13, scale: 1e-20, unit: 1.0 };

    /// The same in another unit.
    fn in_unit(self, unit: f64) -> Self {
        Self { unit, ..self }
    }

    /// The adaptive method with these tolerances, or with a larger one of the same kind, which its error is within across a kink too.
    fn method(self, least: f64) -> Result<Box<dyn Method>, NameError> {
        let rtol = self.rtol.max(least);
        adaptive_within((rtol, &[self.scale * self.unit * rtol]), true)
    }
}

/// Tries methods on `problem` up to `horizon` for an error of `accuracy`, the largest of a component at the ends of steps
/// relative to the largest component, or 1; `note` hears what is being tried.
///
/// # Errors
/// [`NameError`] if a candidate is not registered, which is a mistake of this program.
pub fn advise(
    problem: &dyn Problem,
    horizon: f64,
    accuracy: f64,
    note: &mut dyn FnMut(&str),
) -> Result<Advice, NameError> {
    advise_beside(problem, horizon, accuracy, &[], note)
}

/// The same, with a look at methods that are none of the candidates.
fn advise_beside(
    problem: &dyn Problem,
    horizon: f64,
    accuracy: f64,
    others: &[Box<dyn Method>],
    note: &mut dyn FnMut(&str),
) -> Result<Advice, NameError> {
    if problem.field().structure() == Structure::MatrixFree {
        return Ok(Advice::refused(Character::unseen(problem), Refusal::MatrixFree));
    }
    let mut f = vec![0.0; problem.field().dim()];
    problem.field().rhs(0.0, &problem.initial(), &mut f);
    if let Some((component, value)) = f.into_iter().enumerate().find(|(_, x)| !x.is_finite()) {
        return Ok(Advice::refused(Character::unseen(problem), Refusal::Start { component, value }));
    }
    let candidates = CANDIDATES.into_iter().map(method::parse).collect::<Result<Vec<_>, _>>()?;
    let mut attempt = |held: Held| -> Result<Advice, NameError> {
        note("the course of the solution");
        let character = Character::of(problem, &*held.method(LOOKING)?, horizon, held.unit);
        Ok(match try_out(problem, horizon, (accuracy, held), [&candidates, others], &character, note)? {
            Err(lost) => Advice::refused(character, Refusal::Lost(lost)),
            Ok(tried) => {
                let refusal = tried.refusal(accuracy);
                Advice {
                    character,
                    trials: tried.trials,
                    rivals: tried.rivals,
                    uncertainty: tried.uncertainty,
                    target: tried.target,
                    refusal,
                }
            }
        })
    };
    let mut in_unit = |unit: f64| -> Result<Advice, NameError> {
        let held = Held::to(accuracy).in_unit(unit);
        let first = attempt(held)?;
        if !first.is_doubtful(held) {
            return Ok(first);
        }
        let second = attempt(Held::SMALL.in_unit(unit))?;
        Ok(first.or_finer(second))
    };
    let first = in_unit(1.0)?;
    // What is too small to move in a unit of 1, or so large that no tolerance is met there, has a unit of its own.
    let unit = match &first.refusal {
        Some(Refusal::Constant { .. }) => Some(first.character.sizes.1).filter(|size| *size < 1.0),
        Some(Refusal::Lost(_)) => size(problem, horizon, accuracy)?.filter(|size| *size > 1.0),
        _ => None,
    };
    let Some(unit) = unit.filter(|unit| unit.is_normal()) else { return Ok(first) };
    let own = in_unit(unit)?;
    Ok(if matches!(own.refusal, Some(Refusal::Constant { .. } | Refusal::Lost(_))) { first } else { own })
}

/// The largest component of a run that is as accurate as the trials have to be, and that stops where f changes; none where it fails.
fn size(problem: &dyn Problem, horizon: f64, accuracy: f64) -> Result<Option<f64>, NameError> {
    let even: Vec<f64> = (1..=trial::TIMES).map(|k| horizon * k as f64 / trial::TIMES as f64).collect();
    let mut stops = [&even[..], &changes(problem, horizon, &even)].concat();
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    let states = run_through(problem, &*adaptive(accuracy)?, &stops);
    Ok(states.ok().map(|states| worst(states.iter().map(|state| max_norm(state)))))
}

/// Trials on a problem.
#[derive(Debug)]
pub struct Tried {
    /// Those that reach the accuracy, the least work first.
    pub trials: Vec<Trial>,
    /// Those of others that do, with no more work than what is told.
    rivals: Vec<Trial>,
    /// How far the accurate run that errors are measured against is from the best of another method.
    pub uncertainty: f64,
    /// The error to reach.
    pub target: f64,
    /// How far the solution moves from its start.
    pub moved: f64,
    /// How far accurate runs with steps of their own end from one another.
    pub parting: f64,
}

impl Tried {
    /// Why the first of the trials is not to be recommended, if it is not.
    fn refusal(&self, accuracy: f64) -> Option<Refusal> {
        let Self { uncertainty, target, .. } = *self;
        let predictable: Vec<&Trial> = predictable(&self.trials, uncertainty).take(2).collect();
        match &self.trials[..] {
            // NaN is no agreement.
            _ if self.parting.is_nan() || self.parting > CONFIRMED * target => {
                Some(Refusal::Parting { difference: self.parting, target })
            }
            _ if self.moved < target => Some(Refusal::Constant { moved: self.moved, target }),
            _ if uncertainty.is_nan() || uncertainty > CONFIRMED * target => {
                Some(Refusal::Unresolved { difference: uncertainty, target })
            }
            [] => Some(Refusal::OutOfReach { accuracy, most: trial::MOST }),
            [first, ..]
                if let (true, Some((found, nominal))) = (predictable.is_empty(), first.unpredictable(uncertainty)) =>
            {
                Some(Refusal::NotSmooth { method: first.method.clone(), found, nominal })
            }
            _ => match predictable[..] {
                [first, second] if second.cost < CLEAR * first.cost => {
                    Some(Refusal::Tie { first: first.method.clone(), second: second.method.clone() })
                }
                _ => None,
            },
        }
    }
}

/// The cheaper of the first two trials in a row that reach the target, with ever smaller tolerances; the last of all may stand alone. An error that
/// grows again with the next tolerance was small by chance.
fn first_lasting(tolerances: &[f64], reaches: impl Fn(&f64) -> Option<Trial>) -> Option<Trial> {
    let mut before: Option<Trial> = None;
    for rtol in tolerances {
        let now = reaches(rtol);
        if let (Some(before), Some(now)) = (&before, &now) {
            return Some(if now.cost < before.cost { now } else { before }.clone());
        }
        before = now;
    }
    before
}

/// Runs `methods` that suit `problem` with ever more steps, and the adaptive method with ever smaller tolerances; and `others` with no more
/// work than the cheapest of these that is predictable. Steps that amplify what the equation does not let grow where the system is calm are too
/// long, whatever their error.
///
/// # Errors
/// [`NameError`] as for [`advise`]; the inner [`RunError`] if the solution cannot be followed.
pub fn try_out(
    problem: &dyn Problem,
    horizon: f64,
    (accuracy, held): (f64, Held),
    [methods, others]: [&[Box<dyn Method>]; 2],
    character: &Character,
    note: &mut dyn FnMut(&str),
) -> Result<Result<Tried, RunError>, NameError> {
    let finest = held.rtol;
    let accurate = held.method(finest)?;
    note("the solution");
    let truth = match Truth::by(problem, &*accurate, horizon, held.unit) {
        Ok(truth) => truth,
        Err(lost) => return Ok(Err(lost)),
    };
    truth.was_seen_to_move(character.moved);
    let calm = character.matrices.as_ref().and_then(|matrices| matrices.calm.as_ref());
    // What lasts a moment is seen in the steps of a run alone.
    let target = accuracy * larger(truth.size(), character.sizes.1);
    let (mut trials, mut uncertainty) = (Vec::<Trial>::new(), f64::INFINITY);
    let tolerances = tolerances(finest);
    note(ADAPTIVE);
    let least_sizes = truth.least_sizes(held.scale).map(|sizes| match sizes.len() {
        0..=LISTED => sizes,
        _ => vec![sizes.into_iter().smallest()],
    });
    // The absolute tolerance is what the relative one is of the unit, or of the least size of each component.
    let largest_within = |sizes: &Vec<f64>, longest: f64| {
        // Strict estimates cost more on smooth solutions, and reach across a kink what others do not.
        [false, true].into_iter().find_map(|is_strict| {
            let reaches = |rtol: &f64| {
                let atol: Vec<f64> = sizes.iter().map(|size| as_printed(rtol * size)).collect();
                trial::with_tolerance(problem, (*rtol, &atol), is_strict, longest, &truth, target)
            };
            first_lasting(&tolerances, reaches)
        })
    };
    let sizes: Vec<Vec<f64>> = [vec![held.unit]].into_iter().chain(least_sizes).collect();
    // Steps as long as they like may pass over what f does for a moment, whatever the tolerance.
    let mut longest = LONGEST.into_iter().chain(truth.changes_by_itself().then_some(SHORTEST));
    trials.extend(longest.find_map(|part| {
        let found = sizes
            .iter()
            .filter_map(|sizes| largest_within(sizes, if part < 1.0 { as_printed(part * horizon) } else { horizon }));
        found.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }));
    let is_confirmed = |uncertainty: f64| uncertainty <= CONFIRMED * target;
    let suited: Vec<_> = methods.iter().filter(|method| suits(problem, &***method)).collect();
    for method in &suited {
        // What they are measured by is in doubt already.
        if !is_confirmed(truth.parts_by()) {
            break;
        }
        note(&method.name());
        let least = trials.iter().map(|trial| trial.cost).chain([f64::INFINITY]).smallest();
        let (found, closest) = search(problem, &***method, &truth, target, HOPELESS * least, calm);
        uncertainty = uncertainty.min(closest);
        trials.extend(found);
    }
    trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut confirmed = |times: &[f64], mut apart: f64| {
        for reference in CONFIRMING.into_iter().filter_map(reference::by_name) {
            if !is_confirmed(apart) {
                note(&format!("the solution by {}", reference.name()));
                apart = apart.min(truth.apart_from(reference, held, times));
            }
        }
        apart
    };
    uncertainty = confirmed(&truth.ends_of(trial::TIMES as u32), uncertainty);
    // Where the trial to be told has its errors, as on a spike, the solution may be known less well. Where no solver gets there nothing is learnt.
    let told = predictable(&trials, uncertainty).next().filter(|_| is_confirmed(uncertainty));
    let apart = told.map(|trial| confirmed(&trial.times, f64::INFINITY)).filter(|apart| apart.is_finite());
    uncertainty = apart.map_or(uncertainty, |apart| larger(uncertainty, apart));
    let most = predictable(&trials, uncertainty).map(|trial| trial.cost).next().unwrap_or(f64::INFINITY);
    let others = others.iter().filter(|method| suits(problem, &***method));
    let mut rivals: Vec<Trial> =
        others.flat_map(|method| search(problem, &**method, &truth, target, most, calm).0).collect();
    rivals.retain(|trial| trial.cost <= most);
    let (moved, parting) = (truth.moves_by(), truth.parts_by());
    Ok(Ok(Tried { trials, rivals, uncertainty, target, moved, parting }))
}

/// Whether the method says something about the solution of the problem itself, at a cost that is worth a trial.
fn suits(problem: &dyn Problem, method: &dyn Method) -> bool {
    matches!(
        method.principle(),
        Principle::Equation | Principle::Hamilton | Principle::MomentumZero | Principle::MomentumMeanZero
    ) && method.stability() != Stability::Unstable
        && problem.limit(method.principle()).name == problem.limit(Principle::Equation).name
        && is_cheap(problem, method)
        && method.build(problem).is_ok()
}

fn adaptive(tolerance: f64) -> Result<Box<dyn Method>, NameError> {
    adaptive_within((tolerance, &[tolerance]), false)
}

/// The same with absolute tolerances, one for all components or one for each, and estimates that are held to them themselves.
fn adaptive_within((rtol, atol): (f64, &[f64]), is_strict: bool) -> Result<Box<dyn Method>, NameError> {
    let method = method::parse(ADAPTIVE)?;
    let method = method.limited(TRIED).unwrap_or(method);
    // Positive tolerances are legal.
    let tolerances = Tolerances::new(rtol, 0.0).and_then(|tolerances| tolerances.with_atol(atol.to_vec()));
    let tolerances = tolerances.map(|tolerances| if is_strict { tolerances.strict() } else { tolerances });
    let with = tolerances.ok().and_then(|tolerances| method.with_tolerances(tolerances));
    Ok(with.unwrap_or(method))
}

/// The tolerances that are tried, the largest first. With its own the accurate run, which stops at the ends of the steps of a trial, would be
/// that trial once more: its errors are to be a tenth.
fn tolerances(finest: f64) -> Vec<f64> {
    let all = (4..=20).map(|half| 10_f64.powf(-0.5 * f64::from(half)));
    all.filter(|tolerance| CONFIRMED * tolerance >= finest).map(as_printed).collect()
}

/// A tolerance as it is printed.
fn as_printed(tolerance: f64) -> f64 {
    format!("{tolerance:.2e}").parse().unwrap_or(tolerance)
}

/// The larger of errors, no NaN lost.
fn worst(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, larger)
}

#[cfg(test)]
mod tests;
