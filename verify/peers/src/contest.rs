//! Which solvers meet on which problems.

use lsvi::EulerLagrange;

use crate::measure::{Found, Sides, compare};
use crate::problem::{Burgers, Channel, Hires, Kepler, Pendulum, Problem, Robertson, System, TruthError, VanDerPol};
use crate::solver::{
    AdaptiveRadau, ByReference, Dense, DifferentialEquations, Fixed, Matrix, MethodI, OdeSolvers, RadauByHand, Russell,
    Solver, Tridiagonal,
};

/// Unknowns of the problems in space.
const UNKNOWNS: usize = 200;

/// Problems that ask for the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Set {
    /// Stiff systems, for implicit methods.
    Stiff,
    /// Conservative systems, for any.
    Mechanics,
    /// The stiff systems, for the adaptive method and a loop of its family written by hand.
    ByHand,
}

impl Set {
    /// All.
    pub(crate) const ALL: [Self; 3] = [Self::Stiff, Self::Mechanics, Self::ByHand];

    /// What stands above its table, and what programs know it by.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Stiff => "STIFF",
            Self::Mechanics => "MECHANICS",
            Self::ByHand => "BY HAND",
        }
    }

    /// The largest geometric mean of the ratios that is aimed at.
    pub(crate) fn aim(self) -> f64 {
        match self {
            Self::Stiff => 0.5,
            Self::Mechanics => 0.7,
            Self::ByHand => 1.3,
        }
    }
}

/// A problem with the solvers that are compared on it.
pub(crate) struct Contest {
    pub(crate) problem: &'static str,
    pub(crate) set: Set,
    /// Compares, with medians over so many rounds.
    pub(crate) run: fn(u16) -> Result<Found, TruthError>,
}

/// All problems.
pub(crate) const ALL: [Contest; 12] = [
    Contest {
        problem: "channel",
        set: Set::Stiff,
        run: |rounds| Ok(dissipative(&Channel::problem::<UNKNOWNS>(), rounds)),
    },
    Contest {
        problem: "Burgers",
        set: Set::Stiff,
        run: |rounds| Ok(dissipative(&Burgers::problem::<UNKNOWNS>()?, rounds)),
    },
    Contest { problem: "van der Pol", set: Set::Stiff, run: |rounds| Ok(stiff(&VanDerPol::problem()?, rounds)) },
    Contest { problem: "Robertson", set: Set::Stiff, run: |rounds| Ok(stiff(&Robertson::problem()?, rounds)) },
    Contest { problem: "HIRES", set: Set::Stiff, run: |rounds| Ok(stiff(&Hires::problem()?, rounds)) },
    Contest { problem: "pendulum", set: Set::Mechanics, run: |rounds| Ok(mechanics(&Pendulum::problem()?, rounds)) },
    Contest { problem: "Kepler", set: Set::Mechanics, run: |rounds| Ok(mechanics(&Kepler::problem()?, rounds)) },
    Contest {
        problem: "channel",
        set: Set::ByHand,
        run: |rounds| Ok(by_hand::<Tridiagonal<UNKNOWNS>, UNKNOWNS, _>(&Channel::problem(), rounds)),
    },
    Contest {
        problem: "Burgers",
        set: Set::ByHand,
        run: |rounds| Ok(by_hand::<Tridiagonal<UNKNOWNS>, UNKNOWNS, _>(&Burgers::problem()?, rounds)),
    },
    Contest {
        problem: "van der Pol",
        set: Set::ByHand,
        run: |rounds| Ok(by_hand::<Dense<2>, 2, _>(&VanDerPol::problem()?, rounds)),
    },
    Contest {
        problem: "Robertson",
        set: Set::ByHand,
        run: |rounds| Ok(by_hand::<Dense<3>, 3, _>(&Robertson::problem()?, rounds)),
    },
    Contest {
        problem: "HIRES",
        set: Set::ByHand,
        run: |rounds| Ok(by_hand::<Dense<8>, 8, _>(&Hires::problem()?, rounds)),
    },
];

/// The peers for stiff problems.
fn implicit<const N: usize, S: System<N>>() -> Vec<Box<dyn Solver<Problem<N, S>>>> {
    let references = ByReference::all(true).map(|peer| Box::new(peer) as Box<dyn Solver<_>>);
    references.chain([Box::new(DifferentialEquations::Radau5) as _, Box::new(Russell::Radau5) as _]).collect()
}

fn stiff<const N: usize, S: System<N>>(problem: &Problem<N, S>, rounds: u16) -> Found {
    compare(problem, &Sides { ours: vec![Box::new(AdaptiveRadau)], peers: implicit() }, rounds)
}

fn dissipative<const N: usize, S: System<N>>(problem: &Problem<N, S>, rounds: u16) -> Found {
    compare(problem, &Sides { ours: vec![Box::new(AdaptiveRadau), Box::new(MethodI)], peers: implicit() }, rounds)
}

fn mechanics<const N: usize, S>(problem: &Problem<N, S>, rounds: u16) -> Found
where
    S: System<N> + EulerLagrange + Copy,
{
    let mut ours: Vec<Box<dyn Solver<_>>> = vec![Box::new(AdaptiveRadau)];
    ours.extend(Fixed::all().map(|method| Box::new(method) as _));
    let mut peers: Vec<Box<dyn Solver<_>>> = vec![
        Box::new(OdeSolvers::Dopri5),
        Box::new(OdeSolvers::Dop853),
        Box::new(DifferentialEquations::Dop853),
        Box::new(DifferentialEquations::Radau5),
        Box::new(Russell::DoPri8),
        Box::new(Russell::Radau5),
    ];
    peers.extend(ByReference::all(false).map(|peer| Box::new(peer) as _));
    compare(problem, &Sides { ours, peers }, rounds)
}

/// The adaptive method beside a loop with Jacobians M.
fn by_hand<M: Matrix<N> + 'static, const N: usize, S: System<N>>(problem: &Problem<N, S>, rounds: u16) -> Found {
    let peers: Vec<Box<dyn Solver<_>>> = vec![Box::new(RadauByHand::<M>::NEW)];
    compare(problem, &Sides { ours: vec![Box::new(AdaptiveRadau)], peers }, rounds)
}
