//! Order conditions of Runge–Kutta methods: Φ(τ) = 1/γ(τ) for every rooted tree τ of at most p vertices.

use super::real::{Real, dot};
use super::tableau::{Numbers, row_sums};
use super::tree::Forest;

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

/// Stage values of the subtrees of a forest for one matrix A and one c.
#[derive(Debug)]
pub(super) struct Weights<'a> {
    forest: &'a Forest,
    a: &'a [Vec<Real>],
    /// What the vertex of time puts at each stage.
    c: &'a [Real],
    /// Σ_j a_ij, which a leaf puts at stage i.
    rows: Vec<Real>,
    /// For each tree the product over its root's subtrees at each stage, and the same times A; made when needed.
    products: Vec<Option<Vec<Real>>>,
    carried: Vec<Option<Vec<Real>>>,
}

impl<'a> Weights<'a> {
    pub(super) fn new(forest: &'a Forest, numbers: &'a Numbers) -> Self {
        let n = forest.trees().len();
        let (a, c) = (&numbers.a, &numbers.c);
        Self { forest, a, c, rows: row_sums(a), products: vec![None; n], carried: vec![None; n] }
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
        let mut product = vec![Real::one(); self.a.len()];
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
        let carried = if tree.is_time {
            self.c.to_vec()
        } else if tree.children.is_empty() {
            self.rows.clone()
        } else {
            self.prepare(k);
            let products = self.products[k].as_deref().unwrap_or_default();
            self.a.iter().map(|row| dot(row, products)).collect()
        };
        self.carried[k] = Some(carried);
    }
}

/// Every condition of `forest` for the weights `b` of `numbers`.
pub fn conditions(forest: &Forest, numbers: &Numbers, b: &[Real]) -> Vec<Condition> {
    let mut weights = Weights::new(forest, numbers);
    let all = (1..=forest.order()).flat_map(|n| forest.of_order(n).map(move |k| (n, k)));
    all.map(|(order, tree)| Condition { order, tree, residual: weights.residual(tree, b) }).collect()
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
