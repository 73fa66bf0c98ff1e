//! Whether a field is what it declares to be: linear, independent of time.

use super::System;
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure, max_norm};
use crate::vector_field::VectorField;

/// Largest difference between f and A v + g, relative to their terms, that passes for rounding.
const LINEAR: f64 = 1e-10;

/// What a field declares, compared once per step size with its values at both ends of a step.
#[derive(Debug)]
pub(super) struct Declared {
    is_linear: bool,
    is_autonomous: bool,
    /// The step size that was checked.
    checked: Option<f64>,
    /// A, unless the field is matrix-free.
    a: Option<Jacobian>,
    zero: Vec<f64>,
    /// Where f is compared.
    point: Vec<f64>,
    product: Vec<f64>,
    size: Vec<f64>,
    value: Vec<f64>,
    before: Vec<f64>,
}

impl Declared {
    /// Nothing for a field that declares nothing.
    pub(super) fn of(field: &dyn VectorField, structure: &Structure) -> Option<Self> {
        let (is_linear, is_autonomous, n) = (field.is_linear(), field.is_autonomous(), field.dim());
        let zeros = vec![0.0; n];
        let is_assembled = is_linear && *structure != Structure::MatrixFree;
        (is_linear || is_autonomous).then(|| Self {
            is_linear,
            is_autonomous,
            checked: None,
            a: is_assembled.then(|| Jacobian::with_structure(n, structure)),
            zero: zeros.clone(),
            point: zeros.clone(),
            product: zeros.clone(),
            size: zeros.clone(),
            value: zeros.clone(),
            before: zeros,
        })
    }

    /// Refuses a field that is not what it declares, as far as its values at v₀ show at both ends of the step; at v = 1 where
    /// v₀ = 0.
    pub(super) fn check(&mut self, system: &System<'_>, at: Interval, v0: &[f64]) -> Result<(), SolveError> {
        if self.checked == Some(at.h) {
            return Ok(());
        }
        self.point.copy_from_slice(v0);
        if v0.iter().all(|v| *v == 0.0) {
            self.point.fill(1.0);
        }
        if self.is_linear {
            self.check_linear(system, at)?;
        }
        if self.is_autonomous {
            self.check_autonomous(system, at)?;
        }
        self.checked = Some(at.h);
        Ok(())
    }

    fn check_linear(&mut self, system: &System<'_>, at: Interval) -> Result<(), SolveError> {
        let Self { a, zero, point, product, size, value, .. } = self;
        if let Some(a) = a {
            a.clear();
            system.field.add_jacobian(at.start, zero, 1.0, a);
            a.check_structure()?;
        }
        for t in [at.start, at.start + at.h] {
            match a {
                Some(a) => {
                    product.fill(0.0);
                    size.fill(0.0);
                    a.for_each(|i, j, a| {
                        product[i] += a * point[j];
                        size[i] += (a * point[j]).abs();
                    });
                }
                None => {
                    system.field.apply_jacobian(at.start, zero, point, product);
                    size.fill(max_norm(product));
                }
            }
            system.field.rhs(t, zero, value);
            for ((product, size), g) in product.iter_mut().zip(size.iter_mut()).zip(&*value) {
                *product += g;
                *size += g.abs();
            }
            system.field.rhs(t, point, value);
            for (row, ((f, product), size)) in value.iter().zip(&*product).zip(&*size).enumerate() {
                // Rounding of sums that cancel, with room for an f that is evaluated in another order.
                if (f - product).abs() > LINEAR * (size + f.abs()) {
                    return Err(SolveError::NotLinear { row, difference: f - product });
                }
            }
        }
        Ok(())
    }

    fn check_autonomous(&mut self, system: &System<'_>, at: Interval) -> Result<(), SolveError> {
        let Self { zero, point, value, before, is_linear, .. } = self;
        // What a linear f adds to every step is its value at zero.
        let v = if *is_linear { zero } else { point };
        system.field.rhs(at.start, v, before);
        system.field.rhs(at.start + at.h, v, value);
        for (row, (start, end)) in before.iter().zip(&*value).enumerate() {
            if (end - start).abs() > 0.0 {
                return Err(SolveError::NotAutonomous { row, difference: end - start });
            }
        }
        Ok(())
    }
}
