//! Judging a method that comes as text: its order conditions, its stability and structure, and its runs.

pub mod analysis;
pub mod claim;
pub mod closure;
pub mod conditions;
mod counted;
pub mod diagnosis;
pub mod exchange;
mod exhibits;
mod expression;
pub mod facts;
pub mod file;
pub mod linear;
pub mod measured;
mod mend;
mod method;
mod mirror;
pub mod multistep;
pub mod nodes;
pub mod parts;
pub mod polynomial;
mod problem;
pub mod real;
pub mod reduce;
pub mod repair;
mod runge_kutta;
mod stepping;
pub mod structure;
pub mod tableau;
mod tableau_system;
pub mod theory;
pub mod tree;
mod twice;
mod verdict;
pub mod work;

use std::sync::Arc;

use analysis::Analysis;
use claim::{Claim, Property};
use diagnosis::Diagnosis;
pub use expression::Rounding;
use file::MethodFile;
use measured::{Defects, MeasuredOrder};
pub use method::FileMethod;
use rayon::prelude::*;
pub use verdict::{Finding, Kind, Verdict};

use evidence::Outcome;

/// How much is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Conditions alone.
    Theory,
    /// Orders and defects of live steps too.
    Runs,
}

/// All that was found out about a method.
#[derive(Debug)]
pub struct Judgement {
    /// Its file.
    pub file: MethodFile,
    /// What follows from its coefficients.
    pub theory: Arc<dyn Analysis>,
    /// Whether a coefficient or a label is wrong.
    pub diagnosis: Diagnosis,
    /// Orders measured.
    pub measured: Vec<MeasuredOrder>,
    /// Defects of one step, or why it failed; nothing where nothing was run.
    pub defects: Option<Result<Defects, String>>,
    /// Work against error beside other solvers: the problem and the runs, where there are any.
    pub work: Option<Result<(&'static str, Vec<work::Point>), String>>,
    /// The claims of the file, c against the sums of the rows, and theory against measurement.
    pub verdicts: Vec<Verdict>,
}

impl Judgement {
    /// Judges the method of `file`.
    pub fn new(file: MethodFile, effort: Effort) -> Self {
        let claimed = file.order();
        let claimed_embedded = file.claims.iter().find_map(Claim::as_embedded_order);
        let theory = file.body.analyse(claimed, claimed_embedded);
        let mut diagnosis = Diagnosis::new(&file.body, &*theory, claimed, claimed_embedded);
        if file.claims.contains(&Claim { property: Property::Explicit, denied: false }) {
            diagnosis.keep_explicit();
        }
        let method = FileMethod::new(&file.name, Arc::clone(&theory));
        let ((measured, defects), (energy, work)) = match effort {
            Effort::Theory => ((Vec::new(), None), (None, None)),
            Effort::Runs => {
                let defects = || theory.has_structure().then(|| measured::defects(&method));
                let energy = || theory.steps_mechanics().map(|()| measured::energy(&method));
                let work = || theory.converges().and_then(|()| work::measure(&method, theory.has_structure()));
                rayon::join(
                    || rayon::join(|| measured::orders(&method, &*theory), defects),
                    || rayon::join(|| Some(energy()), || Some(work())),
                )
            }
        };
        let mut verdicts: Vec<Verdict> = file.claims.par_iter().map(|claim| verdict::judge(claim, &*theory)).collect();
        verdicts.extend(verdict::consistency(&file, &*theory));
        match theory.own_times().filter(|_| matches!(diagnosis, Diagnosis::OwnTimes)) {
            Some(verdict) => verdicts.push(verdict),
            None => {
                // A closure is held to a live step.
                let is_asked = |found: &Verdict| effort == Effort::Runs || found.kind != Kind::Run;
                let found = theory.consistency().into_iter().filter(is_asked);
                verdicts.extend(found.filter(|found| !verdict::is_conceded(&file, found)));
            }
        }
        verdicts.extend(measured.iter().filter_map(MeasuredOrder::verdict));
        if let Some(Ok(defects)) = &defects {
            verdicts.extend(defects.verdicts(&theory.traits()));
        }
        verdicts.extend(energy.map(measured::energy_verdict));
        Self { file, theory, diagnosis, measured, defects, work, verdicts }
    }

    /// The theory of a Runge–Kutta method, if it is one.
    pub fn runge_kutta(&self) -> Option<&theory::Theory> {
        self.theory.as_runge_kutta()
    }

    /// What comes of all verdicts together.
    pub fn outcome(&self) -> Outcome {
        overall(&self.verdicts)
    }
}

/// Fail where anything is refuted, inconclusive where anything is left open, else pass.
pub fn overall(verdicts: &[Verdict]) -> Outcome {
    let any = |outcome| verdicts.iter().any(|verdict| verdict.check.outcome == outcome);
    if any(Outcome::Fail) {
        Outcome::Fail
    } else if any(Outcome::Inconclusive) {
        Outcome::Inconclusive
    } else {
        Outcome::Pass
    }
}
