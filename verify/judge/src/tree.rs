//! Rooted trees: one for each elementary differential of v̇ = f(t, v), and so for each condition of an order (\[HNW93\] II.2).

use std::fmt::Write;

/// Largest order for which trees are made: 1842 of them, 719 of the last order.
pub const MAX_ORDER: u32 = 10;

/// A rooted tree in a [`Forest`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tree {
    /// Number of vertices.
    pub order: u32,
    /// Density γ: the condition of the tree is Φ = 1/γ.
    pub density: u64,
    /// Symmetry σ.
    pub symmetry: u64,
    /// Subtrees of the root, by their places in the forest, never increasing.
    pub children: Vec<usize>,
    /// What its root stands for.
    pub colour: Colour,
}

/// What a vertex stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Colour {
    /// The right-hand side, or that of q̇ in a system of two parts.
    First,
    /// The right-hand side of ṗ.
    Second,
    /// Time, whose stage values are the c_i as given: ∂f/∂t puts it where ∂f/∂v puts a subtree.
    Time,
}

/// Which trees there are: which elementary differentials of a system do not vanish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// v̇ = f(v), Σ over j of a_ij standing for every c_i: 1, 1, 2, 4, 9, 20, 48, 115, … trees.
    Autonomous,
    /// q̇ = f(q, p), ṗ = g(q, p): 2, 4, 14, 52, … trees (\[HLW06\] III.2).
    Partitioned,
    /// q̇ = f(p), ṗ = g(q): neighbours differ in colour.
    Separable,
    /// q̇ = p, ṗ = g(q): so do they, and a vertex of q carries at most one other (\[HNW93\] II.14).
    SecondOrder,
}

impl Rule {
    /// Largest order for which its trees are made: one to two thousand of them.
    pub fn most(self) -> u32 {
        match self {
            Self::Autonomous => MAX_ORDER,
            Self::Partitioned => 6,
            Self::Separable => 8,
            Self::SecondOrder => 10,
        }
    }

    fn colours(self) -> &'static [Colour] {
        match self {
            Self::Autonomous => &[Colour::First],
            _ => &[Colour::First, Colour::Second],
        }
    }

    /// Whether ∂`root`/∂`child` need not vanish, for the `n`th child of the root.
    fn allows(self, root: Colour, child: Colour, n: usize) -> bool {
        match self {
            Self::Autonomous | Self::Partitioned => true,
            // Of time, the forces alone.
            Self::Separable if child == Colour::Time => root == Colour::Second,
            Self::Separable => root != child,
            Self::SecondOrder => root != child && (root == Colour::Second || n == 0),
        }
    }
}

/// All rooted trees up to an order, each after its subtrees.
#[derive(Debug, Clone)]
pub struct Forest {
    trees: Vec<Tree>,
    order: u32,
    rule: Rule,
}

impl Forest {
    /// The trees of `rule` up to `order`, at most [as many](Rule::most) as there are made.
    pub fn new(rule: Rule, order: u32) -> Self {
        Self::grown(rule, order, false)
    }

    /// The same with a leaf for time, whose stage values are c, which need not be the sums of the rows: on v̇ = f(t, v), on
    /// q̇ = f(t, q, p), ṗ = g(t, q, p), and on q̇ = f(p), ṗ = g(t, q).
    pub fn with_time(rule: Rule, order: u32) -> Self {
        Self::grown(rule, order, true)
    }

    fn grown(rule: Rule, order: u32, with_time: bool) -> Self {
        let order = order.min(rule.most());
        let leaf = |colour| Tree { order: 1, density: 1, symmetry: 1, children: Vec::new(), colour };
        let mut forest = Self { trees: Vec::new(), order, rule };
        if order > 0 {
            forest.trees.extend(rule.colours().iter().map(|colour| leaf(*colour)));
        }
        if with_time && order > 1 {
            forest.trees.push(leaf(Colour::Time));
        }
        for n in 2..=order {
            let known = forest.trees.len();
            for colour in rule.colours() {
                forest.graft(n, *colour, n - 1, known, &mut Vec::new());
            }
        }
        forest
    }

    /// Adds the trees of order `n` whose root of this `colour` carries `children` and further ones of `left` vertices, none of
    /// them at or after place `below`.
    fn graft(&mut self, n: u32, colour: Colour, left: u32, below: usize, children: &mut Vec<usize>) {
        if left == 0 {
            let density = children.iter().map(|&k| self.trees[k].density).product::<u64>() * u64::from(n);
            let mut symmetry = 1;
            for (i, &k) in children.iter().enumerate() {
                let repeated = children[..=i].iter().filter(|&&other| other == k).count() as u64;
                symmetry *= self.trees[k].symmetry * repeated;
            }
            self.trees.push(Tree { order: n, density, symmetry, children: children.clone(), colour });
            return;
        }
        for k in (0..below).rev() {
            if self.trees[k].order <= left && self.rule.allows(colour, self.trees[k].colour, children.len()) {
                children.push(k);
                self.graft(n, colour, left - self.trees[k].order, k + 1, children);
                children.pop();
            }
        }
    }

    /// The trees, of lower order first.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// Which trees they are.
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// The largest order.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The places of the trees that state a condition of order `n`; the vertex of time states none, and nor does that of q̇ = p.
    pub fn of_order(&self, n: u32) -> impl Iterator<Item = usize> {
        let free = |tree: &Tree| tree.order == 1 && self.rule == Rule::SecondOrder && tree.colour == Colour::First;
        let states = move |tree: &Tree| tree.order == n && tree.colour != Colour::Time && !free(tree);
        self.trees.iter().enumerate().filter(move |(_, tree)| states(tree)).map(|(k, _)| k)
    }

    /// The tree in brackets: `[τ²,[τ]]`, with `t` for the vertex of time; `p[q²,q[p]]` in a system of two parts.
    pub fn brackets(&self, k: usize) -> String {
        let tree = &self.trees[k];
        let has_parts = self.rule.colours().len() > 1;
        let (leaf, root) = match tree.colour {
            Colour::Time => ("t", ""),
            Colour::Second => ("p", "p"),
            Colour::First if has_parts => ("q", "q"),
            Colour::First => ("τ", ""),
        };
        if tree.children.is_empty() {
            return leaf.into();
        }
        let mut parts: Vec<(String, usize)> = Vec::new();
        for &child in tree.children.iter().rev() {
            let text = self.brackets(child);
            match parts.last_mut() {
                Some((last, count)) if *last == text => *count += 1,
                _ => parts.push((text, 1)),
            }
        }
        let parts: Vec<String> = parts.into_iter().map(|(text, count)| power(&text, count)).collect();
        format!("{root}[{}]", parts.join(","))
    }

    /// The sum of the condition in coefficients: `Σ b_i c_i a_ij c_j²`. In a system of two parts, hats are on those of ṗ; in
    /// q̈ = g(q), bars on those of q. For a colour of which `spelled` says so, c_i is spelled out: `Σ b_i a_ij a_ik a_kl a_km`.
    pub fn formula(&self, k: usize, weights: &str, spelled: [bool; 2]) -> String {
        let is_bar = self.rule == Rule::SecondOrder && self.trees[k].colour == Colour::First;
        let mut text = format!("Σ {weights}_i");
        // A vertex of q̇ = p only passes on what it carries.
        let root = if is_bar { self.trees[k].children[0] } else { k };
        self.factors(root, spelled, 0, &mut 1, &mut text);
        text
    }

    fn factors(&self, k: usize, spelled: [bool; 2], index: usize, used: &mut usize, out: &mut String) {
        let name = |index: usize| char::from(b'i' + (index % 18) as u8);
        let children = &self.trees[k].children;
        let time = (Colour::Time, "c", None);
        let [first, second] = spelled;
        let parts = [(Colour::First, "c", first.then_some("a")), (Colour::Second, "ĉ", second.then_some("â")), time];
        for (colour, symbol, matrix) in parts {
            let is_such = |child: &&usize| self.trees[**child].order == 1 && self.trees[**child].colour == colour;
            let count = children.iter().filter(is_such).count();
            match matrix {
                Some(matrix) => {
                    for next in *used..*used + count {
                        let _ = write!(out, " {matrix}_{}{}", name(index), name(next));
                    }
                    *used += count;
                }
                None if count > 0 => {
                    let _ = write!(out, " {}", power(&format!("{symbol}_{}", name(index)), count));
                }
                None => {}
            }
        }
        for &child in children.iter().rev().filter(|&&child| self.trees[child].order > 1) {
            let next = *used;
            *used += 1;
            let (symbol, below) = match (self.rule, self.trees[child].colour) {
                (Rule::SecondOrder, _) => ("ā", self.trees[child].children[0]),
                (_, Colour::Second) => ("â", child),
                _ => ("a", child),
            };
            let _ = write!(out, " {symbol}_{}{}", name(index), name(next));
            self.factors(below, spelled, next, used, out);
        }
    }
}

/// `c_i³`.
pub(super) fn power(text: &str, count: usize) -> String {
    const DIGITS: [&str; 10] = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
    let digits = count.to_string().bytes().map(|digit| DIGITS[usize::from(digit - b'0')]).collect::<String>();
    if count == 1 { text.to_owned() } else { text.to_owned() + &digits }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::f64::consts::SQRT_2;

    use super::*;

    /// The counts of rooted trees, OEIS A000081.
    #[test]
    fn there_are_as_many_trees_of_each_order_as_there_should_be() {
        let forest = Forest::new(Rule::Autonomous, MAX_ORDER);
        let counts: Vec<usize> = (1..=MAX_ORDER).map(|n| forest.of_order(n).count()).collect();
        assert_eq!(counts, [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]);
    }

    /// Σ 1/(σ γ) over the trees of order n is 1/n!·Σ α = 1/n: ẏ = eʸ gives y⁽ⁿ⁾(0) = (n − 1)!, Σ n!/(σγ) = (n − 1)!.
    #[test]
    fn densities_and_symmetries_add_up_to_the_derivatives_of_a_known_solution() {
        let forest = Forest::new(Rule::Autonomous, MAX_ORDER);
        for n in 1..=MAX_ORDER {
            let trees = forest.of_order(n).map(|k| &forest.trees()[k]);
            let sum: f64 = trees.map(|tree| 1.0 / (tree.symmetry as f64 * tree.density as f64)).sum();
            assert!((sum * f64::from(n) - 1.0).abs() < 1e-13, "{n}: {sum}");
        }
    }

    /// Of two colours (\[HLW06\] III.2: 2, 4, 14, 52; OEIS A000151); twice the plain ones where neighbours differ; of
    /// Nyström's (\[HNW93\] II.14: those of ẏ 1, 1, 2, 3, 6, 10, 20, …, those of y the same one order higher).
    #[test]
    fn there_are_as_many_coloured_trees_as_there_should_be() {
        let counts = |rule: Rule, most: u32| {
            let forest = Forest::new(rule, most);
            (1..=most).map(|n| forest.of_order(n).count()).collect::<Vec<_>>()
        };
        assert_eq!(counts(Rule::Partitioned, 5), [2, 4, 14, 52, 214]);
        assert_eq!(counts(Rule::Separable, 6), [2, 2, 4, 8, 18, 40]);
        assert_eq!(counts(Rule::SecondOrder, 7), [1, 2, 3, 5, 9, 16, 30]);
    }

    /// A product of powers of q̇ and ṗ, by their exponents, times a factor.
    type Terms = BTreeMap<[i32; 2], f64>;

    /// The derivatives of q and of p at t = 0 of q̇ = e^(a·(t, q, p)), ṗ = e^(b·(t, q, p)) with q = p = 0 there: both grow by what is
    /// in their exponents, u̇ = u (a_t + a_q u + a_p w) and so ẇ.
    fn derivatives(rates: [[f64; 3]; 2], order: u32) -> Vec<[f64; 2]> {
        let derivative = |terms: &Terms| {
            let mut sum = Terms::new();
            for (powers, factor) in terms {
                for (power, [of_t, of_q, of_p]) in powers.iter().zip(rates) {
                    let [u, w] = *powers;
                    for (to, rate) in [([u, w], of_t), ([u + 1, w], of_q), ([u, w + 1], of_p)] {
                        *sum.entry(to).or_default() += f64::from(*power) * rate * factor;
                    }
                }
            }
            sum
        };
        let mut terms = [[1, 0], [0, 1]].map(|powers| Terms::from([(powers, 1.0)]));
        let mut found = Vec::new();
        for _ in 0..order {
            found.push(terms.each_ref().map(|terms| terms.values().sum()));
            terms = terms.each_ref().map(derivative);
        }
        found
    }

    /// Where every elementary differential is 1, Σ n!/(σ γ) over the trees of order n with a root of one colour is the n-th derivative: of
    /// exponentials, with every tree that is made and none besides.
    #[test]
    fn all_trees_of_every_rule_add_up_to_the_derivatives_of_exponentials() {
        let separable = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
        let (both, with_time) = ([[0.0, 1.0, 1.0]; 2], [[1.0, 1.0, 1.0]; 2]);
        for (rule, time, rates) in [
            (Rule::Autonomous, false, [[0.0, 1.0, 0.0]; 2]),
            (Rule::Autonomous, true, [[1.0, 1.0, 0.0]; 2]),
            (Rule::Partitioned, false, both),
            (Rule::Partitioned, true, with_time),
            (Rule::Separable, false, separable),
            (Rule::Separable, true, [separable[0], [1.0, 1.0, 0.0]]),
        ] {
            let forest = Forest::grown(rule, rule.most(), time);
            let known = derivatives(rates, rule.most());
            for (n, known) in (1..).zip(known) {
                for (colour, known) in rule.colours().iter().zip(known) {
                    let trees = forest.of_order(n).map(|k| &forest.trees()[k]).filter(|tree| tree.colour == *colour);
                    let sum: f64 = trees.map(|tree| 1.0 / (tree.symmetry as f64 * tree.density as f64)).sum();
                    let sum = (1..=n).map(f64::from).product::<f64>() * sum;
                    // A rounding for each of some thousand terms.
                    approx::assert_relative_eq!(sum, known, max_relative = 1e-12);
                }
            }
        }
    }

    /// On q̈ = e^q with q = 0 and q̇ = √2, q̇ = √2/(1 − t/√2): a vertex of q that carries nothing is √2.
    #[test]
    fn all_trees_of_a_second_order_system_add_up_to_the_derivatives_of_its_solution() {
        let forest = Forest::new(Rule::SecondOrder, Rule::SecondOrder.most());
        let mut value: Vec<f64> = Vec::new();
        for tree in forest.trees() {
            let is_speed = tree.order == 1 && tree.colour == Colour::First;
            value.push(if is_speed { SQRT_2 } else { tree.children.iter().map(|k| value[*k]).product() });
        }
        for n in 2..=forest.order() {
            let of = |colour: Colour| -> f64 {
                let trees = forest.of_order(n).map(|k| (&forest.trees()[k], value[k]));
                let trees = trees.filter(|(tree, _)| tree.colour == colour);
                trees.map(|(tree, value)| value / (tree.symmetry as f64 * tree.density as f64)).sum()
            };
            // Taylor coefficients of q and of q̇.
            let known = |n: u32| SQRT_2.powi(1 - n as i32);
            approx::assert_relative_eq!(of(Colour::Second), known(n), max_relative = 1e-13);
            approx::assert_relative_eq!(of(Colour::First), known(n - 1) / f64::from(n), max_relative = 1e-13);
        }
    }

    /// With q̇ = f(p), ṗ = g(t, q) a vertex of p carries time, and none of q does.
    #[test]
    fn time_is_in_the_forces_of_separable_systems_alone() {
        let forest = Forest::with_time(Rule::Separable, 2);
        let colour = |k: usize| forest.trees()[k].colour;
        let mut pairs: Vec<_> = forest
            .of_order(2)
            .map(|k| (colour(k), forest.trees()[k].children.iter().map(|k| colour(*k)).collect()))
            .collect();
        pairs.sort();
        let (first, second) = (Colour::First, Colour::Second);
        let expected: [(Colour, Vec<Colour>); 3] =
            [(first, vec![second]), (second, vec![first]), (second, vec![Colour::Time])];
        assert_eq!(pairs, expected);
    }

    /// q̇ = p, ṗ = q is linear: of each order one tree of each colour has no branching, with density n!.
    #[test]
    fn coloured_trees_without_branches_have_the_density_of_the_exponential() {
        let forest = Forest::new(Rule::SecondOrder, 7);
        let is_tall = |k: usize| {
            std::iter::successors(Some(k), |k| forest.trees()[*k].children.first().copied())
                .all(|k| forest.trees()[k].children.len() < 2)
        };
        for n in 2..=7 {
            let tall: Vec<u64> =
                forest.of_order(n).filter(|k| is_tall(*k)).map(|k| forest.trees()[k].density).collect();
            assert_eq!(tall, [(1..=u64::from(n)).product::<u64>(); 2]);
        }
    }

    #[test]
    fn powers_have_all_their_digits() {
        assert_eq!([1, 2, 9, 10, 12].map(|n| power("c_i", n)), ["c_i", "c_i²", "c_i⁹", "c_i¹⁰", "c_i¹²"]);
    }

    #[test]
    fn trees_are_written_as_in_the_textbooks() {
        let forest = Forest::new(Rule::Autonomous, 4);
        let shown: Vec<String> = forest
            .of_order(4)
            .map(|k| format!("{} {}", forest.brackets(k), forest.formula(k, "b", [false; 2])))
            .collect();
        for expected in
            ["[[[τ]]] Σ b_i a_ij a_jk c_k", "[[τ²]] Σ b_i a_ij c_j²", "[τ,[τ]] Σ b_i c_i a_ij c_j", "[τ³] Σ b_i c_i³"]
        {
            assert!(shown.iter().any(|text| text == expected), "{expected} is not among {shown:?}");
        }
    }

    #[test]
    fn a_leaf_for_time_is_grafted_from_the_second_order_on() {
        let counts = [0, 1, 2].map(|order| Forest::with_time(Rule::Autonomous, order).trees().len());
        assert_eq!(counts, [0, 1, 4]);
    }
}
