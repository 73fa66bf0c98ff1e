//! Quadrature rules and polynomial bases on the unit interval.

use nalgebra::DMatrix;

use crate::error::{InputError, NodeError, check_vector};

/// A quadrature rule on \[0, 1\]: ∫ f ≈ Σ b_i f(c_i).
///
/// Nodes of the rules by name are in ascending order: ends of the interval, and zeros of P_n (Gauss), P′_{n−1} (Lobatto) or (P_n − P_{n−1})/(1 − x) (Radau),
/// of Legendre's polynomials on \[−1, 1\], by Newton's method. Nodes and weights have absolute errors of a few ε, so that polynomials of the rule's degree are integrated
/// to 4(n + 1)ε; relative to itself the first weight of Radau's rule, which is small, has lost digits to 1 + x beside x = −1.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl Quadrature {
    /// Any rule: distinct `nodes` in \[0, 1\] with as many `weights`, which sum to 1.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] without nodes, [`NodeError::NodeRange`] for one outside the unit interval,
    /// [`NodeError::CoincidentNodes`] if two agree to within rounding, [`NodeError::WeightSum`] if the weights do not sum to 1 as
    /// far as seven digits of each show; [`SystemError`](crate::SystemError) for weights that are not finite, or not as many.
    pub fn new(nodes: Vec<f64>, weights: Vec<f64>) -> Result<Self, InputError> {
        check_distinct("quadrature nodes", &nodes)?;
        let rule = Self::inconsistent(nodes, weights)?;
        check_sum(&rule.weights)?;
        Ok(rule)
    }

    /// As [`new`](Self::new), but nodes may coincide and the weights sum to anything: to see what a slip in them does.
    ///
    /// # Errors
    /// As for [`new`](Self::new) otherwise.
    pub fn inconsistent(nodes: Vec<f64>, weights: Vec<f64>) -> Result<Self, InputError> {
        at_least("quadrature nodes", 1, nodes.len())?;
        check_vector("weights", &weights, nodes.len())?;
        check_range(&nodes)?;
        Ok(Self { nodes, weights })
    }

    /// Gauss's rule with n nodes, exact for degree 2n − 1.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] if n = 0.
    pub fn gauss(n: usize) -> Result<Self, InputError> {
        at_least("Gauss nodes", 1, n)?;
        Ok(Self::on_unit_interval((0..n).map(|k| {
            let guess = -(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let x = newton(guess, |x| {
                let p = Legendre::at(n, x);
                p.value / p.first
            });
            let slope = Legendre::at(n, x).first;
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })))
    }

    /// Lobatto's rule with n ≥ 2 nodes, among them both ends, exact for degree 2n − 3.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] if n < 2.
    pub fn lobatto(n: usize) -> Result<Self, InputError> {
        at_least("Lobatto nodes", 2, n)?;
        let last = n - 1;
        let scale = 2.0 / (n as f64 * last as f64);
        Ok(Self::on_unit_interval((0..n).map(|k| {
            if k == 0 || k == last {
                return (if k == 0 { -1.0 } else { 1.0 }, scale);
            }
            let guess = -(std::f64::consts::PI * k as f64 / last as f64).cos();
            let x = newton(guess, |x| {
                let p = Legendre::at(last, x);
                p.first / p.second(x)
            });
            (x, scale / Legendre::at(last, x).value.powi(2))
        })))
    }

    /// Radau's right rule (that of Radau IIA) with n nodes, the last at 1, exact for degree 2n − 2.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] if n = 0.
    pub fn radau(n: usize) -> Result<Self, InputError> {
        at_least("Radau nodes", 1, n)?;
        let square = (n * n) as f64;
        Ok(Self::on_unit_interval((0..n).rev().map(|k| {
            if k == 0 {
                return (1.0, 2.0 / square);
            }
            // The others are zeros of (P_n − P_{n−1})/(1 − x).
            let guess = (2.0 * std::f64::consts::PI * k as f64 / (2.0 * n as f64 - 1.0)).cos();
            let x = newton(guess, |x| {
                let (p, q) = (Legendre::at(n, x), Legendre::at(n - 1, x));
                let (value, slope) = (p.value - q.value, p.first - q.first);
                value * (1.0 - x) / (slope * (1.0 - x) + value)
            });
            (x, (1.0 + x) / (square * Legendre::at(n - 1, x).value.powi(2)))
        })))
    }

    fn on_unit_interval(rule: impl Iterator<Item = (f64, f64)>) -> Self {
        let (nodes, weights) = rule.map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w)).unzip();
        Self { nodes, weights }
    }

    /// The nodes c_i.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The weights b_i.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }
}

/// Refuses weights that do not sum to 1 to within the rounding of seven printed digits.
pub(crate) fn check_sum(weights: &[f64]) -> Result<(), InputError> {
    const PRINTED: f64 = 5e-8;
    let sum: f64 = weights.iter().sum();
    let is_one = (sum - 1.0).abs() <= PRINTED * weights.iter().map(|b| b.abs().max(1.0)).sum::<f64>();
    if is_one { Ok(()) } else { Err(InputError::Nodes(NodeError::WeightSum { sum })) }
}

/// Refuses nodes outside the unit interval.
fn check_range(nodes: &[f64]) -> Result<(), InputError> {
    match nodes.iter().position(|x| !(0.0..=1.0).contains(x)) {
        Some(index) => Err(InputError::Nodes(NodeError::NodeRange { index, value: nodes[index] })),
        None => Ok(()),
    }
}

/// Refuses nodes that are none, outside the unit interval, or the same to within rounding.
fn check_distinct(what: &'static str, nodes: &[f64]) -> Result<(), InputError> {
    at_least(what, 1, nodes.len())?;
    check_range(nodes)?;
    for (second, &value) in nodes.iter().enumerate() {
        if let Some(first) = nodes[..second].iter().position(|b| (b - value).abs() < 16.0 * f64::EPSILON) {
            return Err(InputError::Nodes(NodeError::CoincidentNodes { first, second, value }));
        }
    }
    Ok(())
}

fn at_least(what: &'static str, least: usize, found: usize) -> Result<(), InputError> {
    if found < least { Err(InputError::Nodes(NodeError::TooFew { what, least, found })) } else { Ok(()) }
}

/// The zero near `x` of the function whose Newton step is `step`.
fn newton(mut x: f64, step: impl Fn(f64) -> f64) -> f64 {
    let mut last = f64::INFINITY;
    loop {
        let dx = step(x);
        // From these starts convergence is quadratic; increments stop shrinking at roundoff.
        if dx.is_nan() || dx.abs() >= last {
            return x;
        }
        x -= dx;
        last = dx.abs();
    }
}

/// Legendre's polynomial P_n and its derivatives at a point of (−1, 1).
struct Legendre {
    n: f64,
    value: f64,
    first: f64,
}

impl Legendre {
    fn at(n: usize, x: f64) -> Self {
        let (mut before, mut value) = (0.0, 1.0);
        let (mut first_before, mut first) = (0.0, 0.0);
        for k in 0..n {
            let k = k as f64;
            // The recurrence P′_{k+1} = P′_{k−1} + (2k+1) P_k has no 1 − x² to divide by.
            (first_before, first) = (first, first_before + (2.0 * k + 1.0) * value);
            (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
        }
        Self { n: n as f64, value, first }
    }

    fn second(&self, x: f64) -> f64 {
        (2.0 * x * self.first - self.n * (self.n + 1.0) * self.value) / (1.0 - x * x)
    }
}

/// Families of interior nodes of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NodeFamily {
    /// i/m, those of \[KY21\].
    Equispaced,
    /// The m − 1 Gauss nodes.
    Gauss,
    /// The interior ones of the m + 1 Lobatto nodes.
    Lobatto,
    /// The zeros of Chebyshev's polynomial of degree m − 1.
    Chebyshev,
}

impl NodeFamily {
    /// The m − 1 interior nodes of a path of degree m ≥ 2.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] if m < 2.
    pub fn interior(self, m: usize) -> Result<Vec<f64>, InputError> {
        at_least("degree of the path", 2, m)?;
        let inner = 1..m;
        Ok(match self {
            Self::Equispaced => inner.map(|i| i as f64 / m as f64).collect(),
            Self::Gauss => Quadrature::gauss(m - 1)?.nodes,
            Self::Lobatto => Quadrature::lobatto(m + 1)?.nodes[inner].to_vec(),
            Self::Chebyshev => {
                let half_angle = |i| std::f64::consts::PI * (2 * i - 1) as f64 / (4 * (m - 1)) as f64;
                inner.map(|i| f64::sin(half_angle(i)).powi(2)).collect()
            }
        })
    }
}

/// Polynomials that span those of some degree, on \[0, 1\].
///
/// They sum to 1, and one of them belongs to each control value of a path Σ x_j φ_j(c).
pub(crate) trait Basis {
    /// φ_j(c) for every j.
    fn values(&self, c: f64) -> Vec<f64>;
    /// φ_j′(c).
    fn first(&self, c: f64) -> Vec<f64>;
    /// φ_j″(c).
    fn second(&self, c: f64) -> Vec<f64>;
    /// The control values of the path x(c) = c.
    fn abscissae(&self) -> Vec<f64>;
}

/// Lagrange's basis l_j(c_i) = δ_ij on given nodes, by barycentric formulas.
#[derive(Debug, Clone, PartialEq)]
pub struct LagrangeBasis {
    nodes: Vec<f64>,
    barycentric: Vec<f64>,
    first: DMatrix<f64>,
    second: DMatrix<f64>,
}

impl LagrangeBasis {
    /// The basis on `nodes`, in any order.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] without nodes, [`NodeError::NodeRange`] for one outside \[0, 1\],
    /// [`NodeError::CoincidentNodes`] if two agree to within rounding.
    pub fn new(nodes: &[f64]) -> Result<Self, InputError> {
        check_distinct("nodes", nodes)?;
        let n = nodes.len();
        let others = |j: usize| (0..n).filter(move |&i| i != j);
        // The unit interval has capacity 1/4: factors of 4 keep the products near 1.
        let weight = |j: usize| others(j).map(|i| 4.0 * (nodes[j] - nodes[i])).product::<f64>().recip();
        let barycentric: Vec<f64> = (0..n).map(weight).collect();
        let mut first = DMatrix::zeros(n, n);
        let mut second = DMatrix::zeros(n, n);
        for i in 0..n {
            // Diagonals by the negative sum, so that constants have derivative zero to the last bit.
            for j in others(i) {
                first[(i, j)] = barycentric[j] / barycentric[i] / (nodes[i] - nodes[j]);
            }
            first[(i, i)] = -first.row(i).sum();
            for j in others(i) {
                second[(i, j)] = 2.0 * first[(i, j)] * (first[(i, i)] - (nodes[i] - nodes[j]).recip());
            }
            second[(i, i)] = -second.row(i).sum();
        }
        Ok(Self { nodes: nodes.to_vec(), barycentric, first, second })
    }

    /// The nodes.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The differentiation matrix l_j′(c_i).
    pub fn differentiation(&self) -> &DMatrix<f64> {
        &self.first
    }

    /// The second differentiation matrix l_j″(c_i).
    pub fn second_differentiation(&self) -> &DMatrix<f64> {
        &self.second
    }

    /// l_j(c) for every j.
    pub fn values(&self, c: f64) -> Vec<f64> {
        if let Some(at) = self.nodes.iter().position(|&x| x == c) {
            return (0..self.nodes.len()).map(|j| if j == at { 1.0 } else { 0.0 }).collect();
        }
        let terms: Vec<f64> = self.nodes.iter().zip(&self.barycentric).map(|(x, w)| w / (c - x)).collect();
        let sum: f64 = terms.iter().sum();
        terms.into_iter().map(|t| t / sum).collect()
    }

    /// l_j′(c) for every j.
    pub fn derivatives(&self, c: f64) -> Vec<f64> {
        self.interpolate(&self.first, c)
    }

    /// l_j″(c) for every j.
    pub fn second_derivatives(&self, c: f64) -> Vec<f64> {
        self.interpolate(&self.second, c)
    }

    /// Derivatives are polynomials of lower degree: their values at the nodes determine them.
    fn interpolate(&self, at_nodes: &DMatrix<f64>, c: f64) -> Vec<f64> {
        let l = self.values(c);
        at_nodes.column_iter().map(|column| column.iter().zip(&l).map(|(d, l)| d * l).sum()).collect()
    }
}

impl Basis for LagrangeBasis {
    fn values(&self, c: f64) -> Vec<f64> {
        self.values(c)
    }
    fn first(&self, c: f64) -> Vec<f64> {
        self.derivatives(c)
    }
    fn second(&self, c: f64) -> Vec<f64> {
        self.second_derivatives(c)
    }
    fn abscissae(&self) -> Vec<f64> {
        self.nodes.clone()
    }
}

/// Bernstein's basis b_j = C(m, j) c^j (1 − c)^{m−j}, \[KY21\] (13).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BernsteinBasis {
    degree: usize,
}

impl BernsteinBasis {
    /// The basis of degree m.
    pub fn new(degree: usize) -> Self {
        Self { degree }
    }

    /// b_j(c) for every j.
    pub fn values(&self, c: f64) -> Vec<f64> {
        self.differences(0, c)
    }

    /// b_j′(c) for every j.
    pub fn derivatives(&self, c: f64) -> Vec<f64> {
        self.differences(1, c)
    }

    /// b_j″(c) for every j.
    pub fn second_derivatives(&self, c: f64) -> Vec<f64> {
        self.differences(2, c)
    }

    /// The k-th derivatives: m(m−1)…(m−k+1) times the k-th differences of the basis of degree m − k.
    fn differences(&self, k: usize, c: f64) -> Vec<f64> {
        let m = self.degree;
        if k > m {
            return vec![0.0; m + 1];
        }
        let mut b = vec![0.0; m + 1];
        b[0] = 1.0;
        for degree in 1..=m {
            // Raise the degree by averaging with weights c, 1 − c, or by differences in the last k rounds.
            let (up, stay) = if degree + k > m { (degree as f64, -(degree as f64)) } else { (c, 1.0 - c) };
            for j in (1..=degree).rev() {
                b[j] = up * b[j - 1] + stay * b[j];
            }
            b[0] *= stay;
        }
        b
    }
}

impl Basis for BernsteinBasis {
    fn values(&self, c: f64) -> Vec<f64> {
        self.values(c)
    }
    fn first(&self, c: f64) -> Vec<f64> {
        self.derivatives(c)
    }
    fn second(&self, c: f64) -> Vec<f64> {
        self.second_derivatives(c)
    }
    fn abscissae(&self) -> Vec<f64> {
        (0..=self.degree).map(|j| j as f64 / self.degree.max(1) as f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPS: f64 = f64::EPSILON;

    #[test]
    fn legendre_s_polynomials_have_their_derivatives() {
        let p = Legendre::at(3, 0.25);
        // P₃ = (5x³ − 3x)/2.
        approx::assert_abs_diff_eq!(p.value, 0.5 * (5.0 * 0.015625 - 0.75), epsilon = 4.0 * EPS);
        approx::assert_abs_diff_eq!(p.first, 0.5 * (15.0 * 0.0625 - 3.0), epsilon = 8.0 * EPS);
        approx::assert_abs_diff_eq!(p.second(0.25), 15.0 * 0.25, epsilon = 64.0 * EPS);
    }

    #[test]
    fn a_basis_tells_its_nodes() {
        assert_eq!(LagrangeBasis::new(&[0.5, 0.0, 1.0]).expect("distinct").nodes(), [0.5, 0.0, 1.0]);
    }

    #[test]
    fn rules_are_exact_to_their_degree_and_no_further() {
        type Rule = fn(usize) -> Result<Quadrature, InputError>;
        let rules: [(Rule, usize, usize); 3] =
            [(Quadrature::gauss, 1, 1), (Quadrature::radau, 1, 2), (Quadrature::lobatto, 2, 3)];
        for (rule, least, lost) in rules {
            for n in least..=24 {
                let rule = rule(n).expect("enough nodes");
                assert!(rule.nodes.is_sorted() && rule.nodes.len() == n);
                let moment =
                    |k: usize| -> f64 { rule.nodes.iter().zip(&rule.weights).map(|(c, b)| b * c.powi(k as i32)).sum() };
                for k in 0..=2 * n - lost {
                    // A weight has the rounding of 2n recurrences, squared; c^k has k times that of c, a few ε.
                    let epsilon = 4.0 * n as f64 * EPS + 4.0 * EPS;
                    approx::assert_abs_diff_eq!(moment(k), 1.0 / (k + 1) as f64, epsilon = epsilon);
                }
                // The first error of Gauss's rule is (n!)⁴/((2n+1)((2n)!)²), about 4^{−2n}; the others' are larger.
                if n <= 8 {
                    let k = 2 * n - lost + 1;
                    let error = (moment(k) - 1.0 / (k + 1) as f64).abs();
                    assert!(error > 16f64.powi(-(n as i32)) / (4 * n) as f64, "{n} nodes are exact for degree {k}");
                }
            }
        }
    }

    #[test]
    fn interior_nodes_ascend_symmetrically_and_chebyshev_s_are_zeros_of_his_polynomial() {
        use NodeFamily::{Chebyshev, Equispaced, Gauss, Lobatto};
        for m in 2..=12 {
            for family in [Equispaced, Gauss, Lobatto, Chebyshev] {
                let nodes = family.interior(m).expect("m ≥ 2");
                assert!(nodes.is_sorted() && nodes.len() == m - 1, "{family:?}: {nodes:?}");
                for (c, opposite) in nodes.iter().zip(nodes.iter().rev()) {
                    approx::assert_abs_diff_eq!(c + opposite, 1.0, epsilon = 4.0 * EPS);
                }
            }
            let n = m - 1;
            for c in Chebyshev.interior(m).expect("m ≥ 2") {
                let x = 2.0 * c - 1.0;
                let (mut before, mut value) = (1.0, x);
                for _ in 1..n {
                    (before, value) = (value, 2.0 * x * value - before);
                }
                // A rounding in the k-th of n recurrences is multiplied by n − k at most, one of x by T′ ≤ n².
                approx::assert_abs_diff_eq!(value, 0.0, epsilon = 4.0 * (n * n) as f64 * EPS);
            }
        }
    }

    #[test]
    fn bases_reproduce_monomials_with_their_derivatives() {
        fn check(basis: &impl Basis, degree: usize, sample: impl Fn(usize, f64) -> Vec<f64>, epsilon: f64) {
            for k in 0..=degree {
                let power = |p: i32, c: f64| if p < 0 { 0.0 } else { c.powi(p) };
                for c in [0.0, 0.1, 0.5, 0.77, 1.0] {
                    let combine = |b: Vec<f64>| sample(k, c).iter().zip(b).map(|(x, b)| x * b).sum::<f64>();
                    let (k, kf) = (k as i32, k as f64);
                    approx::assert_abs_diff_eq!(combine(basis.values(c)), power(k, c), epsilon = epsilon);
                    approx::assert_abs_diff_eq!(combine(basis.first(c)), kf * power(k - 1, c), epsilon = epsilon);
                    let second = kf * (kf - 1.0) * power(k - 2, c);
                    approx::assert_abs_diff_eq!(combine(basis.second(c)), second, epsilon = epsilon);
                }
            }
        }
        for m in 2..=12 {
            let nodes = Quadrature::lobatto(m + 1).expect("two").nodes;
            let sample = |k: usize, _: f64| nodes.iter().map(|c| c.powi(k as i32)).collect();
            // Second derivatives on Lobatto nodes are as large as m⁴/3.
            let epsilon = 4.0 * (m as f64).powi(4) * EPS;
            check(&LagrangeBasis::new(&nodes).expect("distinct"), m, sample, epsilon);
            // c^k = Σ_j C(j, k)/C(m, k) b_j.
            let falling = |j: usize, k: usize| (0..k).map(|i| j.saturating_sub(i) as f64).product::<f64>();
            let sample = |k: usize, _: f64| (0..=m).map(|j| falling(j, k) / falling(m, k)).collect();
            check(&BernsteinBasis::new(m), m, sample, epsilon);
        }
    }

    #[test]
    fn bases_reproduce_their_abscissae() {
        let lagrange = LagrangeBasis::new(&[0.0, 0.3, 0.9, 1.0]).expect("distinct");
        let bernstein = BernsteinBasis::new(3);
        for basis in [&lagrange as &dyn Basis, &bernstein] {
            let x: f64 = basis.abscissae().iter().zip(basis.values(0.37)).map(|(x, b)| x * b).sum();
            approx::assert_abs_diff_eq!(x, 0.37, epsilon = 4.0 * EPS);
        }
    }

    #[test]
    fn refuses_bad_nodes() {
        assert!(matches!(Quadrature::lobatto(1), Err(InputError::Nodes(NodeError::TooFew { least: 2, found: 1, .. }))));
        assert!(matches!(Quadrature::gauss(0), Err(InputError::Nodes(NodeError::TooFew { .. }))));
        assert!(matches!(NodeFamily::Gauss.interior(1), Err(InputError::Nodes(NodeError::TooFew { .. }))));
        let basis = |nodes: &[f64]| LagrangeBasis::new(nodes).err();
        assert!(matches!(basis(&[0.0, 1.5]), Some(InputError::Nodes(NodeError::NodeRange { index: 1, .. }))));
        assert!(matches!(basis(&[0.0, f64::NAN]), Some(InputError::Nodes(NodeError::NodeRange { index: 1, .. }))));
        assert!(matches!(
            basis(&[0.5, 0.0, 0.5]),
            Some(InputError::Nodes(NodeError::CoincidentNodes { first: 0, second: 2, .. }))
        ));
    }
}
