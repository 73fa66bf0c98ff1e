//! A first-order system from a file in DiffSL, diffsol's language, compiled when it is read.
//!
//! ```text
//! in_i { mu = 1 }              inputs with their defaults; `--set mu=5` sets one
//! u_i { x = 2, y = 0 }         the state and its value at t = 0
//! F_i { y, mu * (1 - x * x) * y - x }      f(t, u)
//! ```

use std::fmt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use diffsl::ast::{Ast, AstKind};
use diffsl::discretise::{DiscreteModel, Tensor};
use diffsl::execution::compiler::CompilerOptions;
use diffsl::parser::parse_ds_string;
use diffsl::{Compiler, CraneliftJitModule};
use lsvi::{Jacobian, VectorField};

use super::{Facts, Problem, Window};
use crate::measure::norm::Extremes;
use crate::reference::Ode;

/// What every judgement on a model has to say.
pub const CAVEAT: &str = "The equations have one source, the model file: the methods and the references all solve what \
    DiffSL made of it. They check the methods; that the file states the right equations, nothing here checks.";

/// The end of measurements where none is given.
const HORIZON: f64 = 2.0;

/// ‖∂f/∂u‖∞ times the horizon from which a model counts as stiff: an explicit method needs that many steps or more.
const STIFF: f64 = 1e3;

/// A model that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The file is no DiffSL.
    #[error("the model does not compile\n{0}")]
    Compile(String),
    /// A model beyond first-order systems u̇ = F(t, u).
    #[error("{} is not of the form du/dt = F(t, u): {reason}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// What it has that is not supported.
        reason: String,
    },
    /// A value for an input that the model does not have.
    #[error("{} has no input `{name}`; it has {}", path.display(), list(known))]
    Input {
        /// The file.
        path: PathBuf,
        /// The offending name.
        name: String,
        /// The names it has.
        known: Vec<String>,
    },
    /// A value that is no finite number: of an input, the initial state, or the end time.
    #[error("{name} = {value}: not a finite number")]
    Value {
        /// What has the value.
        name: String,
        /// The value.
        value: String,
    },
    /// An end time of the measurements that is not positive.
    #[error("end time {0} must be positive and finite")]
    Horizon(f64),
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

/// A compiled model as a problem, with DiffSL's derivative products as Jacobian and no second derivatives: the Newton
/// iterations of the least-squares methods become Gauss and Newton's.
pub struct Model {
    name: String,
    components: &'static [&'static str],
    initial: Vec<f64>,
    horizon: f64,
    is_stiff: bool,
    equations: Equations,
}

impl Model {
    /// Compiles the file at `path`, with the inputs `set` instead of their defaults. Measurements end at `horizon`, 2 if
    /// there is none.
    ///
    /// # Errors
    /// [`ModelError`] with the file, the line and its text where the model is at fault.
    pub fn load(path: &Path, set: &[(String, String)], horizon: Option<f64>) -> Result<Self, ModelError> {
        let code = std::fs::read_to_string(path).map_err(|source| ModelError::Read { path: path.into(), source })?;
        let horizon = horizon.unwrap_or(HORIZON);
        if !(horizon > 0.0 && horizon.is_finite()) {
            return Err(ModelError::Horizon(horizon));
        }
        // The compiler is not made for every text that its grammar admits.
        let compiled = catch_unwind(AssertUnwindSafe(|| Compiled::new(path, &code, set)));
        let compiled = compiled.unwrap_or_else(|_| {
            Err(ModelError::Compile(format!("{}: the compiler of DiffSL gave up without an error", path.display())))
        })?;
        Self::new(path, compiled, horizon)
    }

    fn new(path: &Path, compiled: Compiled, horizon: f64) -> Result<Self, ModelError> {
        // A program has few models, and the names live as long as it does.
        let components: Vec<&'static str> =
            compiled.components.iter().map(|name| &*Box::leak(name.clone().into_boxed_str())).collect();
        let mut initial = vec![0.0; components.len()];
        let equations = Equations::new(Arc::new(compiled), &mut initial);
        if let Some((name, value)) = components.iter().zip(&initial).find(|(_, x)| !x.is_finite()) {
            return Err(ModelError::Value { name: format!("{name} at t = 0"), value: value.to_string() });
        }
        let mut rows = vec![0.0; initial.len()];
        equations.each_entry(0.0, &initial, |i, _, x| rows[i] += x.abs());
        let norm = rows.into_iter().largest();
        Ok(Self {
            name: path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy().into_owned()),
            components: components.leak(),
            initial,
            horizon,
            is_stiff: norm * horizon > STIFF,
            equations,
        })
    }

    /// The name of the file without its directory and extension.
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl fmt::Debug for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Model").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Problem for Model {
    fn components(&self) -> &'static [&'static str] {
        self.components
    }

    fn initial(&self) -> Vec<f64> {
        self.initial.clone()
    }

    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(Equations::new(Arc::clone(&self.equations.compiled), &mut self.initial()))
    }

    fn has_curvature(&self) -> bool {
        false
    }

    fn ode(&self) -> &dyn Ode {
        &self.equations
    }

    fn facts(&self) -> Facts {
        let window = Window { horizon: self.horizon, coarsest: 0.1 * self.horizon };
        Facts { window, ..Facts::default() }
    }

    fn is_stiff(&self) -> bool {
        self.is_stiff
    }

    fn horizon(&self) -> f64 {
        self.horizon
    }
}

/// The machine code, with the values of the inputs.
struct Compiled {
    compiler: Compiler<CraneliftJitModule, f64>,
    inputs: Vec<f64>,
    components: Vec<String>,
}

impl Compiled {
    fn new(path: &Path, code: &str, set: &[(String, String)]) -> Result<Self, ModelError> {
        let at = path.display().to_string();
        let syntax = parse_ds_string(code).map_err(|e| ModelError::Compile(e.with_path(&at).to_string()))?;
        let located = |message: String| ModelError::Compile(located(&at, code, &message));
        let model = DiscreteModel::build("model", &syntax).map_err(|e| located(e.as_error_message(code)))?;
        if let Some(reason) = beyond_first_order(&model) {
            return Err(ModelError::Form { path: path.into(), reason: reason.into() });
        }
        let inputs = inputs(path, model.input(), set)?;
        let compiler = Compiler::from_discrete_model(&model, CompilerOptions::default(), Some(code))
            .map_err(|e| located(e.to_string()))?;
        Ok(Self { compiler, inputs, components: labels(model.state()) })
    }
}

/// What a model has beyond u̇ = F(t, u).
fn beyond_first_order(model: &DiscreteModel) -> Option<&'static str> {
    if model.lhs().is_some() {
        Some("M_i states a mass matrix or algebraic equations; solve for the derivatives, and leave M_i and dudt_i out")
    } else if model.stop().is_some() {
        Some("stop_i states events")
    } else if model.reset().is_some() {
        Some("reset_i states jumps")
    } else {
        None
    }
}

/// The names of a vector's elements; `u[1]` for one without.
fn labels(tensor: &Tensor) -> Vec<String> {
    let mut labels = Vec::with_capacity(tensor.nnz());
    for block in tensor.elmts() {
        for k in 0..block.nnz() {
            labels.push(match block.name() {
                Some(name) if block.nnz() == 1 => name.to_owned(),
                Some(name) => format!("{name}[{k}]"),
                None => format!("{}[{}]", tensor.name(), labels.len()),
            });
        }
    }
    labels
}

/// The value of every input: what is set, else its default.
fn inputs(path: &Path, tensor: Option<&Tensor>, set: &[(String, String)]) -> Result<Vec<f64>, ModelError> {
    let names = tensor.map_or_else(Vec::new, labels);
    let blocks = tensor.into_iter().flat_map(|tensor| tensor.elmts());
    let defaults = blocks.flat_map(|block| std::iter::repeat_n(constant(block.expr()), block.nnz()));
    let mut values = Vec::with_capacity(names.len());
    for (name, default) in names.iter().zip(defaults) {
        let reason = || format!("the default of its input `{name}` is no number");
        values.push(default.ok_or_else(|| ModelError::Form { path: path.into(), reason: reason() })?);
    }
    for (name, value) in set {
        let unknown = || ModelError::Input { path: path.into(), name: name.clone(), known: names.clone() };
        let i = names.iter().position(|known| known == name).ok_or_else(unknown)?;
        let x = value.parse::<f64>().ok().filter(|x| x.is_finite());
        values[i] = x.ok_or_else(|| ModelError::Value { name: name.clone(), value: value.clone() })?;
    }
    Ok(values)
}

/// The value of a number with or without a sign.
fn constant(expression: &Ast) -> Option<f64> {
    match &expression.kind {
        AstKind::Number(x) => Some(*x),
        AstKind::Integer(n) => Some(*n as f64),
        AstKind::Monop(signed) => Some(constant(&signed.child)? * if signed.op == '-' { -1.0 } else { 1.0 }),
        _ => None,
    }
}

/// Every message with the file and the line it speaks of, as far as it says: `Line l, Column c: Error: text`.
fn located(path: &str, code: &str, messages: &str) -> String {
    let lines = messages.lines().filter(|line| !line.trim().is_empty());
    let show = |message| match place(code, message) {
        Some((line, column, text)) => {
            let shown = code.lines().nth(line.saturating_sub(1)).unwrap_or_default();
            let (margin, indent) = (" ".repeat(line.to_string().len()), " ".repeat(column.saturating_sub(1)));
            format!(
                "{margin}--> {path}:{line}:{column}\n{margin} |\n{line} | {shown}\n{margin} | {indent}^\n{margin} = {text}"
            )
        }
        None => format!("{path}: {}", message.trim_start_matches("Error: ")),
    };
    lines.map(show).collect::<Vec<_>>().join("\n")
}

/// Line, column and text of a message; where it names a function only, those of the first call.
fn place<'a>(code: &str, message: &'a str) -> Option<(usize, usize, &'a str)> {
    if let Some(name) = message.strip_prefix("unknown function call '").and_then(|rest| rest.strip_suffix('\'')) {
        let before = &code[..code.find(&format!("{name}("))?];
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        return Some((before.matches('\n').count() + 1, before[start..].chars().count() + 1, message));
    }
    let (line, rest) = message.strip_prefix("Line ")?.split_once(", Column ")?;
    let (column, text) = rest.split_once(": Error: ")?;
    Some((line.parse().ok()?, column.parse().ok()?, text))
}

/// The right-hand side with work space of its own.
struct Equations {
    compiled: Arc<Compiled>,
    scratch: Mutex<Scratch>,
}

/// What the machine code writes to: intermediate values, their derivatives, and f.
struct Scratch {
    data: Vec<f64>,
    tangent: Vec<f64>,
    value: Vec<f64>,
    direction: Vec<f64>,
    product: Vec<f64>,
}

impl Equations {
    /// Sets the inputs, and writes the state at t = 0 to `initial`.
    fn new(compiled: Arc<Compiled>, initial: &mut [f64]) -> Self {
        let zeros = || vec![0.0; compiled.components.len()];
        let (mut data, tangent) = (compiled.compiler.get_new_data(), compiled.compiler.get_new_data());
        compiled.compiler.set_inputs(&compiled.inputs, &mut data, 0);
        compiled.compiler.set_u0(initial, &mut data);
        let scratch = Scratch { data, tangent, value: zeros(), direction: zeros(), product: zeros() };
        Self { scratch: Mutex::new(scratch), compiled }
    }

    fn evaluate(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let mut scratch = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        self.compiled.compiler.rhs(t, v, &mut scratch.data, dv);
    }

    /// Calls `add(i, j, ∂f_i/∂v_j)`, a column at a time, each a product with a unit vector.
    fn each_entry(&self, t: f64, v: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        let s = &mut *self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        // The products use the intermediate values at (t, v).
        self.compiled.compiler.rhs(t, v, &mut s.data, &mut s.value);
        for j in 0..v.len() {
            s.direction.fill(0.0);
            s.direction[j] = 1.0;
            s.tangent.fill(0.0);
            s.product.fill(0.0);
            let (direction, product) = (&s.direction, &mut s.product);
            self.compiled.compiler.rhs_grad(t, v, direction, &s.data, &mut s.tangent, &s.value, product);
            product.iter().enumerate().filter(|(_, x)| **x != 0.0).for_each(|(i, x)| add(i, j, *x));
        }
    }
}

impl VectorField for Equations {
    fn dim(&self) -> usize {
        self.compiled.components.len()
    }

    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.evaluate(t, v, dv);
    }

    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.each_entry(t, v, |i, j, x| out.add(i, j, scale * x));
    }

    /// Nothing: DiffSL has no second derivatives, and Gauss and Newton's iteration does without.
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

impl Ode for Equations {
    fn dim(&self) -> usize {
        self.compiled.components.len()
    }

    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.evaluate(t, v, dv);
    }

    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        self.each_entry(t, v, add);
    }
}
