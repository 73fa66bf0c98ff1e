//! Steps allocate nothing once the first has set up factors.

mod fields;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use fields::{As, Burgers, Line, Plane, Walls};
use lsvi::adaptive::{Radau, Tolerances};
use lsvi::classic::{Bdf2, RungeKutta, Tableau};
use lsvi::{AutoDiff, Formulation, Integrator, MethodI, State, Structure, Trajectory, VectorField, method_i};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is passed on to the system allocator unchanged; the counter has no destructor and allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises about `layout` are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `alloc` with this layout, that is from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of ten steps after the first two.
fn allocations(method: impl Integrator) -> usize {
    let n = method.dim();
    let v = (1..=n).map(|i| (std::f64::consts::PI * i as f64 / (n + 1) as f64).sin()).collect();
    let mut trajectory = Trajectory::new(method, State::new(0.0, v), 0.01, 1.0).expect("usable");
    let mut step = || assert!(trajectory.step().expect("solvable").is_some());
    (0..2).for_each(|_| step());
    let before = ALLOCATIONS.get();
    (0..10).for_each(|_| step());
    ALLOCATIONS.get() - before
}

#[test]
fn steps_allocate_nothing() {
    let line = Line::new(20, 1.0, Walls::Dirichlet);
    let plane = Plane { side: 6 };
    let burgers = AutoDiff::new(Burgers { cells: 20, viscosity: 0.1 });
    let fields: [&dyn VectorField; 5] =
        [&line, &plane, &burgers, &As(Structure::Dense, &line), &As(Structure::Dense, &burgers)];
    for field in fields {
        assert_eq!(allocations(method_i(field)), 0);
        assert_eq!(allocations(Bdf2::new(field)), 0);
        let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
        assert_eq!(allocations(Radau::new(field, tolerances).expect("valid")), 0);
        for tableau in [Tableau::implicit_euler(), Tableau::trapezoidal(), Tableau::sdirk2()] {
            assert_eq!(allocations(RungeKutta::new(field, tableau)), 0);
        }
        for formulation in [Formulation::Augmented, Formulation::Twisted, Formulation::CONJUGATE_GRADIENTS] {
            if let Ok(method) = MethodI::with_formulation(field, formulation) {
                assert_eq!(allocations(method), 0, "{formulation:?}");
            }
        }
    }
}

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(vec![0.0; 10]));
    assert_eq!(ALLOCATIONS.get() - before, 1);
}
