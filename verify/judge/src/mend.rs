//! Misprints of methods of any kind: the conditions of an order as a system in the coefficients, each a polynomial in any one of
//! them, and the single changes that make all of them hold.

use rayon::prelude::*;

use super::conditions::{Part, Weights};
use super::expression::Expression;
use super::file::Body;
use super::multistep::Multistep;
use super::nodes::{Nodes, node_moments, quadrature_moments};
use super::parts::{Coupling, Parts};
use super::real::Real;
use super::repair::{Repair, fitting, interpolate, is_printed, polish};
use super::tableau::{Coefficient, Place, row_sums};
use super::tree::{Forest, Rule};

/// The conditions that a method of some order satisfies.
pub(super) trait System: Sync {
    /// The coefficients, each with its place; zeros of which the shape of the method is made are among them.
    fn entries(&self) -> Vec<(Place, &Coefficient)>;

    /// Largest degree of a condition in any one coefficient.
    fn degree(&self) -> usize;

    /// How many conditions there are.
    fn count(&self) -> usize;

    /// What the `wanted` conditions are off by for other `numbers` in place of the coefficients.
    fn residuals(&self, numbers: &[Real], wanted: &[usize]) -> Vec<Real>;

    /// Where the sum of the row in which `place` stands is stated, if it is.
    fn sum(&self, _place: Place) -> Option<Place> {
        None
    }
}

impl Body {
    /// The conditions of `order`; nothing for a kind whose coefficients none singles out, and for Runge–Kutta methods, whose c
    /// have to follow their A.
    pub(super) fn system(&self, order: u32) -> Option<Box<dyn System + '_>> {
        match self {
            Self::RungeKutta(_) | Self::Closure(_) => None,
            Self::Parts(parts) => Some(Box::new(PartsSystem::new(parts, order))),
            Self::Multistep(method) => Some(Box::new(MultistepSystem { method, order })),
            Self::Nodes(nodes) => NodesSystem::new(nodes, order).map(|system| Box::new(system) as Box<dyn System>),
        }
    }
}

/// Whether all conditions hold for the coefficients as they stand.
pub(super) fn holds(system: &dyn System) -> bool {
    failing(system, &numbers(system)).is_empty()
}

/// Every change of a single coefficient that makes all conditions hold, the one nearest to the printed text first.
pub(super) fn repairs(system: &dyn System) -> Vec<Repair> {
    let (entries, numbers) = (system.entries(), numbers(system));
    let wrong = failing(system, &numbers);
    let radicands = radicands(system);
    let with = |k: usize, x: &Real| {
        let mut changed = numbers.clone();
        changed[k] = x.clone();
        changed
    };
    let repair = |k: usize, x: &Real| {
        let (place, old) = entries[k];
        if is_printed(x, old) {
            return None;
        }
        let (text, value) = fitting(x, old, &radicands, |value| hold(system, &with(k, value), &wrong))?;
        let (was, mends) = (old.text.clone(), wrong.len());
        Some(Repair { place, also: Vec::new(), follows: Vec::new(), makes_implicit: false, was, text, value, mends })
    };
    let of_entry = |k: usize| {
        let found = candidates(system, &wrong, |x| with(k, x)).into_iter();
        found.filter_map(|x| repair(k, &x)).collect::<Vec<_>>()
    };
    let mut found: Vec<Repair> = (0..entries.len()).into_par_iter().flat_map_iter(of_entry).collect();
    // A zero that is none is a misprint more seldom than another digit.
    let distance = |repair: &Repair| strsim::damerau_levenshtein(&repair.was, &repair.text);
    found.sort_by_key(|repair| (repair.was == "0", distance(repair), repair.place));
    found.dedup_by_key(|repair| (repair.place, repair.text.clone()));
    found
}

/// Square roots of whole numbers that the texts contain.
pub(super) fn radicands(system: &dyn System) -> Vec<i64> {
    let mut radicands = Vec::new();
    system
        .entries()
        .iter()
        .filter_map(|(_, it)| Expression::parse(&it.text).ok())
        .for_each(|expression| expression.radicands(&mut radicands));
    radicands.sort_unstable();
    radicands.dedup();
    radicands
}

/// The values of the coefficients as they stand.
pub(super) fn numbers(system: &dyn System) -> Vec<Real> {
    system.entries().iter().map(|(_, coefficient)| coefficient.real.clone()).collect()
}

/// The conditions that do not hold for `numbers`.
pub(super) fn failing(system: &dyn System, numbers: &[Real]) -> Vec<usize> {
    let all: Vec<usize> = (0..system.count()).collect();
    let residuals = system.residuals(numbers, &all);
    all.into_iter().zip(residuals).filter(|(_, x)| !x.may_be_zero()).map(|(k, _)| k).collect()
}

/// Whether all conditions hold for `numbers`, which the first of those that are `wrong` as printed decide mostly.
pub(super) fn hold(system: &dyn System, numbers: &[Real], wrong: &[usize]) -> bool {
    let first = &wrong[..wrong.len().min(3)];
    system.residuals(numbers, first).iter().all(Real::may_be_zero) && failing(system, numbers).is_empty()
}

/// The values of one coefficient for which the first of the `wrong` conditions that depends on it holds.
pub(super) fn candidates(system: &dyn System, wrong: &[usize], with: impl Fn(&Real) -> Vec<Real>) -> Vec<Real> {
    for condition in wrong {
        let value = |x: &Real| system.residuals(&with(x), &[*condition]).swap_remove(0);
        let samples: Vec<Real> = (0..=system.degree()).map(|n| value(&Real::from(n as i64))).collect();
        let polynomial = interpolate(&samples);
        if polynomial.degree().is_some_and(|degree| degree > 0) {
            let real = polynomial.roots().into_iter().filter(|z| z.im.abs() <= 1e-6 * (1.0 + z.re.abs()));
            return real.filter_map(|z| polish(&polynomial, z.re)).collect();
        }
    }
    Vec::new()
}

/// Conditions of coloured trees, and c_i = Σ_j a_ij, or the same of â, where a partitioned method states c.
struct PartsSystem<'a> {
    parts: &'a Parts,
    /// The part whose rows add up to c.
    timed: usize,
    forest: Forest,
}

impl<'a> PartsSystem<'a> {
    fn new(parts: &'a Parts, order: u32) -> Self {
        let rule = parts.rule();
        Self { parts, timed: parts.timed(), forest: Forest::new(rule, order.clamp(1, rule.most())) }
    }

    fn stages(&self) -> usize {
        self.parts.b[0].len()
    }

    /// Matrices that count: those of a Nyström method for q̇ are none.
    fn matrices(&self) -> usize {
        if self.parts.coupling == Coupling::SecondOrder { 1 } else { 2 }
    }

    fn trees(&self) -> Vec<usize> {
        (1..=self.forest.order()).flat_map(|n| self.forest.of_order(n)).collect()
    }
}

impl System for PartsSystem<'_> {
    fn entries(&self) -> Vec<(Place, &Coefficient)> {
        let (matrices, weights) = match self.parts.coupling {
            Coupling::SecondOrder => (["a", ""], ["b_bar", "b"]),
            _ => (["a", "a_hat"], ["b", "b_hat"]),
        };
        let mut entries = Vec::new();
        for (name, a) in matrices.into_iter().zip(&self.parts.a).take(self.matrices()) {
            let row = |(i, row)| {
                let row: &Vec<Coefficient> = row;
                row.iter().enumerate().map(move |(j, x)| (Place::Of(name, i, j), x))
            };
            entries.extend(a.iter().enumerate().flat_map(row));
        }
        for (name, b) in weights.into_iter().zip(&self.parts.b).chain(self.parts.c.iter().map(|c| ("c", c))) {
            entries.extend(b.iter().enumerate().map(|(i, x)| (Place::In(name, i), x)));
        }
        entries
    }

    fn degree(&self) -> usize {
        self.forest.order() as usize
    }

    fn count(&self) -> usize {
        let sums = self.parts.c.is_some() && self.parts.coupling != Coupling::SecondOrder;
        self.trees().len() + if sums { self.stages() } else { 0 }
    }

    fn residuals(&self, numbers: &[Real], wanted: &[usize]) -> Vec<Real> {
        let s = self.stages();
        let (matrices, rest) = numbers.split_at(self.matrices() * s * s);
        let matrix = |k: usize| -> Vec<Vec<Real>> {
            match matrices.chunks(s * s).nth(k) {
                Some(entries) => entries.chunks(s).map(<[Real]>::to_vec).collect(),
                // What a Nyström method has there.
                None => self.parts.a[1].iter().map(|row| row.iter().map(|x| x.real.clone()).collect()).collect(),
            }
        };
        let a = [matrix(0), matrix(1)];
        let sums = row_sums(&a[self.timed]);
        let c = if self.parts.c.is_some() { &rest[2 * s..] } else { &sums };
        let leaves = self.parts.leaves([&a[0], &a[1]], c);
        let part = |k: usize| Part { a: &a[k], leaf: leaves[k].clone() };
        let mut weights = Weights::of_parts(&self.forest, [part(0), part(1)], c);
        let trees = self.trees();
        wanted
            .iter()
            .map(|&k| match trees.get(k) {
                Some(&tree) => {
                    let second = self.forest.trees()[tree].colour == super::tree::Colour::Second;
                    weights.residual(tree, if second { &rest[s..2 * s] } else { &rest[..s] })
                }
                None => &c[k - trees.len()] - &sums[k - trees.len()],
            })
            .collect()
    }

    fn sum(&self, place: Place) -> Option<Place> {
        let is_stated = self.parts.c.is_some() && self.parts.coupling != Coupling::SecondOrder;
        match place {
            Place::Of(name, i, _) if is_stated && name == ["a", "a_hat"][self.timed] => Some(Place::In("c", i)),
            _ => None,
        }
    }
}

impl Parts {
    /// The trees whose conditions decide the order.
    pub(super) fn rule(&self) -> Rule {
        match self.coupling {
            Coupling::General => Rule::Partitioned,
            Coupling::Separable => Rule::Separable,
            Coupling::SecondOrder => Rule::SecondOrder,
        }
    }

    /// What a leaf of each colour puts at the stages.
    pub(super) fn leaves(&self, a: [&[Vec<Real>]; 2], c: &[Real]) -> [Vec<Real>; 2] {
        match self.coupling {
            Coupling::SecondOrder => [c.to_vec(), vec![Real::one(); c.len()]],
            _ => a.map(row_sums),
        }
    }
}

/// Σ j^q ρ_j = q Σ j^{q−1} σ_j for q from 0 to the order.
struct MultistepSystem<'a> {
    method: &'a Multistep,
    order: u32,
}

impl System for MultistepSystem<'_> {
    fn entries(&self) -> Vec<(Place, &Coefficient)> {
        let named = |name, list: &'_ [Coefficient]| (0..list.len()).map(|j| Place::In(name, j)).collect::<Vec<_>>();
        let places = [named("rho", &self.method.rho), named("sigma", &self.method.sigma)].concat();
        places.into_iter().zip(self.method.rho.iter().chain(&self.method.sigma)).collect()
    }

    fn degree(&self) -> usize {
        1
    }

    fn count(&self) -> usize {
        self.order as usize + 1
    }

    fn residuals(&self, numbers: &[Real], wanted: &[usize]) -> Vec<Real> {
        let (rho, sigma) = numbers.split_at(self.method.rho.len());
        let power = |j: usize, q: usize| (0..q).fold(Real::one(), |p, _| &p * &Real::from(j as i64));
        let moment = |list: &[Real], q: usize| list.iter().enumerate().map(|(j, x)| x * &power(j, q)).sum::<Real>();
        let condition = |&q: &usize| match q {
            0 => moment(rho, 0),
            q => &moment(rho, q) - &(&Real::from(q as i64) * &moment(sigma, q - 1)),
        };
        wanted.iter().map(condition).collect()
    }
}

/// The moments that vanish at an order.
struct NodesSystem<'a> {
    nodes: &'a Nodes,
    count: usize,
}

impl<'a> NodesSystem<'a> {
    /// Nothing where no nodes have the order.
    fn new(nodes: &'a Nodes, order: u32) -> Option<Self> {
        let (s, order) = (nodes.nodes.len(), order as usize);
        let count = match nodes.weights {
            Some(_) if order <= 2 * nodes.degree => order,
            None if order <= 2 * s => order.saturating_sub(s),
            _ => return None,
        };
        Some(Self { nodes, count })
    }
}

impl System for NodesSystem<'_> {
    fn entries(&self) -> Vec<(Place, &Coefficient)> {
        let nodes = self.nodes.nodes.iter().enumerate().map(|(i, x)| (Place::In("nodes", i), x));
        let weights = self.nodes.weights.iter().flatten().enumerate().map(|(i, x)| (Place::In("weights", i), x));
        nodes.chain(weights).collect()
    }

    fn degree(&self) -> usize {
        self.count.max(1)
    }

    fn count(&self) -> usize {
        self.count
    }

    fn residuals(&self, numbers: &[Real], wanted: &[usize]) -> Vec<Real> {
        let (c, b) = numbers.split_at(self.nodes.nodes.len());
        let all = match b {
            [] => node_moments(c, self.count),
            b => quadrature_moments(c, b, self.count),
        };
        wanted.iter().map(|&k| all[k].clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::MethodFile;
    use super::*;

    /// v_{n+1} − v_n = −2h f_n is mended by 1 for −2, and by 3 for the zero beside it, which is one character for two.
    #[test]
    fn a_zero_is_changed_last_however_near_its_repair_is() {
        let text = "kind = 'multistep'\norder = 1\nrho = [-1, 1]\nsigma = [-2, 0]\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let found = repairs(&*file.body.system(1).expect("it has conditions"));
        let found: Vec<_> = found.iter().map(|repair| (repair.place.to_string(), repair.text.as_str())).collect();
        assert_eq!(found, [("sigma[1]".to_owned(), "1"), ("sigma[2]".to_owned(), "3")]);
    }

    /// c are the sums of the rows of the matrix by which q moves where they are its times, and of none where they are not stated or a q̇.
    #[test]
    fn the_sum_of_a_row_is_stated_where_c_is_made_of_it() {
        let (zero, half) = ("[[0, 0], ['1/2', '1/2']]", "[['1/2', 0], ['1/2', 0]]");
        let pair = |c: &str, [a, hat]: [&str; 2]| {
            format!(
                "kind = 'partitioned-runge-kutta'\norder = 2\n{c}a = {a}\nb = ['1/2', '1/2']\na_hat = {hat}\n\
                 b_hat = ['1/2', '1/2']\n"
            )
        };
        let nystrom = "kind = 'nystrom'\norder = 2\na = [[0, 0], ['1/2', 0]]\nb_bar = ['1/2', 0]\nb = ['1/2', '1/2']\nc = [0, 1]\n";
        let stated = Some(Place::In("c", 1));
        for (text, of_a, of_hat) in [
            (pair("c = [0, 1]\n", [zero, half]), stated, None),
            (pair("c = [0, 1]\n", [half, zero]), None, stated),
            (pair("", [zero, half]), None, None),
            (nystrom.to_owned(), None, None),
        ] {
            let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            let system = file.body.system(2).expect("it has conditions");
            let sums = ["a", "a_hat"].map(|name| system.sum(Place::Of(name, 1, 0)));
            assert_eq!(sums, [of_a, of_hat], "{text}");
            assert_eq!(system.sum(Place::In("b", 1)), None, "{text}");
        }
    }

    /// The differences of a polynomial vanish from one more than its degree on.
    #[test]
    fn no_condition_is_of_a_higher_degree_in_any_coefficient_than_is_said() {
        let pair = "kind = 'partitioned-runge-kutta'\nc = [0, 1]\na = [[0, 0], ['1/2', '1/2']]\nb = ['1/2', '1/2']\n\
                    a_hat = [['1/2', 0], ['1/2', 0]]\nb_hat = ['1/2', '1/2']\n";
        let nystrom =
            "kind = 'nystrom'\na = [[0, 0], ['1/2', 0]]\nb_bar = ['1/2', 0]\nb = ['1/2', '1/2']\nc = [0, 1]\n";
        let multistep = "kind = 'multistep'\nrho = [0, -1, 1]\nsigma = ['-1/2', '3/2', 0]\n";
        let galerkin = "kind = 'galerkin'\ndegree = 2\nnodes = ['1/3', 1]\nweights = ['3/4', '1/4']\n";
        let fitted = "kind = 'path-fitted'\nnodes = ['1/3', '2/3']\n";
        for text in [pair, nystrom, multistep, galerkin, fitted] {
            let file = MethodFile::parse("m.toml", "m", text).expect(text);
            let system = file.body.system(4).expect("it has conditions");
            let (printed, all) = (numbers(&*system), (0..system.count()).collect::<Vec<_>>());
            for k in 0..printed.len() {
                let at = |n: usize| {
                    let mut numbers = printed.clone();
                    numbers[k] = Real::from(n as i64);
                    system.residuals(&numbers, &all)
                };
                let mut differences: Vec<Vec<Real>> = (0..=system.degree() + 1).map(at).collect();
                while differences.len() > 1 {
                    let step = |pair: &[Vec<Real>]| pair[1].iter().zip(&pair[0]).map(|(y, x)| y - x).collect();
                    differences = differences.windows(2).map(step).collect();
                }
                assert!(differences[0].iter().all(Real::may_be_zero), "{text}{}", system.entries()[k].0);
            }
        }
    }

    /// σ₁ + σ₂ = 1: what is missing is told in the quarters that are printed, and in others where these do not do.
    #[test]
    fn a_fraction_keeps_the_denominator_that_is_printed() {
        let text = "kind = 'multistep'\norder = 1\nrho = [-1, 1]\nsigma = ['1/4', '1/2']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let found = repairs(&*file.body.system(1).expect("it has conditions"));
        let found: Vec<_> = found.iter().map(|repair| (repair.place.to_string(), repair.text.as_str())).collect();
        assert_eq!(found, [("sigma[1]".to_owned(), "2/4"), ("sigma[2]".to_owned(), "3/4")]);
        // A whole number is no fraction.
        let file = MethodFile::parse("m.toml", "m", &text.replace("'1/4'", "0")).expect("well-formed");
        let found = repairs(&*file.body.system(1).expect("it has conditions"));
        assert!(found.iter().any(|repair| repair.place.to_string() == "sigma[2]" && repair.text == "1"));
    }

    /// σ₁ + σ₂ = 1 is mended by either: ⅔ for ½ changes two characters, ½ for ⅓ one.
    #[test]
    fn the_repair_nearest_to_the_printed_text_comes_first() {
        let changes = |sigma: &str| {
            let text = format!("kind = 'multistep'\norder = 1\nrho = [-1, 1]\nsigma = [{sigma}]\n");
            let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            let found = repairs(&*file.body.system(1).expect("it has conditions"));
            found.into_iter().map(|repair| (repair.place.to_string(), repair.text)).collect::<Vec<_>>()
        };
        let expected =
            |near: &str, far: &str| [(near.to_owned(), "1/2".to_owned()), (far.to_owned(), "2/3".to_owned())];
        assert_eq!(changes("'1/2', '1/3'"), expected("sigma[2]", "sigma[1]"));
        assert_eq!(changes("'1/3', '1/2'"), expected("sigma[1]", "sigma[2]"));
        // The same number at either of two places is two repairs.
        let alike = ["sigma[1]", "sigma[2]"].map(|place| (place.to_owned(), "3/4".to_owned()));
        assert_eq!(changes("'1/4', '1/4'"), alike);
    }

    /// x = 1 and x y = 2.
    struct Product;

    impl System for Product {
        fn entries(&self) -> Vec<(Place, &Coefficient)> {
            Vec::new()
        }

        fn degree(&self) -> usize {
            1
        }

        fn count(&self) -> usize {
            2
        }

        fn residuals(&self, numbers: &[Real], wanted: &[usize]) -> Vec<Real> {
            let all = [&numbers[0] - &Real::one(), &(&numbers[0] * &numbers[1]) - &Real::from(2)];
            wanted.iter().map(|&k| all[k].clone()).collect()
        }
    }

    #[test]
    fn a_coefficient_is_solved_for_in_the_first_condition_that_depends_on_it() {
        let found = candidates(&Product, &[0, 1], |y| vec![Real::from(4), y.clone()]);
        let [y] = &found[..] else { panic!("{found:?}") };
        assert!((y - &Real::double(0.5)).may_be_zero());
    }

    #[test]
    fn the_radicands_of_a_method_are_those_of_all_its_coefficients_once() {
        let text = "kind = 'multistep'\nrho = ['-sqrt(5)', 'sqrt(5)']\nsigma = ['sqrt(3)/2', 'sqrt(5) - sqrt(3)/2']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        assert_eq!(radicands(&*file.body.system(1).expect("it has conditions")), [3, 5]);
    }

    #[test]
    fn the_trapezoidal_rule_satisfies_the_conditions_of_order_two_and_no_more() {
        let text = "kind = 'multistep'\nrho = [-1, 1]\nsigma = ['1/2', '1/2']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let satisfies = |order: u32| holds(&*file.body.system(order).expect("it has conditions"));
        assert_eq!([1, 2, 3].map(satisfies), [true, true, false]);
    }
}
