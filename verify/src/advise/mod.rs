//! What a system is like, and which method to take on it with which step size: from trial runs, never from a name.

mod character;
mod duration;
mod trial;

use lsvi::Structure;
use lsvi::adaptive::Tolerances;

pub use character::{Character, Growth};
pub use duration::duration;
pub use trial::Trial;

use crate::kinds::{Principle, Stability};
use crate::measure::norm::{Extremes, larger};
use crate::method::{self, Method};
use crate::names::NameError;
use crate::problem::Problem;
use crate::reference;
use crate::run::RunError;
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

/// The longest steps that the adaptive method is tried with, in parts of the run.
const LONGEST: [f64; 3] = [1.0, 1.0 / 64.0, 1.0 / 1024.0];

/// Components with an absolute tolerance of their own, as a command line takes them; those of a larger system have the least for all.
const LISTED: usize = 6;

/// Part of the error asked for within which another run has to confirm the solution.
const CONFIRMED: f64 = 0.1;

/// Solvers with steps of their own that confirm the solution where no fixed steps come near: the first that is compiled in and does.
const CONFIRMING: [&str; 2] = ["cvode-bdf", "diffsol-bdf"];

/// The tolerance of the run along which a system is looked at, where that of the accurate runs is smaller.
const LOOKING: f64 = 1e-10;

/// Two methods that differ by less in work do the same.
const CLEAR: f64 = 1.1;

/// What there is to say.
#[derive(Debug)]
pub struct Advice {
    /// What the system is like; of a large one without its matrices, of a matrix-free one only its size.
    pub character: Character,
    /// The trial runs that reach the accuracy, the least work first.
    pub trials: Vec<Trial>,
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
        Self { character, trials: Vec::new(), uncertainty: f64::NAN, target: f64::NAN, refusal: Some(refusal) }
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
        self.has_no_truth() || (self.refusal.is_some() && spoils)
    }

    /// The recommendation.
    pub fn recommended(&self) -> Option<&Trial> {
        self.trials.first().filter(|_| self.refusal.is_none())
    }
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
         start it elsewhere, or ask for less; errors are relative to 1 where all components are smaller, so that other units help too"
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
         than {difference:.1e}, too much to tell errors of {target:.1e}: the solution is sensitive, or not smooth, as where f jumps"
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
    /// The errors of the cheapest method do not follow its order.
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
    /// The absolute one as a multiple of it.
    scale: f64,
}

impl Held {
    /// For a solution of order one, to errors well below `accuracy`.
    pub fn to(accuracy: f64) -> Self {
        Self { rtol: (1e-6 * accuracy).max(1e-12), scale: 1.0 }
    }

    /// For one that keeps small components, from which it comes back, or multiplies errors: as accurate as rounding lets it be.
    const SMALL: Self = Self { rtol: 1e-13, scale: 1e-20 };

    /// The adaptive method with these tolerances, or with a larger one of the same kind.
    fn method(self, least: f64) -> Result<Box<dyn Method>, NameError> {
        let rtol = self.rtol.max(least);
        adaptive_within(rtol, &[self.scale * rtol])
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
        let character = Character::of(problem, &*held.method(LOOKING)?, horizon);
        Ok(match try_out(problem, horizon, (accuracy, held), &candidates, &character, note)? {
            Err(lost) => Advice::refused(character, Refusal::Lost(lost)),
            Ok(tried) => {
                let refusal = tried.refusal(accuracy);
                Advice {
                    character,
                    trials: tried.trials,
                    uncertainty: tried.uncertainty,
                    target: tried.target,
                    refusal,
                }
            }
        })
    };
    let held = Held::to(accuracy);
    let first = attempt(held)?;
    if !first.is_doubtful(held) {
        return Ok(first);
    }
    let second = attempt(Held::SMALL)?;
    Ok(if second.has_no_truth() { first } else { second })
}

/// Trials on a problem.
#[derive(Debug)]
pub struct Tried {
    /// Those that reach the accuracy, the least work first.
    pub trials: Vec<Trial>,
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
            [first, ..] if let Some((found, nominal)) = first.unpredictable() => {
                Some(Refusal::NotSmooth { method: first.method.clone(), found, nominal })
            }
            [first, second, ..] if second.cost < CLEAR * first.cost => {
                Some(Refusal::Tie { first: first.method.clone(), second: second.method.clone() })
            }
            _ => None,
        }
    }
}

/// Runs `methods` that suit `problem` with ever more steps, and the adaptive method with ever smaller tolerances. Steps that amplify what
/// the equation does not let grow where the system is calm are too long, whatever their error.
///
/// # Errors
/// [`NameError`] as for [`advise`]; the inner [`RunError`] if the solution cannot be followed.
pub fn try_out(
    problem: &dyn Problem,
    horizon: f64,
    (accuracy, held): (f64, Held),
    methods: &[Box<dyn Method>],
    character: &Character,
    note: &mut dyn FnMut(&str),
) -> Result<Result<Tried, RunError>, NameError> {
    let finest = held.rtol;
    let accurate = held.method(finest)?;
    note("the solution");
    let truth = match Truth::by(problem, &*accurate, horizon) {
        Ok(truth) => truth,
        Err(lost) => return Ok(Err(lost)),
    };
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
    // The absolute tolerance is the relative one, or what that is of the least size of each component.
    let largest_within = |sizes: &Vec<f64>, longest: f64| {
        tolerances.iter().find_map(|rtol| {
            let atol: Vec<f64> = sizes.iter().map(|size| as_printed(rtol * size)).collect();
            trial::with_tolerance(problem, (*rtol, &atol), longest, &truth, target)
        })
    };
    let sizes: Vec<Vec<f64>> = [vec![1.0]].into_iter().chain(least_sizes).collect();
    // Steps as long as they like may pass over what f does for a moment, whatever the tolerance.
    trials.extend(LONGEST.iter().find_map(|part| {
        let found = sizes.iter().filter_map(|sizes| largest_within(sizes, as_printed(part * horizon).min(horizon)));
        found.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }));
    let suited: Vec<_> = methods.iter().filter(|method| suits(problem, &***method)).collect();
    for method in &suited {
        note(&method.name());
        let least = trials.iter().map(|trial| trial.cost).chain([f64::INFINITY]).smallest();
        let (found, closest) = search(problem, &***method, &truth, target, HOPELESS * least, calm);
        uncertainty = uncertainty.min(closest);
        trials.extend(found);
    }
    trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    // A run that is too dear to be advised confirms the solution all the same.
    let most = trials.first().map(|trial| HOPELESS * HOPELESS * trial.cost);
    for (method, most) in suited.iter().zip(most.into_iter().cycle()) {
        if uncertainty <= CONFIRMED * target {
            break;
        }
        note(&format!("the solution by {}", method.name()));
        uncertainty = uncertainty.min(search(problem, &***method, &truth, CONFIRMED * target, most, calm).1);
    }
    for reference in CONFIRMING.into_iter().filter_map(reference::by_name) {
        if uncertainty <= CONFIRMED * target {
            break;
        }
        note(&format!("the solution by {}", reference.name()));
        uncertainty = uncertainty.min(truth.apart_from(reference, finest));
    }
    let (moved, parting) = (truth.moves_by(), truth.parts_by());
    Ok(Ok(Tried { trials, uncertainty, target, moved, parting }))
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
    adaptive_within(tolerance, &[tolerance])
}

/// The same with absolute tolerances, one for all components or one for each.
fn adaptive_within(rtol: f64, atol: &[f64]) -> Result<Box<dyn Method>, NameError> {
    let method = method::parse(ADAPTIVE)?;
    let method = method.limited(TRIED).unwrap_or(method);
    // Positive tolerances are legal.
    let tolerances = Tolerances::new(rtol, 0.0).and_then(|tolerances| tolerances.with_atol(atol.to_vec()));
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
