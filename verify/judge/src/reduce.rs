//! A Runge–Kutta method without stages that it does not need.
//!
//! Stages that no weight depends on have no influence (reducible after Dahlquist and Jeltsch); stages whose values are the same on every
//! problem are one (reducible after Hundsdorfer and Spijker): \[HW96\] IV.12. The conditions of symplecticity, symmetry and algebraic
//! stability are necessary on irreducible methods only.

use super::real::Real;
use super::tableau::Numbers;
use experiments::measure::decimal::counted;

/// An irreducible method with the same steps.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Its coefficients.
    pub numbers: Numbers,
    /// What was left out, in words; nothing where the method is irreducible.
    pub why: Option<String>,
}

impl Reduced {
    /// Leaves out stages without influence, then makes equal stages one.
    pub fn of(numbers: &Numbers) -> Self {
        let influential = influential(numbers);
        let classes: Vec<Vec<usize>> = influential.iter().map(|i| vec![*i]).collect();
        let found = lumped(numbers, &classes);
        let merged = equal(&found);
        let named = |stages: &[usize]| {
            let names: Vec<String> = stages.iter().map(|i| (i + 1).to_string()).collect();
            format!("stage{} {}", if names.len() == 1 { "" } else { "s" }, names.join(", "))
        };
        let unused: Vec<usize> = (0..numbers.stages()).filter(|i| !influential.contains(i)).collect();
        let mut why = Vec::new();
        if !unused.is_empty() {
            let verb = if unused.len() == 1 { "has" } else { "have" };
            why.push(format!("{} {verb} no influence", named(&unused)));
        }
        for class in merged.iter().filter(|class| class.len() > 1) {
            let stages: Vec<usize> = class.iter().map(|k| influential[*k]).collect();
            why.push(format!("{} are equal", named(&stages)));
        }
        let numbers = if merged.len() < found.stages() { Self::of(&lumped(&found, &merged)).numbers } else { found };
        Self { numbers, why: (!why.is_empty()).then(|| why.join(", and ")) }
    }

    /// On which coefficients conditions of structure are looked at, where these are not all.
    pub(super) fn told(&self) -> String {
        self.why.as_ref().map_or_else(String::new, |why| {
            format!("; {why}: judged on the {} of the reduced method", counted(self.numbers.stages(), "stage"))
        })
    }
}

/// Stages that have a weight, or enter one that has influence.
fn influential(numbers: &Numbers) -> Vec<usize> {
    let mut found: Vec<bool> = numbers.b.iter().map(|b| !b.is_zero()).collect();
    loop {
        let enters = |j: usize| (0..numbers.stages()).any(|i| found[i] && !numbers.a[i][j].is_zero());
        let Some(next) = (0..numbers.stages()).find(|j| !found[*j] && enters(*j)) else { break };
        found[next] = true;
    }
    (0..numbers.stages()).filter(|i| found[*i]).collect()
}

/// The coarsest classes of stages for which the sum of a row over each class is the same for all stages of a class, and c is.
fn equal(numbers: &Numbers) -> Vec<Vec<usize>> {
    let mut classes: Vec<Vec<usize>> = vec![(0..numbers.stages()).collect()];
    loop {
        let over = |i: usize, class: &[usize]| class.iter().map(|j| numbers.a[i][*j].clone()).sum::<Real>();
        let same = |i: usize, k: usize| {
            (&numbers.c[i] - &numbers.c[k]).may_be_zero()
                && classes.iter().all(|class| (&over(i, class) - &over(k, class)).may_be_zero())
        };
        let mut finer: Vec<Vec<usize>> = Vec::new();
        for class in &classes {
            let from = finer.len();
            for &i in class {
                match finer[from..].iter_mut().find(|part| same(part[0], i)) {
                    Some(part) => part.push(i),
                    None => finer.push(vec![i]),
                }
            }
        }
        if finer.len() == classes.len() {
            return classes;
        }
        classes = finer;
    }
}

/// One stage for each class, with the weights of its stages together.
fn lumped(numbers: &Numbers, classes: &[Vec<usize>]) -> Numbers {
    let over = |row: &[Real]| classes.iter().map(|class| class.iter().map(|j| row[*j].clone()).sum()).collect();
    Numbers {
        a: classes.iter().map(|class| over(&numbers.a[class[0]])).collect(),
        b: over(&numbers.b),
        c: classes.iter().map(|class| numbers.c[class[0]].clone()).collect(),
        b_hat: numbers.b_hat.as_deref().map(over),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{Body, Shipped};
    use crate::structure::{is_symmetric, symplectic_defect};

    /// A matrix and weights in quarters.
    fn quarters(a: &[&[i64]], b: &[i64]) -> Numbers {
        let row = |row: &[i64]| row.iter().map(|n| &Real::from(*n) / &Real::from(4)).collect::<Vec<Real>>();
        let a: Vec<Vec<Real>> = a.iter().map(|entries| row(entries)).collect();
        let c = a.iter().map(|row| row.iter().sum()).collect();
        Numbers { a, b: row(b), c, b_hat: None }
    }

    #[test]
    fn the_implicit_midpoint_rule_is_found_behind_stages_that_it_does_not_need() {
        for (numbers, why) in [
            (quarters(&[&[2, 0], &[1, 1]], &[2, 2]), "stages 1, 2 are equal"),
            (quarters(&[&[-4, 0], &[0, 2]], &[0, 4]), "stage 1 has no influence"),
            (
                quarters(&[&[4, 4, 4], &[0, 2, 0], &[0, 1, 1]], &[0, 2, 2]),
                "stage 1 has no influence, and stages 2, 3 are equal",
            ),
        ] {
            let reduced = Reduced::of(&numbers);
            assert_eq!(reduced.why.as_deref(), Some(why));
            assert_eq!(reduced.numbers.doubles(), (vec![vec![0.5]], vec![1.0], vec![0.5]));
            assert!(symplectic_defect(&reduced.numbers).is_none() && is_symmetric(&reduced.numbers));
        }
    }

    #[test]
    fn methods_that_need_all_their_stages_keep_them() {
        for name in ["rk4", "gauss2", "gauss3", "lobatto-iiia3", "lobatto-iiib3", "radau-iia3", "sdirk2", "kutta-38"] {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{name}") };
            let reduced = Reduced::of(&tableau.numbers());
            assert!(reduced.why.is_none() && reduced.numbers == tableau.numbers(), "{name}: {:?}", reduced.why);
        }
    }
}
