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
    /// Whether it is the vertex of time, whose stage values are the c_i as given: ∂f/∂t puts it where ∂f/∂v puts a subtree.
    pub is_time: bool,
}

/// All rooted trees up to an order, each after its subtrees.
#[derive(Debug, Clone)]
pub struct Forest {
    trees: Vec<Tree>,
    order: u32,
}

impl Forest {
    /// The trees of autonomous equations, Σ over j of a_ij standing for every c_i: 1, 1, 2, 4, 9, 20, 48, 115, … of them.
    pub fn autonomous(order: u32) -> Self {
        Self::grow(order, false)
    }

    /// Those and the ones in which time itself is differentiated, where c_i need not be the sum of row i.
    pub fn with_time(order: u32) -> Self {
        Self::grow(order, true)
    }

    fn grow(order: u32, with_time: bool) -> Self {
        let order = order.min(MAX_ORDER);
        let leaf = |is_time| Tree { order: 1, density: 1, symmetry: 1, children: Vec::new(), is_time };
        let mut forest = Self { trees: if order == 0 { Vec::new() } else { vec![leaf(false)] }, order };
        if with_time && order > 1 {
            forest.trees.push(leaf(true));
        }
        for n in 2..=order {
            let known = forest.trees.len();
            forest.graft(n, n - 1, known, &mut Vec::new());
        }
        forest
    }

    /// Adds the trees of order `n` whose root carries `children` and further ones of `left` vertices, none of them at or after
    /// place `below`.
    fn graft(&mut self, n: u32, left: u32, below: usize, children: &mut Vec<usize>) {
        if left == 0 {
            let density = children.iter().map(|&k| self.trees[k].density).product::<u64>() * u64::from(n);
            let mut symmetry = 1;
            for (i, &k) in children.iter().enumerate() {
                let repeated = children[..=i].iter().filter(|&&other| other == k).count() as u64;
                symmetry *= self.trees[k].symmetry * repeated;
            }
            self.trees.push(Tree { order: n, density, symmetry, children: children.clone(), is_time: false });
            return;
        }
        for k in (0..below).rev() {
            if self.trees[k].order <= left {
                children.push(k);
                self.graft(n, left - self.trees[k].order, k + 1, children);
                children.pop();
            }
        }
    }

    /// The trees, of lower order first.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// The largest order.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The places of the trees that state a condition of order `n`; the vertex of time states none.
    pub fn of_order(&self, n: u32) -> impl Iterator<Item = usize> {
        self.trees.iter().enumerate().filter(move |(_, tree)| tree.order == n && !tree.is_time).map(|(k, _)| k)
    }

    /// The tree in brackets: `[τ²,[τ]]`, with `t` for the vertex of time.
    pub fn brackets(&self, k: usize) -> String {
        let tree = &self.trees[k];
        if tree.children.is_empty() {
            return if tree.is_time { "t" } else { "τ" }.into();
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
        format!("[{}]", parts.join(","))
    }

    /// The sum of the condition in coefficients: `Σ b_i c_i a_ij c_j²`. Where c and the row sums of A differ, r_i stands for
    /// the sum of row i.
    pub fn formula(&self, k: usize, weights: &str, separate_rows: bool) -> String {
        let mut used = 1;
        let mut text = format!("Σ {weights}_i");
        self.factors(k, 0, &mut used, separate_rows, &mut text);
        text
    }

    fn factors(&self, k: usize, index: usize, used: &mut usize, separate_rows: bool, out: &mut String) {
        let name = |index: usize| char::from(b'i' + (index % 18) as u8);
        let children = &self.trees[k].children;
        for (leaf, symbol) in [(false, if separate_rows { 'r' } else { 'c' }), (true, 'c')] {
            let is_such = |child: &&usize| self.trees[**child].order == 1 && self.trees[**child].is_time == leaf;
            let count = children.iter().filter(is_such).count();
            if count > 0 {
                let _ = write!(out, " {}", power(&format!("{symbol}_{}", name(index)), count));
            }
        }
        for &child in children.iter().rev().filter(|&&child| self.trees[child].order > 1) {
            let next = *used;
            *used += 1;
            let _ = write!(out, " a_{}{}", name(index), name(next));
            self.factors(child, next, used, separate_rows, out);
        }
    }
}

fn power(text: &str, count: usize) -> String {
    const DIGITS: [&str; 10] = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
    if count == 1 { text.to_owned() } else { format!("{text}{}", DIGITS[count.min(9)]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The counts of rooted trees, OEIS A000081.
    #[test]
    fn there_are_as_many_trees_of_each_order_as_there_should_be() {
        let forest = Forest::autonomous(MAX_ORDER);
        let counts: Vec<usize> = (1..=MAX_ORDER).map(|n| forest.of_order(n).count()).collect();
        assert_eq!(counts, [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]);
    }

    /// Σ 1/(σ γ) over the trees of order n is 1/n!·Σ α = 1/n: ẏ = eʸ gives y⁽ⁿ⁾(0) = (n − 1)!, Σ n!/(σγ) = (n − 1)!.
    #[test]
    fn densities_and_symmetries_add_up_to_the_derivatives_of_a_known_solution() {
        let forest = Forest::autonomous(MAX_ORDER);
        for n in 1..=MAX_ORDER {
            let trees = forest.of_order(n).map(|k| &forest.trees()[k]);
            let sum: f64 = trees.map(|tree| 1.0 / (tree.symmetry as f64 * tree.density as f64)).sum();
            assert!((sum * f64::from(n) - 1.0).abs() < 1e-13, "{n}: {sum}");
        }
    }

    #[test]
    fn trees_are_written_as_in_the_textbooks() {
        let forest = Forest::autonomous(4);
        let shown: Vec<String> =
            forest.of_order(4).map(|k| format!("{} {}", forest.brackets(k), forest.formula(k, "b", false))).collect();
        for expected in
            ["[[[τ]]] Σ b_i a_ij a_jk c_k", "[[τ²]] Σ b_i a_ij c_j²", "[τ,[τ]] Σ b_i c_i a_ij c_j", "[τ³] Σ b_i c_i³"]
        {
            assert!(shown.iter().any(|text| text == expected), "{expected} is not among {shown:?}");
        }
    }
}
