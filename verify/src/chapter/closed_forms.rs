//! Live steps of every closure against their closed forms.

use std::sync::Arc;

use super::{Context, Study, StudyError, prose};
use crate::evidence::{Axis, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::experiment::live_steps::{ConventionalGrowth, LiveSteps, Sample, step_sizes};
use crate::experiment::maps::{PRINTED, Printed};
use crate::measure::norm::Extremes;
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "closed-forms",
    title: "One step in closed form",
    question: "Is one step of the library the amplification factor of its closure, for step sizes from 1e-6 to 1e6?",
    source: "[S24] Eqs. (8), (21), (22), (25), (27); linear theory of the closures",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let mut checks = Vec::new();
    let mut printed = Vec::new();
    for Printed { name, equation, .. } in PRINTED {
        let samples = context.get(LiveSteps::Printed(name))?;
        let statement = format!("a step of {name} on v̇ = −v multiplies by the factor {equation}");
        checks.push(check(name, statement, &samples));
        printed.push((name, samples));
    }
    for (id, steps, statement) in [
        (
            "family-grid",
            LiveSteps::Grid,
            "a step of αp_n + βp_{n+1} = 0 on v̇ = −v multiplies by the factor (27), α and β from −2 to 2 by ½",
        ),
        ("family-random", LiveSteps::Random, "the same at random α, β and h"),
        (
            "plane-rotations",
            LiveSteps::Rotations,
            "a step on [[x, −y], [y, x]] multiplies by R(h(x + iy)) in the whole complex plane, at random α, β, h and x + iy",
        ),
        (
            "plane-symmetric",
            LiveSteps::Symmetric,
            "a step on a symmetric matrix multiplies by R(hλ) along each eigenvector, at random α, β, h and spectra in [−1, 1]",
        ),
    ] {
        checks.push(check(id, statement, &context.get(steps)?));
    }
    for h in [0.01, 0.1, 0.5, 1.0, 2.5, 10.0, 100.0] {
        checks.push(growth(h, *context.get(ConventionalGrowth { h })?));
    }
    let table = table(&printed);
    Ok(Evidence {
        checks,
        figures: vec![figure(&table)],
        tables: vec![table],
        notes: prose::fill(include_str!("closed_forms.md"), &[])?,
        ..Evidence::default()
    })
}

fn check(id: &str, statement: impl Into<String>, samples: &[Sample]) -> Check {
    let worst = samples.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let reason = worst.map_or_else(String::new, |Sample { closure, z, error, tolerance, .. }| {
        format!(
            "In units of its roundoff bound; the largest of {} steps is {error:.1e} of {tolerance:.1e} at (α, β) = \
             ({:.3}, {:.3}), hλ = {z:.3e}.",
            samples.len(),
            closure.alpha,
            closure.beta,
        )
    });
    Check::at_most(id, statement, worst.map_or(f64::NAN, Sample::ratio), 1.0, reason)
}

/// The conventional closure follows its growing mode, if a live run grows by `live` a step.
fn growth(h: f64, live: f64) -> Check {
    let factor = ConventionalGrowth { h }.rate().exp();
    // A step rounds v by some ε(1 + h) of itself and so p by ε/h, which takes 1/(1 − e^{−2 rate}) ≈ 1 + 1/h steps to die.
    let tolerance = 24.0 * f64::EPSILON * (1.0 + h + h.recip());
    Check::at_most(
        format!("conventional-growth-{h}"),
        format!("the conventional closure grows by e^{{2 asinh(h/2)}} = {factor:.6} a step on v̇ = −v, h = {h}"),
        (live / factor - 1.0).abs(),
        tolerance,
        "Relative difference of v_{n+1}/v_n at the end of a live run; the bound is the roundoff that p/v gathers.",
    )
}

fn table(printed: &[(&str, Arc<Vec<Sample>>)]) -> Table {
    let rows = printed.iter().flat_map(|(name, samples)| {
        // All samples of one step size together.
        samples.chunk_by(|a, b| a.z == b.z).map(|same| {
            let largest = |f: fn(&Sample) -> f64| same.iter().map(f).largest();
            let relative = largest(|s| s.error / s.size);
            row![*name, -same[0].z.re, largest(|s| s.error), largest(|s| s.tolerance), relative]
        })
    });
    Table::data(
        "closed-forms",
        "Live steps on v̇ = −v from |v| = 1: largest error of 32 steps, its bound, and the error relative to the result.",
        ["method", "h", "error", "bound", "relative_error"],
        rows.collect(),
    )
}

fn figure(table: &Table) -> Figure {
    let panel = |title: &str, label: &str, column: &str| {
        let mut curves = table.curves("method", "h", column, Mark::Line);
        let guide = step_sizes().into_iter().map(|h| (h, f64::EPSILON)).collect();
        curves.push(Series::new("roundoff ε", guide, Mark::Guide));
        Panel::new(Axis::log("h"), Axis::log(label), curves).titled(title)
    };
    let caption = "Largest error of a live step on v̇ = −v against its closed form, over several starts: relative to the \
                   result v_{n+1}, and to the state v_n before the step.";
    let panels = [
        panel("(a) relative to the result", "error / |vₙ₊₁|", "relative_error"),
        panel("(b) relative to the state before", "error / |vₙ|", "error"),
    ];
    Figure::new("closed-forms", caption, table.id.clone(), panels).in_columns(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::measure::amplification::Amplification;
    use nalgebra::Complex;

    fn sample(h: f64, error: f64) -> Sample {
        let closure = Amplification { alpha: 0.0, beta: 1.0 };
        Sample { closure, z: Complex::new(-h, 0.0), error, tolerance: 1e-15, size: 0.5 }
    }

    #[test]
    fn one_step_beyond_its_rounding_fails() {
        for place in 0..3 {
            let outcome = |error: f64| {
                let mut samples = [1.0, 2.0, 3.0].map(|h| sample(h, 1e-16));
                samples[place].error = error;
                check("some", "a step", &samples).outcome
            };
            assert_eq!([0.99e-15, 1.01e-15, f64::NAN].map(outcome), [Outcome::Pass, Outcome::Fail, Outcome::Fail]);
        }
        assert_eq!(check("some", "a step", &[]).outcome, Outcome::Fail);
    }

    /// (1 + √5)/2 squared is the factor at h = 1; 1 + h + 1/h is 3 there, and 101.01 at h = 100.
    #[test]
    fn growth_is_held_to_24_roundings_for_each_that_is_kept() {
        for (h, factor, roundings) in
            [(1.0, (0.5 + 1.25_f64.sqrt()).powi(2), 72.0), (100.0, (50.0 + 2501_f64.sqrt()).powi(2), 24.0 * 101.01)]
        {
            let outcome = |share: f64| growth(h, factor * (1.0 + share * roundings * f64::EPSILON)).outcome;
            assert_eq!([-0.9, 0.9].map(outcome), [Outcome::Pass; 2], "{h}");
            assert_eq!([-1.1, 1.1, f64::NAN].map(outcome), [Outcome::Fail; 3], "{h}");
        }
    }

    #[test]
    fn a_row_has_the_largest_of_its_step_size() {
        let samples = vec![sample(1.0, 2e-16), sample(1.0, 4e-16), sample(1.0, 1e-16), sample(2.0, 3e-16)];
        let table = table(&[("some", Arc::new(samples))]);
        let of = |name: &str| {
            let column = table.column(name).expect("a column");
            table.rows.iter().map(|row| row[column].number().expect("a number")).collect::<Vec<_>>()
        };
        assert_eq!([of("h"), of("error")], [[1.0, 2.0], [4e-16, 3e-16]]);
        assert_eq!([of("bound"), of("relative_error")], [[1e-15, 1e-15], [8e-16, 6e-16]]);
    }
}
