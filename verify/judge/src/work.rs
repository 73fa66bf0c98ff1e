//! Work and error of a method from a file beside those of lsvi, CVODE and diffsol: counted, not timed.

use rayon::prelude::*;

use super::counted::Counted;
use super::exhibits::table;
use super::method::FileMethod;
use super::problem::NonAutonomous;
use evidence::{Cell, Table};
use experiments::kinds::Principle;
use experiments::measure::norm::distance;
use experiments::method::{self, Method};
use experiments::problem::{self, Problem, Window};
use experiments::reference;
use experiments::run::run;

/// A solver at one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Its name.
    pub solver: String,
    /// Its step, or its tolerance.
    pub setting: f64,
    /// Steps, evaluations of f or of forces, and factorizations.
    pub work: [u64; 3],
    /// The largest error at the end.
    pub error: f64,
}

/// Where methods are compared, and with whom.
struct Field {
    problem: Box<dyn Problem>,
    name: &'static str,
    horizon: f64,
    rivals: &'static [&'static str],
}

/// Steps from the whole horizon on, each half of the one before.
const HALVINGS: i32 = 11;
/// Tolerances of the libraries.
const TOLERANCES: [f64; 7] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10];
/// Accuracy at which the work is told.
const TARGET: f64 = 1e-4;

fn field(method: &FileMethod, mechanical: bool) -> Result<Field, String> {
    if mechanical || method.principle() == Principle::Hamilton {
        let problem = problem::build("henon-heiles", &[]).map_err(|error| error.to_string())?;
        let rivals = &["stormer-verlet", "galerkin-gauss(2)", "implicit-midpoint", "rk4"];
        return Ok(Field { problem, name: "henon-heiles", horizon: 2.0, rivals });
    }
    if method.principle() == Principle::Equation {
        let problem = Box::new(NonAutonomous(Window { horizon: 2.0, coarsest: 0.1 }));
        let rivals = &["method-i", "rk4", "tr-bdf2", "bdf2", "implicit-midpoint"];
        return Ok(Field { problem, name: "the non-autonomous problem", horizon: 2.0, rivals });
    }
    let problem = problem::build("damped-pendulum", &[]).map_err(|error| error.to_string())?;
    let rivals = &["method-i", "rk4", "tr-bdf2", "bdf2", "implicit-midpoint"];
    Ok(Field { problem, name: "damped-pendulum", horizon: 2.0, rivals })
}

/// What every solver needs for what error; those that fail at a setting are left out there.
///
/// # Errors
/// Why there is nothing to compare.
pub(super) fn measure(method: &FileMethod, mechanical: bool) -> Result<(&'static str, Vec<Point>), String> {
    let Field { problem, name, horizon, rivals } = field(method, mechanical)?;
    let problem = &*problem;
    let exact = problem.exact(horizon).or_else(|| problem.tabulated(horizon));
    let exact = match exact {
        Some(exact) => exact,
        None => {
            let reference = reference::by_name("diffsol-tsit45").ok_or("no reference")?;
            let solved = reference.solve(problem.ode(), 0.0, &problem.initial(), &[horizon]);
            solved.map_err(|error| error.to_string())?.states.swap_remove(0)
        }
    };
    let rivals: Vec<Box<dyn Method>> = rivals.iter().filter_map(|rival| method::parse(rival).ok()).collect();
    let methods: Vec<&dyn Method> = std::iter::once(method as &dyn Method).chain(rivals.iter().map(|m| &**m)).collect();
    let fixed = methods.into_par_iter().flat_map_iter(|method| {
        let exact = &exact;
        (0..HALVINGS).filter_map(move |k| {
            let h = horizon * 0.5_f64.powi(k);
            // What a method counts itself is a stage here, all the equations of a step there.
            let counted = Counted::new(problem);
            let run = run(&counted, method, h, horizon, |_| {}).ok()?;
            let error = distance(&run.end.q, exact);
            let work = [run.work.steps, counted.count(), run.work.factorizations];
            Some(Point { solver: method.name(), setting: h, work, error })
        })
    });
    let mut points: Vec<Point> = fixed.collect();
    points.par_extend(reference::all().into_par_iter().flat_map_iter(|reference| {
        let exact = &exact;
        TOLERANCES.into_iter().filter_map(move |tolerance| {
            let run = reference.run(problem.ode(), 0.0, &problem.initial(), &[horizon], tolerance).ok()?;
            let work = [run.work.steps, run.work.rhs, run.work.factorizations];
            Some(Point {
                solver: reference.name().into(),
                setting: tolerance,
                work,
                error: distance(run.states.last()?, exact),
            })
        })
    }));
    points.retain(|point| point.error.is_finite());
    Ok((name, points))
}

/// The least work of each solver that is accurate to [`TARGET`], and what it is accurate to, in the order of the solvers.
pub(super) fn summary(problem: &str, points: &[Point]) -> String {
    let mut names: Vec<&str> = points.iter().map(|point| point.solver.as_str()).collect();
    names.dedup();
    let least = |name: &str| {
        let there = points.iter().filter(|point| point.solver == name && point.error <= TARGET);
        let least = there.min_by_key(|point| point.work[1]);
        let told = |point: &Point| format!("{} ({:.0e})", point.work[1], point.error);
        format!("{name} {}", least.map_or_else(|| "not reached".into(), told))
    };
    let counts: Vec<String> = names.into_iter().map(least).collect();
    format!(
        "evaluations of f, or of the forces, without Jacobians, of the cheapest run within an error of {TARGET:e} on {problem}, and its \
         error, steps being halved: {}",
        counts.join(", ")
    )
}

/// Every run.
pub(super) fn work_table(points: &[Point]) -> Table {
    let row = |point: &Point| {
        let counts = point.work.map(|count| Cell::Integer(count as i64));
        let mut row = vec![Cell::Text(point.solver.clone()), Cell::Number(point.setting)];
        row.extend(counts);
        row.push(Cell::Number(point.error));
        row
    };
    let caption = "Work and error of every run, fixed steps by h and the libraries by tolerance: steps, evaluations of f, or of the \
                   forces where a method takes them from a Lagrangian, factorizations.";
    let columns = ["solver", "h or tolerance", "steps", "evaluations", "factorizations", "error"];
    table("work", caption, &columns, points.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_told_is_the_fewest_evaluations_of_a_run_within_the_error_named() {
        let point =
            |solver: &str, work: [u64; 3], error: f64| Point { solver: solver.into(), setting: 0.1, work, error };
        let points = [
            point("one", [5, 20, 1], 2e-4),
            point("one", [20, 90, 2], 1e-6),
            point("one", [10, 40, 3], 1e-4),
            // Fewer steps of more evaluations each.
            point("one", [4, 50, 9], 5e-5),
            point("other", [3, 7, 4], 1e-3),
        ];
        let sentence = summary("a problem", &points);
        let (_, told) = sentence.split_once("steps being halved: ").expect(&sentence);
        assert_eq!(told, "one 40 (1e-4), other not reached");
    }

    /// A library takes several evaluations a step, and a factorization for several.
    #[test]
    fn the_work_of_a_library_is_steps_evaluations_and_factorizations() {
        let problem = NonAutonomous(Window { horizon: 2.0, coarsest: 0.1 });
        let reference = reference::by_name("diffsol-bdf").expect("always built");
        let run = reference.run(&problem, 0.0, &problem.initial(), &[2.0], 1e-8).expect("it solves it");
        assert!(run.work.rhs > run.work.steps && run.work.steps > run.work.factorizations, "{:?}", run.work);
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/it/gauss6.toml");
        let text = std::fs::read_to_string(file).expect("readable");
        let method = FileMethod::of(&crate::file::MethodFile::parse(file, "gauss6", &text).expect("a method"));
        let (_, points) = measure(&method, false).expect("something to compare");
        let point = points.iter().find(|it| it.solver == "diffsol-bdf" && it.setting == 1e-8).expect("it is there");
        assert!(point.work[1] > point.work[0] && point.work[0] > point.work[2], "{point:?}");
        // From the whole horizon on, but for those at which it fails.
        let steps: Vec<f64> = points.iter().filter(|it| it.solver == "rk4").map(|it| it.setting).collect();
        assert!(steps.len() > 5 && steps.windows(2).all(|pair| pair[1] == 0.5 * pair[0]), "{steps:?}");
        assert_eq!(steps.last(), Some(&(2.0 / 1024.0)));
    }

    #[test]
    fn work_is_compared_on_what_a_method_steps() {
        for (text, mechanical, name) in [
            ("a = [[0]]\nb = [1]\n", false, "the non-autonomous problem"),
            ("a = [[0]]\nb = [1]\n", true, "henon-heiles"),
            ("kind = 'path-fitted'\nnodes = ['1/4', '5/6']\n", false, "henon-heiles"),
            ("kind = 'closure'\nalpha = '0'\nbeta = '1'\n", false, "damped-pendulum"),
        ] {
            let file = crate::file::MethodFile::parse("m.toml", "m", text).expect("well-formed");
            let field = field(&FileMethod::of(&file), mechanical).expect("there is one");
            assert_eq!(field.name, name, "{text}");
        }
    }
}
