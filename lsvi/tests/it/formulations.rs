//! The digits that each solver of a step of Method I keeps as h|λ| grows.
//!
//! The solution of (I + BᵀB) v₁ = 2 v₀ + h (A − Aᵀ) v₀ has a condition number of its own: relative perturbations of size ε of
//! the entries of A change v₁ by about κ(augmented matrix) ε at most, and solving the normal equations as they stand risks
//! κ(augmented)². What the solvers lose in fact is measured here against a solution with twice the digits.

use crate::fields::{By, Line, Walls, with_structure};
use lsvi::{OneStep, Structure, VectorField, method_i};
use nalgebra::{DMatrix, DVector};

/// hi + lo, |lo| ≤ ½ ulp(hi).
#[derive(Clone, Copy, Default)]
struct Double(f64, f64);

impl Double {
    fn add(self, x: f64) -> Self {
        let sum = self.0 + x;
        let back = sum - self.0;
        let error = (self.0 - (sum - back)) + (x - back) + self.1;
        let hi = sum + error;
        Self(hi, error - (hi - sum))
    }

    /// self + a b, the product exact.
    fn add_product(self, a: f64, b: f64) -> Self {
        let product = a * b;
        self.add(product).add(a.mul_add(b, -product))
    }
}

/// Solves M x = r, r given exactly, by refinement of LU solutions with residuals in twice the digits.
fn refined(matrix: &DMatrix<f64>, rhs: &[Double]) -> Vec<f64> {
    let n = rhs.len();
    let lu = matrix.clone().full_piv_lu();
    let mut x = vec![Double::default(); n];
    for _ in 0..60 {
        let residual = DVector::from_fn(n, |i, _| {
            let mut sum = rhs[i];
            for j in 0..n {
                sum = sum.add_product(-matrix[(i, j)], x[j].0).add_product(-matrix[(i, j)], x[j].1);
            }
            sum.0
        });
        let correction = lu.solve(&residual).expect("regular");
        let relative = correction.amax() / x.iter().fold(0.0, |m: f64, x| m.max(x.0.abs()));
        x.iter_mut().zip(correction.iter()).for_each(|(x, d)| *x = x.add(*d));
        if relative < 1e-22 {
            break;
        }
    }
    x.iter().map(|x| x.0).collect()
}

/// [[I, B], [Bᵀ, −I]] for B = I − h A as the methods see it, and B.
fn augmented(field: &impl VectorField, h: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = field.dim();
    let mut b = lsvi::Jacobian::zeros(n);
    (0..n).for_each(|i| b.add(i, i, 1.0));
    field.add_jacobian(0.0, &vec![0.0; n], -h, &mut b);
    let b = b.to_dense();
    let mut matrix = DMatrix::identity(2 * n, 2 * n);
    matrix.view_mut((0, n), (n, n)).copy_from(&b);
    matrix.view_mut((n, 0), (n, n)).copy_from(&b.transpose());
    matrix.view_mut((n, n), (n, n)).scale_mut(-1.0);
    (matrix, b)
}

/// v₁ to the last digit.
fn exact_step(matrix: &DMatrix<f64>, b: &DMatrix<f64>, v0: &[f64]) -> Vec<f64> {
    let n = v0.len();
    let mut rhs = vec![Double::default(); 2 * n];
    for i in 0..n {
        // −[2 v₀ + h (A − Aᵀ) v₀] = −2 v₀ + (B − Bᵀ) v₀
        rhs[n + i] = Double(-2.0 * v0[i], 0.0);
        for j in 0..n {
            rhs[n + i] = rhs[n + i].add_product(b[(i, j)], v0[j]).add_product(-b[(j, i)], v0[j]);
        }
    }
    refined(matrix, &rhs)[n..].to_vec()
}

fn max_norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn relative_error(v: &[f64], exact: &[f64]) -> f64 {
    v.iter().zip(exact).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / max_norm(exact)
}

/// The relative error of a step; infinite if it is refused.
fn error_of(mut method: impl OneStep, h: f64, v0: &[f64], exact: &[f64]) -> f64 {
    let (mut q, mut p) = (v0.to_vec(), vec![0.0; v0.len()]);
    method.step(0.0, h, &mut q, &mut p).map_or(f64::INFINITY, |()| relative_error(&q, exact))
}

/// Errors of one step at h|λ|.
struct Row {
    /// κ₂ of the augmented matrix.
    condition: f64,
    augmented: f64,
    twisted: f64,
    conjugate_gradients: f64,
    lsmr: f64,
    automatic: f64,
    /// What is chosen for the same field without its structure.
    dense: f64,
    /// I + BᵀB assembled and factored with pivoting.
    assembled: f64,
    /// The augmented matrix with y = −h r₁ as unknown, whose right-hand side is (v₀, −(I + h A) v₀).
    residual_unknown: f64,
}

/// The rows for h|λ| = 1, 10², …, 10¹², |λ| the largest row sum of A.
fn study(field: &Line) -> Vec<Row> {
    let n = field.dim();
    let v0: Vec<f64> = (0..n).map(|i| 1.0 + (1.3 * i as f64).sin()).collect();
    let largest =
        field.rows.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).max_by(f64::total_cmp).expect("entries");
    let row = |exponent| {
        let h = 10.0_f64.powi(exponent) / largest;
        let (matrix, b) = augmented(field, h);
        let exact = exact_step(&matrix, &b, &v0);
        let with = |by: By| error_of(by.method_i(field).expect("fits"), h, &v0, &exact);
        let spectrum = matrix.symmetric_eigenvalues().abs();
        let v = DVector::from_column_slice(&v0);
        let image = &b * &v - 2.0 * &v;
        let rhs = DVector::from_iterator(2 * n, v.iter().chain(image.iter()).copied());
        let residual = matrix.lu().solve(&rhs).expect("regular");
        let normal = DMatrix::identity(n, n) + b.tr_mul(&b);
        let assembled = normal.lu().solve(&(2.0 * &v - &b * &v + b.tr_mul(&v))).expect("regular");
        Row {
            condition: spectrum.max() / spectrum.min(),
            augmented: with(By::Augmented),
            twisted: with(By::Twisted),
            conjugate_gradients: with(By::ConjugateGradients),
            lsmr: with(By::Lsmr),
            automatic: error_of(method_i(field).expect("usable"), h, &v0, &exact),
            dense: error_of(method_i(with_structure(Structure::Dense, field)).expect("usable"), h, &v0, &exact),
            assembled: relative_error(assembled.as_slice(), &exact),
            residual_unknown: relative_error(&residual.as_slice()[n..], &exact),
        }
    };
    (0..=12).step_by(2).map(row).collect()
}

fn print(name: &str, rows: &[Row]) {
    println!("{name}\n  h|λ|   κ(aug)  augmented twisted  CG       LSMR     auto     dense    I+BᵀB    y=−hr₁");
    for (row, exponent) in rows.iter().zip((0..).step_by(2)) {
        println!(
            "  1e{exponent:02}  {:.1e}  {:.1e}  {:.1e}  {:.1e}  {:.1e}  {:.1e}  {:.1e}  {:.1e}  {:.1e}",
            row.condition,
            row.augmented,
            row.twisted,
            row.conjugate_gradients,
            row.lsmr,
            row.automatic,
            row.dense,
            row.assembled,
            row.residual_unknown
        );
    }
}

const CELLS: usize = 48;

fn dirichlet() -> Line {
    Line::new(CELLS, 0.0, Walls::Dirichlet).without_source()
}

/// Diffusion that falls by eight orders of magnitude along the line: no symmetry, and modes of every speed.
fn graded() -> Line {
    let mut line = dirichlet();
    for (i, row) in line.rows.iter_mut().enumerate() {
        row.iter_mut().for_each(|x| *x *= 10.0_f64.powf(-8.0 * i as f64 / CELLS as f64));
    }
    line
}

#[test]
fn condition_numbers_bound_the_errors_of_every_formulation() {
    let fields = [
        ("Dirichlet walls", dirichlet()),
        ("Neumann walls", Line::new(CELLS, 0.0, Walls::Neumann).without_source()),
        ("advection", Line::new(CELLS, 40.0, Walls::Dirichlet).without_source()),
        ("graded diffusion", graded()),
    ];
    for (name, field) in fields {
        let rows = study(&field);
        print(name, &rows);
        for row in rows {
            // Backward stable elimination perturbs the entries by a few ε, in a band by no more than its width.
            let bound = CELLS as f64 * f64::EPSILON * row.condition;
            assert!(row.augmented <= bound && row.conjugate_gradients <= bound, "{name}");
            // The same elimination, with zeros for what the structure leaves out.
            assert!(row.dense <= bound, "{name}");
            assert!(row.twisted <= bound * row.condition, "{name}");
            // The choice costs at most half of the digits.
            assert!(row.automatic <= bound.max(f64::EPSILON.sqrt()), "{name}");
        }
    }
}

#[test]
fn the_augmented_form_keeps_what_others_lose() {
    let uniform = study(&dirichlet());
    let last = &uniform[6];
    assert!(uniform.iter().all(|row| row.augmented < 1e-13 && row.conjugate_gradients < 1e-13));
    // Eleven digits or more in the normal equations of a uniform symmetric Laplacian, but half as many where v₁ is a
    // difference or hangs on h A v₀.
    assert!(uniform.iter().all(|row| row.twisted < 1e-11));
    assert!(last.assembled > 1e-8 && last.residual_unknown > 1e-8);
    // Spectra with slow modes: the normal equations lose every digit, the augmented form none where κ comes from the scales of
    // the rows. A null space is in the entries of B only as their difference, so that ε h|λ| is lost in any form.
    let [graded, null] = [graded(), Line::new(CELLS, 0.0, Walls::Neumann).without_source()].map(|field| study(&field));
    assert!(graded[6].twisted > 1e-3 && graded.iter().all(|row| row.augmented < 1e-13));
    assert!(null[5].twisted > 1e-2 && null[5].augmented < 1e-6);
}
