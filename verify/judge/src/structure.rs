//! Structure of a Runge–Kutta method that its coefficients show: simplifying assumptions, symplecticity, symmetry, algebraic
//! stability (\[HLW06\] IV.2, V.2; \[HW96\] IV.12).

use super::mirror::has_mirror;
use super::real::{Real, dot};
use super::tableau::Numbers;

/// The largest η up to which each of Butcher's simplifying assumptions holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simplifying {
    /// B(p): Σ b_i c_iᵏ⁻¹ = 1/k.
    pub b: u32,
    /// C(q): Σ_j a_ij c_jᵏ⁻¹ = c_iᵏ/k.
    pub c: u32,
    /// D(r): Σ_i b_i c_iᵏ⁻¹ a_ij = b_j (1 − c_jᵏ)/k.
    pub d: u32,
}

impl Simplifying {
    /// The assumptions that `numbers` satisfy.
    pub fn of(numbers: &Numbers) -> Self {
        let s = numbers.stages();
        let power = |k: u32| numbers.c.iter().map(move |c| (0..k).fold(Real::one(), |p, _| &p * c)).collect::<Vec<_>>();
        let over = |x: &Real, k: u32| x / &Real::from(i64::from(k));
        let b = |k: u32| (&dot(&numbers.b, &power(k - 1)) - &over(&Real::one(), k)).may_be_zero();
        let c = |k: u32| {
            let (low, high) = (power(k - 1), power(k));
            numbers.a.iter().zip(&high).all(|(row, c)| (&dot(row, &low) - &over(c, k)).may_be_zero())
        };
        let d = |k: u32| {
            let (low, high) = (power(k - 1), power(k));
            (0..s).all(|j| {
                let sum: Real = (0..s).map(|i| &(&numbers.b[i] * &low[i]) * &numbers.a[i][j]).sum();
                (&sum - &over(&(&numbers.b[j] * &(&Real::one() - &high[j])), k)).may_be_zero()
            })
        };
        // No method of s stages satisfies B beyond 2s, C and D beyond s.
        let largest =
            |most: usize, holds: &dyn Fn(u32) -> bool| (1..=most as u32).take_while(|k| holds(*k)).count() as u32;
        Self { b: largest(2 * s, &b), c: largest(s, &c), d: largest(s, &d) }
    }

    /// The order that follows from them (Butcher; \[HNW93\] II.7): p with B(p), p ≤ η + ζ + 1 and p ≤ 2η + 2.
    pub fn order(self) -> u32 {
        self.b.min(self.c + self.d + 1).min(2 * self.c + 2)
    }

    /// The order of the stages: both C(q) and B(q).
    pub fn stage_order(self) -> u32 {
        self.b.min(self.c)
    }
}

/// M = B A + Aᵀ B − b bᵀ.
pub fn algebraic_matrix(numbers: &Numbers) -> Vec<Vec<Real>> {
    let (a, b) = (&numbers.a, &numbers.b);
    let entry = |i: usize, j: usize| &(&(&b[i] * &a[i][j]) + &(&b[j] * &a[j][i])) - &(&b[i] * &b[j]);
    (0..b.len()).map(|i| (0..b.len()).map(|j| entry(i, j)).collect()).collect()
}

/// Largest |m_ij| of M that is certainly not zero, with its place; `None` where the method is symplectic.
pub fn symplectic_defect(numbers: &Numbers) -> Option<(usize, usize, f64)> {
    let m = algebraic_matrix(numbers);
    let entries = m.iter().enumerate().flat_map(|(i, row)| row.iter().enumerate().map(move |(j, x)| (i, j, x)));
    let certain = entries.filter(|(.., x)| !x.may_be_zero()).map(|(i, j, x)| (i, j, x.to_f64()));
    certain.max_by(|x, y| x.2.abs().total_cmp(&y.2.abs()))
}

/// Whether the method is its own adjoint, with its stages in another order σ: c_σ(i) + c_i = Σ_j b_j, b_σ(i) = b_i and
/// a_σ(i)σ(j) + a_ij = b_j.
pub fn is_symmetric(numbers: &Numbers) -> bool {
    let Numbers { a, b, c, .. } = numbers;
    let end: Real = b.iter().sum();
    let may = |i: usize, m: usize| (&(&c[m] + &c[i]) - &end).may_be_zero() && (&b[m] - &b[i]).may_be_zero();
    let fits = |[i, j]: [usize; 2], [m, n]: [usize; 2]| (&(&a[m][n] + &a[i][j]) - &b[j]).may_be_zero();
    has_mirror(numbers.stages(), &may, &fits)
}

/// Why a method is not algebraically stable.
#[derive(Debug, Clone, PartialEq)]
pub enum Indefinite {
    /// A weight b_i is negative.
    Weight(usize, f64),
    /// xᵀ M x < 0 for some x: elimination meets this pivot at stage i.
    Pivot(usize, f64),
    /// The digits given do not decide.
    Undecided,
}

/// b ≥ 0 and M ≥ 0, by elimination with the largest pivot on the diagonal.
///
/// # Errors
/// [`Indefinite`] with what is negative.
pub fn is_algebraically_stable(numbers: &Numbers) -> Result<(), Indefinite> {
    for (i, b) in numbers.b.iter().enumerate() {
        if b.is_negative() {
            return Err(Indefinite::Weight(i, b.to_f64()));
        }
    }
    let mut m = algebraic_matrix(numbers);
    let mut left: Vec<usize> = (0..m.len()).collect();
    while !left.is_empty() {
        if let Some(&i) = left.iter().find(|&&i| m[i][i].is_negative()) {
            return Err(Indefinite::Pivot(i, m[i][i].to_f64()));
        }
        let Some(&k) = left.iter().max_by(|&&i, &&j| m[i][i].to_f64().total_cmp(&m[j][j].to_f64())) else { break };
        if m[k][k].may_be_zero() {
            // With a zero diagonal, any entry beside it makes the form indefinite.
            let beside =
                left.iter().flat_map(|&i| left.iter().map(move |&j| (i, j))).find(|&(i, j)| !m[i][j].may_be_zero());
            return match beside {
                None => Ok(()),
                Some((i, j)) if m[i][i].radius() == 0.0 || m[i][i].radius() < 1e-40 => {
                    Err(Indefinite::Pivot(i, -m[i][j].to_f64().abs()))
                }
                Some(_) => Err(Indefinite::Undecided),
            };
        }
        left.retain(|&i| i != k);
        for &i in &left {
            for &j in &left {
                m[i][j] = &m[i][j] - &(&(&m[i][k] * &m[k][j]) / &m[k][k]);
            }
        }
    }
    Ok(())
}

/// The row of A that is b, if there is one: the last, but for the sequence of the stages.
pub fn stiffly_accurate(numbers: &Numbers) -> Option<usize> {
    numbers.a.iter().rposition(|row| row.iter().zip(&numbers.b).all(|(a, b)| (a - b).may_be_zero()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// M = [[δ, m], [m, δ]] with δ known to within `radius` of 0: b = (½, ½), a_ii = ¼ and a₁₂ = ¼ + 2m, a₂₁ = ¼.
    fn with_matrix(m: f64, radius: f64) -> Numbers {
        let diagonal = Real::double(0.25).widened(radius);
        let a = vec![vec![diagonal.clone(), Real::double(0.25 + 2.0 * m)], vec![Real::double(0.25), diagonal]];
        let c = super::super::tableau::row_sums(&a);
        Numbers { a, b: vec![Real::double(0.5); 2], c, b_hat: None }
    }

    /// Where D(r) holds far enough, C(q) bounds the order by 2q + 2: both bounds are met alone.
    #[test]
    fn the_order_from_simplifying_assumptions_has_three_bounds() {
        for (b, c, d, order) in [(12, 5, 7, 12), (14, 5, 9, 12), (12, 5, 3, 9), (4, 5, 7, 4)] {
            assert_eq!(Simplifying { b, c, d }.order(), order, "B({b}), C({c}), D({d})");
        }
    }

    /// x = (1, −m/|m|) gives xᵀMx = 2(δ − |m|): negative for a δ of zero, and of either sign where digits leave δ up to 10⁻⁶ open.
    #[test]
    fn an_entry_beside_a_zero_diagonal_is_indefinite_and_undecided_beside_one_that_digits_leave_open() {
        assert_eq!(is_algebraically_stable(&with_matrix(0.0, 0.0)), Ok(()));
        for m in [2_f64.powi(-27), -2_f64.powi(-27)] {
            assert_eq!(is_algebraically_stable(&with_matrix(m, 0.0)), Err(Indefinite::Pivot(0, -m.abs())));
            assert_eq!(is_algebraically_stable(&with_matrix(m, 1e-6)), Err(Indefinite::Undecided));
        }
    }

    /// M = [[1, 2], [2, 1]] has a positive diagonal and the eigenvalue −1.
    #[test]
    fn a_pivot_that_elimination_makes_negative_is_found() {
        let diagonal = Real::double(1.25);
        let a = vec![vec![diagonal.clone(), Real::double(4.25)], vec![Real::double(0.25), diagonal]];
        let c = super::super::tableau::row_sums(&a);
        let numbers = Numbers { a, b: vec![Real::double(0.5); 2], c, b_hat: None };
        assert_eq!(is_algebraically_stable(&numbers), Err(Indefinite::Pivot(0, -3.0)));
    }

    /// b = (1, 1) and A = ½(M + bbᵀ) with M = [[2, 1], [1, x]], of which elimination leaves x − ½.
    #[test]
    fn elimination_subtracts_the_square_over_the_pivot() {
        let stable = |x: f64| {
            let a: Vec<Vec<Real>> =
                [[1.5, 1.0], [1.0, 0.5 * (x + 1.0)]].map(|row| row.map(Real::double).to_vec()).to_vec();
            let c = super::super::tableau::row_sums(&a);
            is_algebraically_stable(&Numbers { a, b: vec![Real::one(); 2], c, b_hat: None }).is_ok()
        };
        assert_eq!([0.25, 0.5, 0.75].map(stable), [false, true, true]);
    }
}
