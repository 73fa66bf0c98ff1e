//! The integrators on the harmonic oscillator: recurrences in closed form, and intervals of stability.

use lsvi::TwoStep;

use super::mechanics::{Map, discretise, integrators, map, problem, tangent, text};
use super::{Context, Study, StudyError};
use crate::evidence::{Axis, Cell, Check, Evidence, Figure, Mark, Panel, Series, Table};
use crate::golden::{Row, Tolerance, Truth};
use crate::kinds::{Stability, Symplecticity};
use crate::measure::norm::{Extremes, larger};
use crate::measure::search::{root, try_root};
use crate::method::{self, Method};
use crate::problem::Problem;
use crate::run::run as integrate;

pub(super) const STUDY: Study = Study {
    id: "oscillator",
    title: "The harmonic oscillator: recurrences and stability",
    question: "Are the recurrences of the paper those of the general machinery, and up to which step is each method stable?",
    source: "[KY21] (16)–(19)",
    run,
};

/// A method and the R of its recurrence x_{k+1} = R(τ) x_k − x_{k−1}, in s = τ².
type ClosedForm = (&'static str, &'static str, fn(f64) -> f64);

const CLOSED_FORMS: [ClosedForm; 7] = [
    ("path-fitted(2)", "[KY21] (16)", |s| (16.0 - 6.0 * s) / (8.0 + s)),
    ("midpoint-vi", "[KY21] (17)", |s| (8.0 - 2.0 * s) / (4.0 + s)),
    ("path-fitted(3)", "[KY21] (18)", |s| ((22.0 * s - 468.0) * s + 972.0) / ((2.0 * s + 9.0) * s + 486.0)),
    ("path-fitted(4)", "[KY21] (19)", |s| {
        (((-150.0 * s + 9616.0) * s - 142_848.0) * s + 294_912.0) / (((9.0 * s - 184.0) * s + 2304.0) * s + 147_456.0)
    }),
    ("path-fitted(3,gauss)", "Gauss, m = 3", |s| ((14.0 * s - 384.0) * s + 864.0) / ((s + 24.0) * s + 432.0)),
    ("path-fitted(4,gauss)", "Gauss, m = 4", |s| {
        (((-26.0 * s + 2736.0) * s - 53_280.0) * s + 115_200.0) / (((s + 48.0) * s + 2160.0) * s + 57_600.0)
    }),
    ("stormer-verlet", "2 − τ²", |s| 2.0 - s),
];

/// Step sizes at which live runs are held against the recurrences, as far as they are stable there.
const TAUS: [f64; 8] = [0.05, 0.1, 0.3, 0.7, 1.0, 1.5, 2.0, 2.5];

const STEPS: usize = 200;

/// Largest step that is looked at.
const LARGEST: f64 = 12.0;

/// Step of the scan for changes of stability: DΦ turns by about that angle, far less than the π between two of them.
const SCAN: f64 = 0.03;

/// An instability narrower than this is a point where |R| = 2 is only touched: a root is found to ten digits.
const NARROWEST: f64 = 1e-8;

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let oscillator = problem("harmonic-oscillator", &[])?;
    let all = integrators()?;
    context.announce(CLOSED_FORMS.len() + all.len());
    let (mut checks, mut recurrences, mut stability, mut traces) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (name, source, closed) in CLOSED_FORMS {
        let method = method::parse(name)?;
        for tau in TAUS.into_iter().filter(|tau| closed(tau * tau).abs() < 2.0) {
            recurrences.push(recurrence(&*method, &*oscillator, (source, closed), tau)?);
        }
        let worst = recurrences.iter().filter(|row| row.method == name).map(|row| row.defect / row.bound);
        checks.push(Check::at_most(
            format!("recurrence/{name}"),
            format!(
                "Every step of {STEPS} of the two-step form of {name} is the recurrence {source}, for all stable τ"
            ),
            worst.largest(),
            1.0,
            "defect over its rounding: ε |x| times the sum of squares of the coefficients in the momentum",
        ));
        context.tick();
    }
    let (mut panel, mut determinants) = (Vec::new(), Vec::new());
    for method in &all {
        let name = method.name();
        let mut map = map(&**method, &*oscillator)?;
        let intervals = stable(&mut map)?;
        if let Some((_, source, closed)) = CLOSED_FORMS.into_iter().find(|form| form.0 == name) {
            checks.push(boundaries(&name, source, closed, &intervals));
        }
        let mut points = Vec::new();
        for i in 1..=200 {
            let tau = f64::from(i) * 0.04;
            let tangent = tangent(&mut map, tau, &[1.0, 0.0])?;
            let trace = tangent.trace();
            // Two products of entries that are known to a few ε of the largest, which differentiation has magnified.
            let slopes = method.momentum_roundoff(1.0);
            let rounding = 16.0 * f64::EPSILON * (1.0 + slopes * slopes) * (1.0 + tangent.norm_squared());
            determinants.push((tangent.determinant() - 1.0).abs() / rounding);
            points.push((tau, trace));
            traces.push(vec![text(name.as_str()), Cell::Number(tau), Cell::Number(trace)]);
        }
        let fitted = method.traits().symplectic != Symplecticity::Always;
        panel.push((fitted, Series { label: name.clone(), points, mark: Mark::Line }));
        stability.extend(intervals.iter().enumerate().map(|(i, (from, to))| {
            let end = if *to < LARGEST { Cell::Number(*to) } else { Cell::Empty };
            vec![text(name.as_str()), Cell::Integer(i as i64 + 1), Cell::Number(*from), end]
        }));
        context.tick();
    }
    checks.push(touching(&all, &*oscillator)?);
    checks.push(Check::at_most(
        "determinant",
        "The map of every integrator has determinant 1, for 200 values of τ up to 8",
        determinants.into_iter().largest(),
        1.0,
        "deviation over its rounding",
    ));
    let (curves, motion) = motion(&*oscillator)?;
    Ok(Evidence {
        checks,
        tables: vec![
            recurrence_table(&recurrences),
            Table::new(
                "oscillator-stability",
                format!(
                    "Intervals of τ = ωh in which the integrators are stable on the oscillator, |R(τ)| ≤ 2, up to τ = \
                     {LARGEST}; an interval without an end goes on beyond."
                ),
                &["method", "interval", "from", "to"],
                stability),
            Table::data("oscillator-trace", "R(τ), the trace of the derivative of one step.", &["method", "tau", "trace"], traces),
            motion,
        ],
        figures: vec![curves, figure(panel)],
        notes: vec![
            "All coefficients printed in (16)–(19) are right: live two-step runs, in which nothing knows of the oscillator but \
             its Lagrangian, agree with them to rounding. So do they with the recurrences of Gauss nodes. The linear \
             oscillator hides what tells the node families apart: here every one of these maps has determinant 1."
                .into(),
            "A stable step is one with |R(τ)| ≤ 2. Since the maps are symmetric, R² − 4 = 4 (∂q₁/∂p₀)(∂p₁/∂q₀), and stability \
             changes where one of the two derivatives changes sign: simple roots, which a scan cannot miss by their being \
             narrow. Near τ = π, where the exact map has R = −2, the two roots need not coincide: most path-fitted \
             integrators are unstable in a gap there, and stable again beyond it. The Galerkin integrators on Gauss nodes \
             and the midpoint rule are stable for all τ."
                .into(),
        ],
        ..Evidence::default()
    })
}

struct Recurrence {
    method: String,
    source: &'static str,
    tau: f64,
    defect: f64,
    bound: f64,
}

/// Largest |x_{k+1} − R x_k + x_{k−1}| of a live run.
fn recurrence(
    method: &dyn Method,
    oscillator: &dyn Problem,
    (source, closed): (&'static str, fn(f64) -> f64),
    tau: f64,
) -> Result<Recurrence, StudyError> {
    let mut live = TwoStep::new(discretise(method, oscillator)?);
    let (mut before, mut now) = ([1.0], [tau.cos() + tau.sin()]);
    let (mut defect, mut largest) = (0.0_f64, 0.0_f64);
    for k in 1..=STEPS {
        let [older] = before;
        live.step(k as f64 * tau, tau, &mut before, &mut now)?;
        defect = larger(defect, (now[0] - closed(tau * tau) * before[0] + older).abs());
        largest = larger(largest, now[0].abs());
    }
    // Values of the size of x, rounded, pass through two differentiations: to p at one end of a step and back to x.
    let slopes = method.momentum_roundoff(1.0);
    let bound = 16.0 * f64::EPSILON * (1.0 + slopes * slopes) * largest;
    Ok(Recurrence { method: method.name(), source, tau, defect, bound })
}

/// The intervals of stability in (0, `LARGEST`].
fn stable(map: &mut Map) -> Result<Vec<(f64, f64)>, StudyError> {
    let mut entries = |tau: f64| -> Result<[f64; 2], StudyError> {
        let tangent = tangent(map, tau, &[1.0, 0.0])?;
        Ok([tangent[(0, 1)], tangent[(1, 0)]])
    };
    let mut changes = Vec::new();
    let mut left = (SCAN, entries(SCAN)?);
    while left.0 < LARGEST {
        let tau = left.0 + SCAN;
        let right = (tau, entries(tau)?);
        for which in 0..2 {
            if left.1[which] * right.1[which] < 0.0 {
                let root = try_root([left.0, right.0], |tau| Ok::<_, StudyError>(entries(tau)?[which]))?;
                let root = root.ok_or("the derivative is not a number")?;
                // A pole changes the sign of both derivatives, and not of their product.
                if entries(root)?[which].abs() < 1.0 {
                    changes.push(root);
                }
            }
        }
        left = right;
    }
    changes.sort_by(f64::total_cmp);
    let mut intervals: Vec<(f64, f64)> = Vec::new();
    let mut from = Some(0.0);
    for change in changes {
        match from.take() {
            Some(start) => intervals.push((start, change)),
            None => {
                from = match intervals.last() {
                    Some(last) if change - last.1 < NARROWEST => intervals.pop().map(|last| last.0),
                    _ => Some(change),
                }
            }
        }
    }
    intervals.extend(from.map(|start| (start, LARGEST)));
    Ok(intervals)
}

/// The ends of the intervals are those of |R| ≤ 2 of the closed form.
fn boundaries(name: &str, source: &str, closed: fn(f64) -> f64, intervals: &[(f64, f64)]) -> Check {
    let inside = |tau: f64| intervals.iter().any(|(from, to)| (*from..=*to).contains(&tau));
    // Away from the boundaries the two agree on every τ; at them R itself says how far.
    let wrong = (1..=6000).map(|i| f64::from(i) * 0.002 - 1e-3).filter(|tau| {
        let excess = closed(tau * tau).abs() - 2.0;
        excess.abs() > 1e-9 && inside(*tau) != (excess < 0.0)
    });
    let disagreements = wrong.count() as f64;
    Check::at_most(
        format!("stability/{name}"),
        format!("The intervals of stability of {name} are those in which {source} has |R| ≤ 2, at 6000 values of τ"),
        disagreements,
        0.0,
        "number of τ at which the two disagree",
    )
}

/// The unconditionally stable methods are so.
fn touching(all: &[Box<dyn Method>], oscillator: &dyn Problem) -> Result<Check, StudyError> {
    let mut worst = 0.0_f64;
    for method in all {
        if method.stability() == Stability::Neutral {
            let mut map = map(&**method, oscillator)?;
            for tau in [0.1, 1.0, 3.0, 10.0, 1e2, 1e3] {
                worst = larger(worst, tangent(&mut map, tau, &[1.0, 0.0])?.trace().abs() - 2.0);
            }
        }
    }
    Ok(Check::at_most(
        "stability/unconditional",
        "The midpoint rule and the Galerkin integrators on Gauss nodes are stable for every τ, up to 1000",
        worst,
        64.0 * f64::EPSILON,
        "|R| − 2: they are Gauss collocation, with R = 2 cos θ; the trace has some sixty roundings",
    ))
}

/// Solution and energies as in Figs 1 and 2 of [KY21]: τ = 0.1 from x₀ = ẋ₀ = 1.
fn motion(oscillator: &dyn Problem) -> Result<(Figure, Table), StudyError> {
    let (tau, horizon) = (0.1, 50.0);
    let (mut solution, mut exact, mut energies, mut rows) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (scheme, name) in
        [("(16)", "path-fitted(2)"), ("(17)", "midpoint-vi"), ("(18)", "path-fitted(3)"), ("(19)", "path-fitted(4)")]
    {
        let mut points = Vec::new();
        integrate(oscillator, &*method::parse(name)?, tau, horizon, |state| {
            let (t, x, p) = (state.t, state.q[0], state.q[1]);
            let energy = 0.5 * (x * x + p * p);
            points.push((t, energy - 1.0));
            if scheme == "(16)" && t <= 20.0 {
                solution.push((t, x));
                exact.push((t, t.cos() + t.sin()));
            }
            rows.push([text(scheme)].into_iter().chain([t, x, p, energy].map(Cell::Number)).collect());
        })?;
        energies.push(Series { label: scheme.into(), points, mark: Mark::Line });
    }
    let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
    let solutions = vec![
        Series { label: "(16)".into(), points: solution, mark: Mark::Line },
        Series { label: "exact".into(), points: exact, mark: Mark::Guide },
    ];
    let panel =
        |title: &str, y: &str, series| Panel { title: title.into(), x: axis("t"), y: axis(y), series, field: None };
    let figure = Figure {
        id: "oscillator-motion".into(),
        caption: format!(
            "The oscillator with τ = {tau} from x₀ = ẋ₀ = 1: the solution of (16) and the error of the energy, with the momenta \
             of the schemes for the velocity (Figs 1 and 2 of [KY21]). It stays bounded; (17) has none but rounding."
        ),
        data: "oscillator-motion".into(),
        panels: vec![panel("Solution", "x", solutions), panel("Energy", "E − 1", energies)],
        columns: 2,
    };
    let caption = "Solutions and energies of (16)–(19) on the oscillator.";
    Ok((figure, Table::data("oscillator-motion", caption, &["scheme", "t", "x", "p", "energy"], rows)))
}

fn recurrence_table(rows: &[Recurrence]) -> Table {
    let rows = rows.iter().map(|row| {
        let numbers = [row.tau, row.defect, row.bound].map(Cell::Number);
        [text(row.method.as_str()), text(row.source)].into_iter().chain(numbers).collect()
    });
    Table::new(
        "oscillator-recurrences",
        format!("Largest |xₖ₊₁ − R(τ) xₖ + xₖ₋₁| of {STEPS} live steps of the two-step form, and its rounding."),
        &["method", "recurrence", "tau", "defect", "bound"],
        rows.collect(),
    )
}

/// The traces of the methods, with whether each is one of path fitting, which alone have no discrete Lagrangian.
fn figure(series: Vec<(bool, Series)>) -> Figure {
    let of = |kind: bool| series.iter().filter(|s| s.0 == kind).map(|s| s.1.clone()).collect::<Vec<Series>>();
    let (fitted, others) = (of(true), of(false));
    let panel = |title: &str, mut series: Vec<Series>| {
        let exact = (0..=200).map(|i| f64::from(i) * 0.04).map(|tau| (tau, 2.0 * tau.cos())).collect();
        series.push(Series { label: "exact: 2 cos τ".into(), points: exact, mark: Mark::Guide });
        for level in [-2.0, 2.0] {
            let points = vec![(0.0, level), (8.0, level)];
            series.push(Series { label: format!("R = {level}"), points, mark: Mark::Guide });
        }
        Panel {
            title: title.into(),
            x: Axis { label: "τ = ωh".into(), limits: Some((0.0, 8.0)), ..Axis::default() },
            y: Axis { label: "R(τ)".into(), limits: Some((-4.0, 4.0)), ..Axis::default() },
            series,
            field: None,
        }
    };
    Figure {
        id: "oscillator-trace".into(),
        caption: "R(τ) of the recurrences; a method is stable where |R| ≤ 2. The exact R is 2 cos τ.".into(),
        data: "oscillator-trace".into(),
        panels: vec![panel("Path fitting", fitted), panel("Classical and Galerkin", others)],
        columns: 2,
    }
}

/// Rows of the golden `oscillator-stability`, with the ends that the closed forms give.
pub(crate) fn golden(_: &Context) -> Result<Vec<Row>, StudyError> {
    let oscillator = problem("harmonic-oscillator", &[])?;
    let mut rows = Vec::new();
    for method in integrators()? {
        let name = method.name();
        let closed = CLOSED_FORMS.into_iter().find(|form| form.0 == name);
        for (i, (from, to)) in stable(&mut map(&*method, &*oscillator)?)?.into_iter().enumerate() {
            for (end, tau) in [("from", from), ("to", to)] {
                let key = format!("{name} {} {end}", i + 1);
                if tau == 0.0 || tau == LARGEST {
                    rows.push(Row::text(key, if tau == 0.0 { "0" } else { "beyond" }));
                    continue;
                }
                // The derivative that vanishes there is known to some hundred roundings, and of slope 0.1 or more.
                let known = 1e3 * f64::EPSILON * tau;
                let row = Row::number(key, tau, Tolerance::absolute(known, "rounding over the slope at the root"));
                rows.push(match closed {
                    None => row,
                    Some((_, source, closed)) => {
                        let excess = |tau: f64| closed(tau * tau).abs() - 2.0;
                        let value = root([tau - 1e-3, tau + 1e-3], excess).ok_or("the closed form has no end there")?;
                        // |R| − 2 near its root: a dozen roundings of terms a hundred times as large as the result.
                        row.with_truth(Truth { value, allowance: 1e-9, source: format!("|R| = 2 in {source}") })
                    }
                });
            }
        }
    }
    Ok(rows)
}
