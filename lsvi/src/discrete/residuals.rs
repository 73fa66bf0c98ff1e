//! Least squares on polynomial paths by way of the weighted residuals, on as many nodes as the degree: there all of them vanish, and the branch is that
//! of collocation. On more nodes z stays, and what tells one branch from another was seen to let a leap pass.
//!
//! For L = ½ rᵀWr, r = M v̇ − f, the conditions of a path are JᵀWJ and the like, which squares the condition number of J, and where r is large
//! beside h their curvature Σ (Wr)_i ∂²f_i hides the minimum. With z_i = h W r_i at the nodes as unknowns,
//!
//! Σ_i b_i [ψ_j′(c_i) M z_i − h ψ_j(c_i) J_iᵀz_i] = 0,  W (M Σ_k φ_k′(c_i) (x_k − q₀) − h f_i) − z_i = 0,
//!
//! no J is squared, and the curvature is that of z, which starts from 0 (the augmented system of least squares; Björck,
//! Numerical Methods for Least Squares Problems, 1996, 2.5).

use nalgebra::DMatrix;

use super::galerkin::test_function;
use super::path::Path;
use super::{Interval, MomentumWeights};
use crate::lagrangian::ResidualForm;
use crate::linalg::{Jacobian, add_block};
use crate::newton::are_unlike;

/// Work space.
#[derive(Debug)]
pub(super) struct Residuals {
    q: Vec<f64>,
    rate: Vec<f64>,
    r: Vec<f64>,
    weighted: Vec<f64>,
    /// M z and Jᵀz.
    mass: Vec<f64>,
    transposed: Vec<f64>,
    jacobian: Jacobian,
    mass_matrix: Jacobian,
    curvature: Jacobian,
    /// The block of a row and a column.
    block: DMatrix<f64>,
}

impl Residuals {
    pub(super) fn new(n: usize) -> Self {
        let zeros = vec![0.0; n];
        Self {
            q: zeros.clone(),
            rate: zeros.clone(),
            r: zeros.clone(),
            weighted: zeros.clone(),
            mass: zeros.clone(),
            transposed: zeros,
            jacobian: Jacobian::zeros(n),
            mass_matrix: Jacobian::zeros(n),
            curvature: Jacobian::zeros(n),
            block: DMatrix::zeros(n, n),
        }
    }

    pub(super) fn has_unlike_units(&mut self, form: ResidualForm<'_>, at: Interval, q0: &[f64]) -> bool {
        self.jacobian.clear();
        form.field.add_jacobian(at.start, q0, 1.0, &mut self.jacobian);
        are_unlike(&self.jacobian)
    }

    pub(super) fn equations(
        &mut self,
        form: ResidualForm<'_>,
        (path, weights): (&Path, &[f64]),
        at: Interval,
        (q0, xz): (&[f64], &[f64]),
        w: MomentumWeights,
        out: &mut [f64],
    ) {
        let (n, degree) = (q0.len(), path.degree());
        let (x, z) = xz.split_at(degree * n);
        let (conditions, definitions) = out.split_at_mut(degree * n);
        conditions.fill(0.0);
        let nodes = path.points.iter().zip(weights).zip(z.chunks_exact(n).zip(definitions.chunks_exact_mut(n)));
        for ((point, b), (z, definition)) in nodes {
            point.place(at.h, q0, x, &mut self.q, &mut self.rate);
            form.field.rhs(point.time(at), &self.q, &mut self.r);
            self.r.iter_mut().for_each(|r| *r *= -at.h);
            form.mass.mul_add(at.h, &self.rate, &mut self.r);
            form.weigh(&self.r, definition);
            definition.iter_mut().zip(z).for_each(|(d, z)| *d -= z);
            self.jacobian.clear();
            form.field.add_jacobian(point.time(at), &self.q, 1.0, &mut self.jacobian);
            form.mass.multiply(z, &mut self.mass);
            self.transposed.fill(0.0);
            self.jacobian.mul_transpose_add(at.h, z, &mut self.transposed);
            for (row, condition) in conditions.chunks_exact_mut(n).enumerate() {
                let (value, slope) = test_function(point, row + 1, w);
                for ((o, mass), transposed) in condition.iter_mut().zip(&self.mass).zip(&self.transposed) {
                    *o += b * (slope * mass - value * transposed);
                }
            }
        }
    }

    pub(super) fn add_derivative(
        &mut self,
        form: ResidualForm<'_>,
        (path, weights): (&Path, &[f64]),
        at: Interval,
        (q0, xz): (&[f64], &[f64]),
        w: MomentumWeights,
        out: &mut Jacobian,
    ) {
        let (n, degree) = (q0.len(), path.degree());
        let (x, z) = xz.split_at(degree * n);
        self.mass_matrix.clear();
        form.mass.add_to(1.0, &mut self.mass_matrix);
        for (node, ((point, b), z)) in path.points.iter().zip(weights).zip(z.chunks_exact(n)).enumerate() {
            point.place(at.h, q0, x, &mut self.q, &mut self.rate);
            let (t, own) = (point.time(at), (degree + node) * n);
            self.jacobian.clear();
            form.field.add_jacobian(t, &self.q, 1.0, &mut self.jacobian);
            out.inherit_outside(&self.jacobian);
            self.curvature.clear();
            form.field.add_curvature(t, &self.q, z, 1.0, &mut self.curvature);
            for row in 1..=degree {
                let (value, slope) = test_function(point, row, w);
                let place = (row - 1) * n;
                add_block(out, (place, own), b * slope, &self.mass_matrix);
                self.jacobian.for_each(|i, j, x| out.add(place + j, own + i, -b * at.h * value * x));
                for column in 1..=degree {
                    let curved = -b * at.h * value * point.value[column];
                    add_block(out, (place, (column - 1) * n), curved, &self.curvature);
                }
            }
            for column in 1..=degree {
                let (value, slope) = (at.h * point.value[column], point.first[column]);
                for j in 0..n {
                    for (i, r) in self.r.iter_mut().enumerate() {
                        *r = slope * self.mass_matrix.get(i, j) - value * self.jacobian.get(i, j);
                    }
                    form.weigh(&self.r, &mut self.weighted);
                    self.block.column_mut(j).copy_from_slice(&self.weighted);
                }
                add_block(out, (own, (column - 1) * n), 1.0, &self.block);
            }
            (0..n).for_each(|i| out.add(own + i, own + i, -1.0));
        }
    }
}
