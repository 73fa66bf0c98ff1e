//! The conditions on a Runge–Kutta method as a system in its coefficients: c_i = Σ_j a_ij where c is stated, then those of the trees
//! for b and for b̂.

use super::conditions::Weights;
use super::mend::System;
use super::real::Real;
use super::repair::Target;
use super::tableau::{Coefficient, Numbers, Place, Tableau, row_sums};
use super::tree::{Forest, Rule};

/// What a tableau has to satisfy.
#[derive(Debug)]
pub(super) struct TableauSystem<'a> {
    tableau: &'a Tableau,
    forest: Forest,
    /// Trees of the conditions on b.
    main: Vec<usize>,
    /// Trees of the conditions on b̂.
    embedded: Vec<usize>,
}

impl<'a> TableauSystem<'a> {
    pub(super) fn new(tableau: &'a Tableau, target: Target) -> Self {
        let embedded = target.embedded.filter(|_| tableau.b_hat.is_some()).unwrap_or(0);
        let forest = Forest::new(Rule::Autonomous, target.order.max(embedded));
        let trees = |order: u32| (1..=order).flat_map(|n| forest.of_order(n)).collect();
        Self { tableau, main: trees(target.order), embedded: trees(embedded), forest }
    }

    /// How many row sums are conditions.
    fn sums(&self) -> usize {
        self.tableau.c.as_ref().map_or(0, Vec::len)
    }
}

impl System for TableauSystem<'_> {
    fn entries(&self) -> Vec<(Place, &Coefficient)> {
        let matrix = self.tableau.a.iter().enumerate();
        let mut entries: Vec<_> =
            matrix.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, x)| (Place::A(i, j), x))).collect();
        let Tableau { b, c, b_hat, .. } = self.tableau;
        entries.extend(b.iter().enumerate().map(|(i, x)| (Place::B(i), x)));
        entries.extend(c.iter().flatten().enumerate().map(|(i, x)| (Place::C(i), x)));
        entries.extend(b_hat.iter().flatten().enumerate().map(|(i, x)| (Place::Hat(i), x)));
        entries
    }

    fn degree(&self) -> usize {
        self.forest.order() as usize
    }

    fn count(&self) -> usize {
        self.sums() + self.main.len() + self.embedded.len()
    }

    fn residuals(&self, numbers: &[Real], wanted: &[usize]) -> Vec<Real> {
        let s = self.tableau.stages();
        let (matrix, rest) = numbers.split_at(s * s);
        let a: Vec<Vec<Real>> = matrix.chunks(s).map(<[Real]>::to_vec).collect();
        let mut lists = rest.chunks(s).map(<[Real]>::to_vec);
        let b = lists.next().unwrap_or_default();
        let c = if self.sums() > 0 { lists.next().unwrap_or_default() } else { row_sums(&a) };
        let numbers = Numbers { a, b, c, b_hat: lists.next() };
        let (sums, defects) = (self.sums(), numbers.row_defects());
        let mut weights = Weights::new(&self.forest, &numbers);
        let mut residual = |k: usize| match k.checked_sub(sums) {
            None => defects[k].clone(),
            Some(k) => match k.checked_sub(self.main.len()) {
                None => weights.residual(self.main[k], &numbers.b),
                Some(k) => weights.residual(self.embedded[k], numbers.b_hat.as_deref().unwrap_or_default()),
            },
        };
        wanted.iter().map(|&k| residual(k)).collect()
    }

    fn sum(&self, place: Place) -> Option<Place> {
        match place {
            Place::A(i, _) if self.sums() > 0 => Some(Place::C(i)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile};
    use super::super::mend::{failing, numbers};
    use super::*;

    const HEUN: &str = "a = [[0, 0], [1, 0]]\nb = ['1/2', '1/2']\nb_hat = ['3/4', '1/4']\n";

    fn with<T>(text: &str, order: u32, found: impl FnOnce(&TableauSystem) -> T) -> T {
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let Body::RungeKutta(tableau) = &file.body else { panic!("{text}") };
        found(&TableauSystem::new(tableau, Target { order, embedded: Some(1) }))
    }

    /// Σ b_i = 1 and Σ b_i c_i = ½, then Σ b̂_i = 1; before them two rows, where c is stated.
    #[test]
    fn conditions_are_those_of_rows_with_a_sum_of_weights_and_of_embedded_ones() {
        for (c, sums, sum) in [("", 0, None), ("c = [0, 1]\n", 2, Some(Place::C(1)))] {
            with(&format!("{HEUN}{c}"), 2, |system| {
                assert_eq!((system.count(), failing(system, &numbers(system))), (sums + 3, Vec::new()), "{c}");
                assert_eq!((system.sum(Place::A(1, 0)), system.sum(Place::B(1))), (sum, None), "{c}");
            });
        }
        assert_eq!(with(HEUN, 3, |system| failing(system, &numbers(system))), [2, 3]);
    }

    /// Σ b_i a_ij a_jk is of degree 2 in a₁₁ of one stage.
    #[test]
    fn the_degree_is_that_of_a_condition_in_an_entry_of_a() {
        with("a = [['1/2']]\nb = [1]\n", 3, |system| {
            let at = |n: i64| {
                let mut changed = numbers(system);
                changed[0] = Real::from(n);
                system.residuals(&changed, &(0..system.count()).collect::<Vec<_>>())
            };
            let mut differences: Vec<Vec<Real>> = (0..=system.degree() as i64 + 1).map(at).collect();
            while differences.len() > 1 {
                let step = |pair: &[Vec<Real>]| pair[1].iter().zip(&pair[0]).map(|(y, x)| y - x).collect();
                differences = differences.windows(2).map(step).collect();
            }
            assert!(differences[0].iter().all(Real::may_be_zero), "{differences:?}");
        });
    }
}
