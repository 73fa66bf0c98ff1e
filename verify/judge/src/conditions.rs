//! Order conditions of Runge–Kutta methods: Φ(τ) = 1/γ(τ) for every rooted tree τ of at most p vertices.

use super::real::{Real, dot};
use super::tableau::{Numbers, row_sums};
use super::tree::{Colour, Forest};

/// One condition, with what the coefficients make of it.
#[derive(Debug, Clone)]
pub struct Condition {
    /// Number of vertices of its tree.
    pub order: u32,
    /// Place of the tree in its forest.
    pub tree: usize,
    /// Φ − 1/γ, uncertain by what rounded coefficients make it.
    pub residual: Real,
}

impl Condition {
    /// Whether it holds to within the digits given.
    pub fn holds(&self) -> bool {
        self.residual.may_be_zero()
    }
}

/// What the vertices of one colour bring to a condition.
#[derive(Debug, Clone)]
pub(super) struct Part<'a> {
    /// The matrix that carries a subtree to the stages of its parent.
    pub a: &'a [Vec<Real>],
    /// What a leaf puts at each stage.
    pub leaf: Vec<Real>,
}

/// Stage values of the subtrees of a forest.
#[derive(Debug)]
pub(super) struct Weights<'a> {
    forest: &'a Forest,
    /// Of the first and the second colour.
    parts: [Part<'a>; 2],
    /// What the vertex of time puts at each stage.
    c: &'a [Real],
    /// For each tree the product over its root's subtrees at each stage, and the same times A; made when needed.
    products: Vec<Option<Vec<Real>>>,
    carried: Vec<Option<Vec<Real>>>,
}

impl<'a> Weights<'a> {
    /// Those of a Runge–Kutta method.
    pub(super) fn new(forest: &'a Forest, numbers: &'a Numbers) -> Self {
        let part = Part { a: &numbers.a, leaf: row_sums(&numbers.a) };
        Self::of_parts(forest, [part.clone(), part], &numbers.c)
    }

    /// Those of a method with coefficients for each colour.
    pub(super) fn of_parts(forest: &'a Forest, parts: [Part<'a>; 2], c: &'a [Real]) -> Self {
        let n = forest.trees().len();
        Self { forest, parts, c, products: vec![None; n], carried: vec![None; n] }
    }

    /// Φ(τ_k) − 1/γ for the weights `b`.
    pub(super) fn residual(&mut self, k: usize, b: &[Real]) -> Real {
        self.prepare(k);
        let density = Real::from(i64::try_from(self.forest.trees()[k].density).unwrap_or(i64::MAX));
        let phi = self.products[k].as_deref().map_or_else(Real::zero, |products| dot(b, products));
        &phi - &(&Real::one() / &density)
    }

    /// Makes the products of tree `k`, and those below it.
    fn prepare(&mut self, k: usize) {
        if self.products[k].is_some() {
            return;
        }
        let forest = self.forest;
        let mut product = vec![Real::one(); self.c.len()];
        for &child in &forest.trees()[k].children {
            self.carry(child);
            if let Some(carried) = &self.carried[child] {
                for (p, x) in product.iter_mut().zip(carried) {
                    *p = &*p * x;
                }
            }
        }
        self.products[k] = Some(product);
    }

    /// What tree `k` puts at each stage as a subtree.
    fn carry(&mut self, k: usize) {
        if self.carried[k].is_some() {
            return;
        }
        let tree = &self.forest.trees()[k];
        let part = match tree.colour {
            Colour::Time => None,
            Colour::First => Some(0),
            Colour::Second => Some(1),
        };
        let carried = match part {
            None => self.c.to_vec(),
            Some(part) if tree.children.is_empty() => self.parts[part].leaf.clone(),
            Some(part) => {
                self.prepare(k);
                let products = self.products[k].as_deref().unwrap_or_default();
                self.parts[part].a.iter().map(|row| dot(row, products)).collect()
            }
        };
        self.carried[k] = Some(carried);
    }
}

/// Every condition of `forest` for the weights `b` of `numbers`.
pub fn conditions(forest: &Forest, numbers: &Numbers, b: &[Real]) -> Vec<Condition> {
    conditions_of(Weights::new(forest, numbers), [b, b])
}

/// Every condition on `weights`, with the b of the colour of each root.
pub(super) fn conditions_of(mut weights: Weights<'_>, b: [&[Real]; 2]) -> Vec<Condition> {
    let forest = weights.forest;
    let all = (1..=forest.order()).flat_map(|n| forest.of_order(n).map(move |k| (n, k)));
    let b = |tree: usize| b[usize::from(forest.trees()[tree].colour == Colour::Second)];
    all.map(|(order, tree)| Condition { order, tree, residual: weights.residual(tree, b(tree)) }).collect()
}

/// The largest p up to which all `conditions` hold; the forest's order if all do.
pub fn order_of(conditions: &[Condition]) -> u32 {
    let last = conditions.last().map_or(0, |c| c.order);
    conditions.iter().find(|c| !c.holds()).map_or(last, |c| c.order - 1)
}

/// √Σ (residual/σ)² over the trees of order `n`: the principal error norm A⁽ⁿ⁾ of Prince and Dormand for n = p + 1.
pub fn error_norm(forest: &Forest, conditions: &[Condition], n: u32) -> f64 {
    let term = |c: &Condition| (c.residual.to_f64() / forest.trees()[c.tree].symmetry as f64).powi(2);
    conditions.iter().filter(|c| c.order == n).map(term).sum::<f64>().sqrt()
}
