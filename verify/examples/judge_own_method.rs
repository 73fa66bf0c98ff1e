//! A problem and a method of one's own, judged: the order that the coefficients promise, and the one that runs show.
//!
//! `cargo run -p verify --example judge_own_method`

use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory};
use verify::evidence::Outcome;
use verify::judge::file::MethodFile;
use verify::judge::{Effort, FileMethod, Judgement};
use verify::measure::order::{Expectation, Sample, Verdict, fit};

/// v̇ = −2 t v², v(0) = 1: v = 1/(1 + t²).
struct Own;

impl FieldFn for Own {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * v[0] * -2.0 * t;
    }
}

/// Heun's method of third order.
const METHOD: &str = r#"
    kind = "runge-kutta"
    order = 3
    c = [0, "1/3", "2/3"]
    a = [["1/3"], [0, "2/3"]]
    b = ["1/4", 0, "3/4"]
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = MethodFile::parse("heun3", "heun3", METHOD)?;
    let method = FileMethod::of(&file);
    let judgement = Judgement::new(file, Effort::Theory);
    judgement.verdicts.iter().for_each(|verdict| println!("{}: {}", verdict.subject, verdict.check.reason));
    let mut samples = Vec::new();
    for h in (3..10).map(|k| 0.5_f64.powi(k)) {
        let mut run = Trajectory::new(method.integrator(AutoField::new(Own))?, State::new(0.0, vec![1.0]), h, 1.0)?;
        while run.step()?.is_some() {}
        samples.push(Sample::new(h, (run.state().q[0] - 0.5).abs(), f64::EPSILON / h));
    }
    let measured = fit(&samples, &Expectation::new(3.0, 0.1));
    println!("measured: {}", measured.reason);
    let confirmed = judgement.verdicts.iter().all(|verdict| verdict.check.outcome == Outcome::Pass);
    if confirmed && measured.verdict == Verdict::Pass { Ok(()) } else { Err("not everything is confirmed".into()) }
}
