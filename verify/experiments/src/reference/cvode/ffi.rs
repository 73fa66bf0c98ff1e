//! The calls into SUNDIALS, the only unsafe code of the project, tests apart.

use std::ffi::{CStr, c_char, c_int, c_long, c_void};
use std::marker::PhantomData;
use std::{ptr, slice};

use sundials_sys as sys;

use super::call::{CallError, Speaker};
use super::callbacks::{Callbacks, Refused, Storage};
use crate::reference::{MAX_STEPS, Work};

// What the bindings leave out.
unsafe extern "C" {
    fn SUNDIALSGetVersion(version: *mut c_char, len: c_int) -> c_int;
    fn free(allocated: *mut c_void);
}

/// Directions that GMRES keeps; CVODE's own five are meant for loose tolerances too.
const DIRECTIONS: c_int = 30;

/// CVODE's families of formulas.
#[derive(Debug, Clone, Copy)]
pub(super) enum Formulas {
    Bdf,
    Adams,
}

/// The version of the SUNDIALS library that runs, which need not be the one compiled against.
pub(super) fn version() -> String {
    let mut version: [c_char; 64] = [0; 64];
    // SAFETY: SUNDIALS writes no more characters than it is told, one less than the buffer holds, so that a zero ends the string.
    unsafe {
        SUNDIALSGetVersion(version.as_mut_ptr(), version.len() as c_int - 1);
        CStr::from_ptr(version.as_ptr()).to_string_lossy().into_owned()
    }
}

/// Something that SUNDIALS allocated, freed when dropped.
struct Owned<P: Copy> {
    raw: P,
    free: fn(P),
}

impl<T> Owned<*mut T> {
    /// Takes over what `call` returned; SUNDIALS reports failure by a null pointer.
    fn new(raw: *mut T, free: fn(*mut T), call: &'static str) -> Result<Self, CallError> {
        if raw.is_null() { Err(CallError::Null(call)) } else { Ok(Owned { raw, free }) }
    }
}

impl<P: Copy> Drop for Owned<P> {
    fn drop(&mut self) {
        (self.free)(self.raw);
    }
}

/// A solve under way.
///
/// The fields are dropped in the order of their declaration, each before what it was made from.
pub(super) struct Session<'a> {
    memory: Owned<*mut c_void>,
    _linear_solver: Owned<sys::SUNLinearSolver>,
    _matrix: Option<Owned<sys::SUNMatrix>>,
    state: Owned<sys::N_Vector>,
    _context: Owned<sys::SUNContext>,
    /// CVODE keeps the address of the callbacks.
    callbacks: PhantomData<&'a Callbacks<'a>>,
}

impl<'a> Session<'a> {
    /// Prepares a solve from `(t0, v0)` with relative and absolute tolerance `tolerance`.
    ///
    /// # Errors
    /// Names the call that failed.
    pub(super) fn new(
        formulas: Formulas,
        t0: f64,
        v0: &[f64],
        tolerance: f64,
        callbacks: &'a Callbacks<'a>,
    ) -> Result<Self, CallError> {
        assert_eq!(v0.len(), callbacks.dim(), "CVODE's vectors have the length that the callbacks believe in");
        let context = new_context()?;
        let state = new_vector(v0, &context)?;
        let (linear_solver, matrix) = new_linear_solver(callbacks, &state, &context)?;
        let memory = new_memory(formulas, &context)?;
        let user_data = ptr::from_ref(callbacks).cast_mut().cast::<c_void>();
        // SAFETY: the pointers are live and belong together (one context, one dimension). `user_data` outlives the session by 'a,
        // and both callbacks turn it back into the shared reference that it is. CVODE copies the initial state.
        unsafe {
            messages::redirect(context.raw, memory.raw, user_data)?;
            check("CVodeInit", sys::CVodeInit(memory.raw, Some(on_rhs), t0, state.raw))?;
            check("CVodeSStolerances", sys::CVodeSStolerances(memory.raw, tolerance, tolerance))?;
            check("CVodeSetUserData", sys::CVodeSetUserData(memory.raw, user_data))?;
            // From one sample to the next; CVODE's own limit of 500 is meant for loose tolerances.
            check("CVodeSetMaxNumSteps", sys::CVodeSetMaxNumSteps(memory.raw, c_long::from(MAX_STEPS)))?;
            let raw = matrix.as_ref().map_or(ptr::null_mut(), |matrix| matrix.raw);
            check_linear("CVodeSetLinearSolver", sys::CVodeSetLinearSolver(memory.raw, linear_solver.raw, raw))?;
            if matrix.is_some() {
                check_linear("CVodeSetJacFn", sys::CVodeSetJacFn(memory.raw, Some(on_jacobian)))?;
            } else {
                check_linear("CVodeSetJacTimes", sys::CVodeSetJacTimes(memory.raw, None, Some(on_product)))?;
            }
        }
        Ok(Session {
            memory,
            _linear_solver: linear_solver,
            _matrix: matrix,
            state,
            _context: context,
            callbacks: PhantomData,
        })
    }

    /// Forbids evaluations beyond `t`.
    ///
    /// # Errors
    /// Names the call that failed.
    pub(super) fn stop_at(&mut self, t: f64) -> Result<(), CallError> {
        // SAFETY: the memory is live.
        check("CVodeSetStopTime", unsafe { sys::CVodeSetStopTime(self.memory.raw, t) })
    }

    /// Takes no step longer than `h`, if that is finite.
    ///
    /// # Errors
    /// Names the call that failed.
    pub(super) fn step_at_most(&mut self, h: f64) -> Result<(), CallError> {
        // CVODE takes 0 for no limit.
        let longest = if h.is_finite() { h } else { 0.0 };
        // SAFETY: the memory is live.
        check("CVodeSetMaxStep", unsafe { sys::CVodeSetMaxStep(self.memory.raw, longest) })
    }

    /// Integrates past `t` and writes the state there into `v`.
    ///
    /// # Errors
    /// Names the call that failed.
    pub(super) fn advance_to(&mut self, t: f64, v: &mut [f64]) -> Result<(), CallError> {
        let mut reached = t;
        // SAFETY: the session's pointers are live, `reached` is writable, and the state vector is not borrowed during the call.
        unsafe {
            check("CVode", sys::CVode(self.memory.raw, t, self.state.raw, &mut reached, sys::CV_NORMAL))?;
            v.copy_from_slice(entries(self.state.raw, v.len()));
        }
        Ok(())
    }

    /// How far CVODE has come.
    ///
    /// # Errors
    /// Names the call that failed.
    pub(super) fn current_time(&self) -> Result<f64, CallError> {
        let mut t = 0.0;
        // SAFETY: the memory is live and `t` is writable.
        check("CVodeGetCurrentTime", unsafe { sys::CVodeGetCurrentTime(self.memory.raw, &mut t) })?;
        Ok(t)
    }

    /// Work since the start.
    ///
    /// # Errors
    /// Names the call that failed.
    pub(super) fn work(&self) -> Result<Work, CallError> {
        let (mut steps, mut rhs, mut jacobians, mut factorizations, mut products) = (0, 0, 0, 0, 0);
        // SAFETY: the memory is live and the counters are writable.
        unsafe {
            check("CVodeGetNumSteps", sys::CVodeGetNumSteps(self.memory.raw, &mut steps))?;
            check("CVodeGetNumRhsEvals", sys::CVodeGetNumRhsEvals(self.memory.raw, &mut rhs))?;
            check_linear("CVodeGetNumJtimesEvals", sys::CVodeGetNumJtimesEvals(self.memory.raw, &mut products))?;
            check_linear("CVodeGetNumJacEvals", sys::CVodeGetNumJacEvals(self.memory.raw, &mut jacobians))?;
            check("CVodeGetNumLinSolvSetups", sys::CVodeGetNumLinSolvSetups(self.memory.raw, &mut factorizations))?;
        }
        // Counters start at zero and grow.
        let count = c_long::unsigned_abs;
        Ok(Work {
            steps: count(steps),
            rhs: count(rhs),
            jacobians: count(jacobians),
            factorizations: count(factorizations),
            products: count(products),
        })
    }
}

/// What SUNDIALS calls a code of its own; the number where it has no name for it.
pub(super) fn name(speaker: Speaker, code: c_int) -> String {
    let names = match speaker {
        Speaker::Solver => sys::CVodeGetReturnFlagName,
        Speaker::LinearSolver => sys::CVodeGetLinReturnFlagName,
        Speaker::Library => return code.to_string(),
    };
    // SAFETY: both accept any code and return a zero-terminated string from malloc, which is copied and freed.
    unsafe {
        let raw = names(c_long::from(code));
        if raw.is_null() {
            return code.to_string();
        }
        let name = CStr::from_ptr(raw).to_string_lossy().into_owned();
        free(raw.cast());
        name
    }
}

fn check(call: &'static str, code: c_int) -> Result<(), CallError> {
    Speaker::Solver.check(call, code)
}

fn check_linear(call: &'static str, code: c_int) -> Result<(), CallError> {
    Speaker::LinearSolver.check(call, code)
}

fn new_context() -> Result<Owned<sys::SUNContext>, CallError> {
    let mut raw = ptr::null_mut();
    // SAFETY: `raw` is writable; without MPI there is no communicator.
    let code = unsafe { sys::SUNContext_Create(sys::comm_no_mpi(), &mut raw) };
    Speaker::Library.check("SUNContext_Create", code)?;
    // SAFETY: called once with the context that was created, after everything that uses it.
    Owned::new(
        raw,
        |mut raw| unsafe {
            let _ = sys::SUNContext_Free(&mut raw);
        },
        "SUNContext_Create",
    )
}

fn new_vector(v: &[f64], context: &Owned<sys::SUNContext>) -> Result<Owned<sys::N_Vector>, CallError> {
    // SAFETY: the context is live; the vector is destroyed once.
    let vector = unsafe {
        Owned::new(sys::N_VNew_Serial(index(v.len()), context.raw), |raw| sys::N_VDestroy(raw), "N_VNew_Serial")?
    };
    // SAFETY: a live serial vector of that length, to which nobody else refers.
    unsafe { entries_mut(vector.raw, v.len()) }.copy_from_slice(v);
    Ok(vector)
}

/// The solver for the storage of the Jacobian, and the matrix where there is one.
fn new_linear_solver(
    callbacks: &Callbacks,
    state: &Owned<sys::N_Vector>,
    context: &Owned<sys::SUNContext>,
) -> Result<(Owned<sys::SUNLinearSolver>, Option<Owned<sys::SUNMatrix>>), CallError> {
    let n = index(callbacks.dim());
    // SAFETY: the context is live and the bandwidths are less than the dimension; the matrix is destroyed once.
    let matrix = unsafe {
        let owned = |raw, call| Owned::new(raw, |raw| sys::SUNMatDestroy(raw), call).map(Some);
        match callbacks.storage() {
            Storage::Dense => owned(sys::SUNDenseMatrix(n, n, context.raw), "SUNDenseMatrix")?,
            Storage::Banded { lower, upper } => {
                owned(sys::SUNBandMatrix(n, index(upper), index(lower), context.raw), "SUNBandMatrix")?
            }
            Storage::None => None,
        }
    };
    // SAFETY: vector and matrix are live, of one dimension and from this context, and the solver is of the matrix's kind; it is
    // freed once.
    let solver = unsafe {
        let (raw, call) = match (callbacks.storage(), &matrix) {
            (Storage::Banded { .. }, Some(matrix)) => {
                (sys::SUNLinSol_Band(state.raw, matrix.raw, context.raw), "SUNLinSol_Band")
            }
            (_, Some(matrix)) => (sys::SUNLinSol_Dense(state.raw, matrix.raw, context.raw), "SUNLinSol_Dense"),
            (_, None) => {
                let unpreconditioned = sys::SUN_PREC_NONE as c_int;
                (sys::SUNLinSol_SPGMR(state.raw, unpreconditioned, DIRECTIONS, context.raw), "SUNLinSol_SPGMR")
            }
        };
        Owned::new(
            raw,
            |raw| {
                let _ = sys::SUNLinSolFree(raw);
            },
            call,
        )?
    };
    Ok((solver, matrix))
}

fn new_memory(formulas: Formulas, context: &Owned<sys::SUNContext>) -> Result<Owned<*mut c_void>, CallError> {
    let formulas = match formulas {
        Formulas::Bdf => sys::CV_BDF,
        Formulas::Adams => sys::CV_ADAMS,
    };
    // SAFETY: the context is live; the memory is freed once, before the context.
    unsafe { Owned::new(sys::CVodeCreate(formulas, context.raw), |mut raw| sys::CVodeFree(&mut raw), "CVodeCreate") }
}

/// SUNDIALS' indices are signed; no vector in memory has a length beyond them.
fn index(n: usize) -> sys::sunindextype {
    n as sys::sunindextype
}

/// The entries of a serial vector.
///
/// # Safety
/// `vector` is a live serial vector of length `dim`, and nobody writes to it for the lifetime of the slice.
unsafe fn entries<'v>(vector: sys::N_Vector, dim: usize) -> &'v [f64] {
    // SAFETY: by the caller's promise.
    unsafe { slice::from_raw_parts(sys::N_VGetArrayPointer(vector), dim) }
}

/// The entries of a serial vector, to be written.
///
/// # Safety
/// `vector` is a live serial vector of length `dim`, and nobody else refers to it for the lifetime of the slice.
unsafe fn entries_mut<'v>(vector: sys::N_Vector, dim: usize) -> &'v mut [f64] {
    // SAFETY: by the caller's promise.
    unsafe { slice::from_raw_parts_mut(sys::N_VGetArrayPointer(vector), dim) }
}

/// What a callback returns to CVODE: zero, or a negative number that makes it stop.
fn code(answer: Result<(), Refused>) -> c_int {
    if answer.is_ok() { 0 } else { -1 }
}

unsafe extern "C" fn on_rhs(t: f64, v: sys::N_Vector, dv: sys::N_Vector, user_data: *mut c_void) -> c_int {
    // SAFETY: `user_data` is the reference that the session passed on, alive as long as the session; the two vectors are distinct
    // clones of the state vector, so of its length.
    let (callbacks, v, dv) = unsafe {
        let callbacks = &*user_data.cast::<Callbacks>();
        (callbacks, entries(v, callbacks.dim()), entries_mut(dv, callbacks.dim()))
    };
    code(callbacks.rhs(t, v, dv))
}

unsafe extern "C" fn on_product(
    x: sys::N_Vector,
    out: sys::N_Vector,
    t: f64,
    v: sys::N_Vector,
    _f: sys::N_Vector,
    user_data: *mut c_void,
    _: sys::N_Vector,
) -> c_int {
    // SAFETY: as in `on_rhs`; `out` is another vector than `x` and `v`.
    let (callbacks, v, x, out) = unsafe {
        let callbacks = &*user_data.cast::<Callbacks>();
        let n = callbacks.dim();
        (callbacks, entries(v, n), entries(x, n), entries_mut(out, n))
    };
    code(callbacks.product(t, v, x, out))
}

/// Adds to a matrix that CVODE has set to zero.
unsafe extern "C" fn on_jacobian(
    t: f64,
    v: sys::N_Vector,
    _f: sys::N_Vector,
    jacobian: sys::SUNMatrix,
    user_data: *mut c_void,
    _: sys::N_Vector,
    _: sys::N_Vector,
    _: sys::N_Vector,
) -> c_int {
    // SAFETY: as in `on_rhs`.
    let (callbacks, v) = unsafe {
        let callbacks = &*user_data.cast::<Callbacks>();
        (callbacks, entries(v, callbacks.dim()))
    };
    let banded = callbacks.storage() != Storage::Dense;
    code(callbacks.jacobian(t, v, |i, j, x| {
        // SAFETY: `Callbacks::jacobian` passes on only entries that lie inside the matrix and its band. A column pointer is to
        // row 0 of a dense matrix, and to the diagonal of a banded one.
        unsafe {
            let entry = if banded {
                sys::SUNBandMatrix_Column(jacobian, index(j)).offset(i as isize - j as isize)
            } else {
                sys::SUNDenseMatrix_Column(jacobian, index(j)).add(i)
            };
            *entry += x;
        }
    }))
}

/// SUNDIALS writes its messages to standard error; here the callbacks keep the last one.
///
/// SUNDIALS 6 reports through CVODE's memory, SUNDIALS 7 through the context, and each lacks the other's functions.
mod messages {
    use super::*;

    /// Sends the messages to the callbacks behind `user_data`.
    ///
    /// # Safety
    /// `context` and `memory` are live, and `user_data` is a pointer to `Callbacks` that outlives them.
    pub(super) unsafe fn redirect(
        context: sys::SUNContext,
        memory: *mut c_void,
        user_data: *mut c_void,
    ) -> Result<(), CallError> {
        // Takes precedence over the stand-ins outside this function for what the version at hand does have.
        #[allow(unused_imports)]
        use sys::*;
        // SAFETY: by the caller's promise; the handlers take what the version at hand passes.
        unsafe {
            check("CVodeSetErrHandlerFn", CVodeSetErrHandlerFn(memory, Some(on_message_6), user_data))?;
            check("SUNContext_ClearErrHandlers", SUNContext_ClearErrHandlers(context))?;
            check("SUNContext_PushErrHandler", SUNContext_PushErrHandler(context, Some(on_message_7), user_data))
        }
    }

    type Handler6 = unsafe extern "C" fn(c_int, *const c_char, *const c_char, *mut c_char, *mut c_void);
    type Handler7 =
        unsafe extern "C" fn(c_int, *const c_char, *const c_char, *const c_char, c_int, *mut c_void, sys::SUNContext);

    #[allow(dead_code, non_snake_case)]
    fn CVodeSetErrHandlerFn(_memory: *mut c_void, _handler: Option<Handler6>, _data: *mut c_void) -> c_int {
        0
    }

    #[allow(dead_code, non_snake_case)]
    fn SUNContext_ClearErrHandlers(_context: sys::SUNContext) -> c_int {
        0
    }

    #[allow(dead_code, non_snake_case)]
    fn SUNContext_PushErrHandler(_context: sys::SUNContext, _handler: Option<Handler7>, _data: *mut c_void) -> c_int {
        0
    }

    unsafe extern "C" fn on_message_6(
        _code: c_int,
        _module: *const c_char,
        _function: *const c_char,
        message: *mut c_char,
        user_data: *mut c_void,
    ) {
        // SAFETY: SUNDIALS passes a zero-terminated string and the `user_data` of `redirect`.
        unsafe { note(message, user_data) }
    }

    unsafe extern "C" fn on_message_7(
        _line: c_int,
        _function: *const c_char,
        _file: *const c_char,
        message: *const c_char,
        _code: c_int,
        user_data: *mut c_void,
        _context: sys::SUNContext,
    ) {
        // SAFETY: SUNDIALS passes a zero-terminated string or null, and the `user_data` of `redirect`.
        unsafe { note(message, user_data) }
    }

    /// # Safety
    /// `message` is null or a zero-terminated string, `user_data` a pointer to live `Callbacks`.
    unsafe fn note(message: *const c_char, user_data: *mut c_void) {
        if message.is_null() {
            return;
        }
        // SAFETY: by the caller's promise.
        let (callbacks, message) = unsafe { (&*user_data.cast::<Callbacks>(), CStr::from_ptr(message)) };
        callbacks.note(message.to_string_lossy().into_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Ode;

    /// v̇ = (t v₀ v₁, v₀²).
    struct Quadratic;

    impl Ode for Quadratic {
        fn dim(&self) -> usize {
            2
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            (dv[0], dv[1]) = (t * v[0] * v[1], v[0] * v[0]);
        }
        fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            add(0, 0, t * v[1]);
            add(0, 1, t * v[0]);
            add(1, 0, 2.0 * v[0]);
        }
    }

    /// A positive number asks CVODE to try again with a shorter step.
    #[test]
    fn what_a_callback_refuses_ends_the_run() {
        assert_eq!((code(Ok(())), code(Err(Refused))), (0, -1));
    }

    #[test]
    fn the_product_that_cvode_gets_is_that_of_the_system() -> Result<(), CallError> {
        let callbacks = Callbacks::new(&Quadratic, 2);
        let context = new_context()?;
        let [x, v, out] = [[0.5, -2.0], [3.0, 5.0], [f64::NAN; 2]].map(|entries| new_vector(&entries, &context));
        let (x, v, out) = (x?, v?, out?);
        let user_data = ptr::from_ref(&callbacks).cast_mut().cast::<c_void>();
        // SAFETY: three live vectors of the dimension of the callbacks, which outlive the call; f and the work space are not used.
        let found = unsafe {
            let code = on_product(x.raw, out.raw, 7.0, v.raw, ptr::null_mut(), user_data, ptr::null_mut());
            (code, entries(out.raw, 2))
        };
        assert_eq!(found, (0, [7.0 * (5.0 * 0.5 - 3.0 * 2.0), 2.0 * 3.0 * 0.5].as_slice()));
        Ok(())
    }
}
