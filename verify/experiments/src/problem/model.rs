//! A first-order system from a file in DiffSL, diffsol's language, compiled when it is read.
//!
//! ```text
//! in_i { mu = 1 }              inputs with their defaults; `--set mu=5` sets one
//! u_i { x = 2, y = 0 }         the state and its value at t = 0
//! F_i { y, mu * (1 - x * x) * y - x }      f(t, u)
//! ```
//!
//! With `dudt_i` and `M_i` it states M u̇ = F(t, u) with a constant regular M, and f is M⁻¹F.

mod affine;
mod mass;
mod mistakes;
mod powers;
mod sums;

use std::collections::HashSet;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use diffsl::ast::{Ast, AstKind};
use diffsl::discretise::{DiscreteModel, Tensor};
use diffsl::execution::compiler::CompilerOptions;
use diffsl::parser::parse_ds_string;
use diffsl::{Compiler, CraneliftJitModule};
use lsvi::{Coloring, Differences, Jacobian, Structure, VectorField};
use nalgebra::DMatrix;

use self::affine::{Kind, kind_of};
use self::mass::Inverse;
use super::{Facts, Problem, Window};
use crate::measure::norm::Extremes;
use crate::measure::stability::spectral_abscissa;
use crate::panics::caught;
use crate::reference::Ode;

/// What every judgement on a model has to say.
pub const CAVEAT: &str = "The equations have one source, the model file: the methods and the references all solve what \
    DiffSL made of it. They check the methods; that the file states the right equations, nothing here checks.";

/// The end of measurements where none is given.
const HORIZON: f64 = 2.0;

/// The fastest rate of decay times the horizon from which a model counts as stiff: an explicit method needs that many steps, for what has
/// long died out.
const STIFF: f64 = 1e3;

/// Largest system whose eigenvalues are looked at for that; of larger ones ‖∂F/∂u‖∞ stands for them.
const DENSE: usize = 64;

/// Longest step over a model, as part of the time: of what f does between two evaluations nothing is known, and what lasts for longer,
/// as a dose may, is seen.
const LONGEST_STEP: f64 = 1e-3;

/// The parser and the compiler of DiffSL descend once for each operation of a sum and each parenthesis: so many bytes of stack for
/// a character, and for whatever else.
const STACK: usize = 1 << 12;
const LEAST_STACK: usize = 1 << 24;

/// Characters of a model at most.
const LONGEST: usize = 1 << 20;

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
    /// A text beyond what the stack of the compiler is made for.
    #[error("{} has {length} characters, and {LONGEST} are allowed; state sums over components as tensors, with indices", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Its length.
        length: usize,
    },
    /// There is no room for the stack of the compiler.
    #[error("cannot start the compiler of DiffSL for {}: {source}", path.display())]
    Stack {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A text that DiffSL's compiler does not survive.
    #[error("the compiler of DiffSL gave up on {}: {reason}", path.display())]
    GaveUp {
        /// The file.
        path: PathBuf,
        /// Its last words.
        reason: String,
    },
    /// A model beyond first-order systems M u̇ = F(t, u).
    #[error("{} is not of the form M du/dt = F(t, u): {reason}", path.display())]
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

/// A compiled model as a problem, with DiffSL's derivative products as Jacobian, in the sparsity that DiffSL derives from the text,
/// and differences of them as second derivatives.
pub struct Model {
    name: String,
    components: &'static [&'static str],
    initial: Vec<f64>,
    horizon: f64,
    /// ‖∂F/∂u‖ at the start.
    rate: f64,
    /// The fastest rate of decay there.
    decay: f64,
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
        // A mark of the byte order is no text.
        Self::named(path, code.strip_prefix('\u{feff}').unwrap_or(&code), set, horizon)
    }

    /// Compiles a text as [`Model::load`] does a file.
    ///
    /// # Errors
    /// As [`Model::load`] has, of a file called `model`.
    pub fn of_text(text: &str, set: &[(String, String)], horizon: Option<f64>) -> Result<Self, ModelError> {
        Self::named(Path::new("model"), text, set, horizon)
    }

    fn named(path: &Path, code: &str, set: &[(String, String)], horizon: Option<f64>) -> Result<Self, ModelError> {
        let horizon = horizon.unwrap_or(HORIZON);
        if !(horizon > 0.0 && horizon.is_finite()) {
            return Err(ModelError::Horizon(horizon));
        }
        if code.len() > LONGEST {
            return Err(ModelError::TooLong { path: path.into(), length: code.len() });
        }
        // The compiler is not made for every text that its grammar admits.
        let compile = || caught(|| Self::new(path, Compiled::new(path, code, set)?, horizon));
        let gave_up = |reason| ModelError::GaveUp { path: path.into(), reason };
        std::thread::scope(|scope| {
            let compiler = std::thread::Builder::new().stack_size(LEAST_STACK + STACK * code.len());
            let compiler = compiler.spawn_scoped(scope, compile);
            let compiler = compiler.map_err(|source| ModelError::Stack { path: path.into(), source })?;
            compiler.join().unwrap_or_else(|_| Err("no message".into())).map_err(gave_up)?
        })
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
        let n = initial.len();
        let dense = if n <= DENSE { n } else { 0 };
        let (mut rows, mut decays) = (vec![0.0; n], DMatrix::<f64>::zeros(dense, dense));
        equations.each_entry(0.0, &initial, |i, j, x| {
            rows[i] += x.abs();
            decays.get_mut((i, j)).into_iter().for_each(|entry| *entry -= x);
        });
        let rate = rows.into_iter().largest();
        let is_known = dense == n && decays.iter().all(|x| x.is_finite());
        let decay = Some(decays).filter(|_| is_known).map(|decays| spectral_abscissa(&decays));
        Ok(Self {
            name: path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy().into_owned()),
            components: components.leak(),
            initial,
            horizon,
            rate,
            // NaN where eigenvalues are not found.
            decay: decay.filter(|decay| !decay.is_nan()).unwrap_or(rate),
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

    fn ode(&self) -> &dyn Ode {
        &self.equations
    }

    fn facts(&self) -> Facts {
        let window = Window { horizon: self.horizon, coarsest: 0.1 * self.horizon };
        Facts { window, model: Some(self.rate), ..Facts::default() }
    }

    fn is_stiff(&self) -> bool {
        self.decay * self.horizon > STIFF
    }
}

/// The machine code, with the values of the inputs.
struct Compiled {
    compiler: Compiler<CraneliftJitModule, f64>,
    inputs: Vec<f64>,
    components: Vec<String>,
    mass: Inverse,
    structure: Structure,
    is_linear: bool,
    is_autonomous: bool,
    /// Groups of columns of ∂F/∂u that share no row.
    coloring: Coloring,
}

impl Compiled {
    fn new(path: &Path, code: &str, set: &[(String, String)]) -> Result<Self, ModelError> {
        let at = path.display().to_string();
        let syntax = parse_ds_string(code);
        let syntax = syntax.map_err(|e| ModelError::Compile(mistakes::syntax(&at, code, &e.to_string())))?;
        let syntax = powers::written_out(&syntax);
        let located = |message: String| ModelError::Compile(mistakes::located(&at, code, &message));
        if let Some(sums::Repeated { at, index }) = sums::repeated(&syntax) {
            let (line, column) = mistakes::position(code, at);
            let message = format!(
                "this is added once for each {index}, over which another part of the sum runs; let that part have a tensor of its own, as in \
                 p_i {{ a_ij * u_j }} F_i {{ p_i + b_i }}"
            );
            return Err(located(format!("Line {line}, Column {column}: Error: {message}")));
        }
        let mut model = DiscreteModel::build("model", &syntax).map_err(|e| located(e.as_error_message(code)))?;
        if let Some((name, what)) = beyond_first_order(&model) {
            let lines = mistakes::lines_with(code, name);
            let reason = format!("{name}_i{lines}, states {what}");
            return Err(ModelError::Form { path: path.into(), reason });
        }
        if let Some(name) = ambiguous(&model) {
            let lines = mistakes::lines_with(code, &name);
            let reason = format!(
                "`{name}` names two things{lines}, and only one of them would be meant by it; rename the other, or leave its name out where it is \
                 an entry"
            );
            return Err(ModelError::Form { path: path.into(), reason });
        }
        if model.state().rank() == 0 || model.rhs().rank() == 0 {
            let reason = "its state and f are vectors, with an index also where they have one component: u_i { x = 1 } F_i { -x }";
            return Err(ModelError::Form { path: path.into(), reason: reason.into() });
        }
        if let Some((offset, name)) = starts_in_time(&model) {
            let (line, column) = mistakes::position(code, offset);
            let message =
                format!("the state at t = 0 depends on time through {name}, which has no value there; state one");
            return Err(located(format!("Line {line}, Column {column}: Error: {message}")));
        }
        if let Some(reason) = unnamed_input(&model).or_else(|| misplaced_row(&model)) {
            return Err(ModelError::Form { path: path.into(), reason });
        }
        let inputs = inputs(path, model.input(), set)?;
        let compiler = Compiler::from_discrete_model(&model, CompilerOptions::default(), Some(code))
            .map_err(|e| located(e.to_string()))?;
        // An `in` without an index is a scalar to DiffSL, and an input to its compiler.
        if compiler.number_of_parameters() != inputs.len() {
            let lines = mistakes::lines_with(code, "in");
            let reason = format!("its inputs{lines} have no index; state them as `in_i {{ name = value }}`");
            return Err(ModelError::Form { path: path.into(), reason });
        }
        let components = labels(model.state());
        let mass = Inverse::of(&mut model, &compiler, &inputs).map_err(|reason| {
            let reason = format!("M_i{}, states a product {reason}", mistakes::lines_with(code, "M"));
            ModelError::Form { path: path.into(), reason }
        })?;
        let entries = model.take_rhs_state_deps();
        let structure = if mass.is_diagonal() { structure(components.len(), entries) } else { Structure::Dense };
        let coloring = Coloring::new(components.len(), &structure);
        let is_linear = kind_of(&model, model.rhs(), model.state(), Kind::OfTime) <= Kind::Affine;
        let is_autonomous = !has_time(&model);
        Ok(Self { compiler, inputs, components, mass, is_linear, is_autonomous, structure, coloring })
    }
}

/// What a model has beyond M u̇ = F(t, u), by its name.
fn beyond_first_order(model: &DiscreteModel) -> Option<(&'static str, &'static str)> {
    if model.stop().is_some() {
        Some((
            "stop",
            "events, at which no run here stops; leave it out, or stop at it in a program, by `lsvi::Trajectory::until`",
        ))
    } else if model.reset().is_some() {
        Some((
            "reset",
            "jumps, which no run here makes; a rate that changes at a time may stand in F, as heaviside(t - 1) does",
        ))
    } else if model.out().is_some() {
        Some(("out", "outputs, which nothing here computes; leave it out, and read the state"))
    } else {
        None
    }
}

/// A name that a tensor, or an element of one, shares with another, such as a component `u` with the state itself: DiffSL takes
/// one of the two without a word.
fn ambiguous(model: &DiscreteModel) -> Option<String> {
    let defined = [model.constant_defns(), model.input_dep_defns(), model.time_dep_defns(), model.state_dep_defns()];
    let vectors = [Some(model.state()), model.state_dot(), model.lhs(), Some(model.rhs())];
    let tensors = model.input().into_iter().chain(vectors.into_iter().flatten()).chain(defined.into_iter().flatten());
    let mut seen = HashSet::from([TIME]);
    for tensor in tensors {
        let elements = tensor.elmts().iter().filter_map(|block| block.name());
        if let Some(name) = std::iter::once(tensor.name()).chain(elements).find(|name| !seen.insert(*name)) {
            return Some(name.to_owned());
        }
    }
    None
}

/// A number without a name among inputs with names, as the second half of one with a decimal comma is.
fn unnamed_input(model: &DiscreteModel) -> Option<String> {
    let elements = model.input()?.elmts();
    let after = elements.iter().skip_while(|block| block.name().is_none());
    let value =
        after.filter(|block| block.name().is_none() && block.nnz() == 1).find_map(|block| constant(block.expr()))?;
    Some(format!("`{value}` among its inputs has no name; decimals have a point, as in in_i {{ k = 1.5 }}"))
}

/// A row of F, or a component of dudt, that is called the rate of another component than the one whose place it has: DiffSL goes by the
/// place.
fn misplaced_row(model: &DiscreteModel) -> Option<String> {
    let names = |tensor: &Tensor| -> Vec<Option<String>> {
        tensor.elmts().iter().map(|block| block.name().map(str::to_owned)).collect()
    };
    let components = names(model.state());
    let vectors = [Some(model.rhs()), model.state_dot()].into_iter().flatten();
    vectors.flat_map(|rates| names(rates).into_iter().zip(&components)).find_map(|(row, component)| {
        let (row, component) = (row?, component.as_ref()?);
        let meant = row.strip_prefix('d')?.strip_suffix("dt")?;
        let is_other = meant != component && components.iter().flatten().any(|other| other == meant);
        is_other.then(|| {
            format!("its row `{row}` is at the place of {component}; rows are in the order of the state, whatever they are called")
        })
    })
}

/// Where the initial state depends on a name that has a value in the course of time alone, and that name: DiffSL would take it for 0, or give
/// up on it.
fn starts_in_time<'a>(model: &DiscreteModel<'a>) -> Option<(usize, &'a str)> {
    let changing: HashSet<&str> =
        [TIME].into_iter().chain(model.time_dep_defns().iter().map(|tensor| tensor.name())).collect();
    model.state().elmts().iter().find_map(|block| {
        let name = block.expr().get_dependents().into_iter().find(|name| changing.contains(name))?;
        Some((block.expr().span?.pos_start, name))
    })
}

/// Whether the time occurs in F, or in what it is made of.
fn has_time(model: &DiscreteModel) -> bool {
    let mut blocks = model.state_dep_defns().iter().chain([model.rhs()]).flat_map(|tensor| tensor.elmts());
    !model.time_dep_defns().is_empty() || blocks.any(|block| block.expr().get_dependents().contains(TIME))
}

/// The name of the time in DiffSL.
const TIME: &str = "t";

/// The smallest system whose sparsity pays.
const SPARSE: usize = 16;

/// Where ∂F/∂u has entries, as DiffSL derives it from the text: as a band or a pattern where that is much less than all.
fn structure(dim: usize, entries: Vec<(usize, usize)>) -> Structure {
    let lower = entries.iter().map(|(i, j)| i.saturating_sub(*j)).max().unwrap_or(0);
    let upper = entries.iter().map(|(i, j)| j.saturating_sub(*i)).max().unwrap_or(0);
    if dim < SPARSE {
        Structure::Dense
    } else if 4 * (lower + upper + 1) <= dim {
        Structure::Banded { lower, upper }
    } else if 8 * entries.len() <= dim * dim {
        Structure::sparse(dim, entries).unwrap_or_default()
    } else {
        Structure::Dense
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

/// The right-hand side with work space of its own.
struct Equations {
    compiled: Arc<Compiled>,
    scratch: Mutex<Scratch>,
    differences: Mutex<Differences>,
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
        let differences = Mutex::new(Differences::new(initial.len(), &compiled.structure));
        Self { scratch: Mutex::new(scratch), differences, compiled }
    }

    fn evaluate(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let mut scratch = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        self.compiled.compiler.rhs(t, v, &mut scratch.data, dv);
        self.compiled.mass.solve(dv);
    }

    /// Calls `add(i, j, ∂f_i/∂v_j)`: one product for each group of columns that share no row.
    fn each_entry(&self, t: f64, v: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        let s = &mut *self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        // The products use the intermediate values at (t, v).
        self.compiled.compiler.rhs(t, v, &mut s.data, &mut s.value);
        let coloring = &self.compiled.coloring;
        let (mut at, mut is_beside) = (t, false);
        for c in 0..coloring.groups() {
            s.direction.fill(0.0);
            coloring.columns(c).for_each(|j| s.direction[j] = 1.0);
            loop {
                s.tangent.fill(0.0);
                s.product.fill(0.0);
                let (direction, product) = (&s.direction, &mut s.product);
                self.compiled.compiler.rhs_grad(at, v, direction, &s.data, &mut s.tangent, &s.value, product);
                if is_beside || s.product.iter().all(|x| x.is_finite()) {
                    break;
                }
                // A function of t alone adds 0 times its derivative, which is NaN where that is infinite, as of √t at 0, and there only.
                (at, is_beside) = (t.next_up(), true);
                self.compiled.compiler.rhs(at, v, &mut s.data, &mut s.value);
            }
            self.compiled.mass.solve(&mut s.product);
            coloring.entries(c).filter(|(i, _)| s.product[*i] != 0.0).for_each(|(i, j)| add(i, j, s.product[i]));
        }
    }
}

impl VectorField for Equations {
    fn dim(&self) -> usize {
        self.compiled.components.len()
    }

    fn structure(&self) -> Structure {
        self.compiled.structure.clone()
    }

    fn is_linear(&self) -> bool {
        self.compiled.is_linear
    }

    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.evaluate(t, v, dv);
    }

    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.each_entry(t, v, |i, j, x| out.add(i, j, scale * x));
    }

    /// From differences of Jacobians: DiffSL has no second derivatives.
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        if !self.compiled.is_linear {
            let mut differences = self.differences.lock().unwrap_or_else(PoisonError::into_inner);
            differences.add_curvature(self, t, v, w, scale, out);
        }
    }
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

    fn bandwidths(&self) -> Option<(usize, usize)> {
        match self.compiled.structure {
            Structure::Banded { lower, upper } => Some((lower, upper)),
            _ => None,
        }
    }

    fn is_sparse(&self) -> bool {
        self.compiled.structure != Structure::Dense
    }

    fn is_autonomous(&self) -> bool {
        self.compiled.is_autonomous
    }

    fn longest_step(&self, span: f64) -> f64 {
        LONGEST_STEP * span
    }
}
