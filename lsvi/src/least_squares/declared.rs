//! Whether a field is what it declares to be: linear, independent of time.

use super::System;
use crate::discrete::Interval;
use crate::error::SolveError;
use crate::linalg::{Jacobian, Structure, is_zero, larger, max_norm};
use crate::vector_field::VectorField;

/// Largest difference between f and A v + g, relative to their terms, that passes for rounding.
const LINEAR: f64 = 1e-10;
/// The same where all components are as large as the largest: a term that is not linear in a small one is far larger there, and the roundings
/// that an ill-conditioned M⁻¹ leaves are not.
const LINEAR_IN_LARGE: f64 = 1e-6;
/// Roundings of the largest terms that f and A v + g had so far: terms of f that cancel may be as large still when the solution has decayed.
const ROUNDINGS: f64 = 64.0;
/// Steps between two comparisons of the whole declaration, at most.
const RARELY: u32 = 256;

/// The golden ratio, whose multiples have fractions that no simple pattern of rows cancels.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// What a field declares, compared with its values at both ends of a step: in the first step of a size, after 2, 4, 8, … more,
/// and then after every 256. Steps that evaluate f anyway have A v + g compared at the end of each.
#[derive(Debug)]
pub(super) struct Declared {
    is_linear: bool,
    is_autonomous: bool,
    /// The start of the first step, where a field that is autonomous has the value that it has ever since.
    since: Option<f64>,
    /// The step size that was checked.
    checked: Option<f64>,
    /// Steps until it is checked again, and how many there were the last time.
    left: u32,
    interval: u32,
    /// A, unless the field is matrix-free.
    a: Option<Jacobian>,
    /// Weights w of the rows, and Aᵀw.
    weights: Vec<f64>,
    sums: Vec<f64>,
    zero: Vec<f64>,
    /// Where f is compared.
    point: Vec<f64>,
    product: Vec<f64>,
    size: Vec<f64>,
    value: Vec<f64>,
    before: Vec<f64>,
    /// The largest component of a v at which f was linear, and the largest term there.
    largest: [f64; 2],
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
            since: None,
            checked: None,
            left: 0,
            interval: 1,
            a: is_assembled.then(|| Jacobian::with_structure(n, structure)),
            weights: (0..n).map(|i| 0.5 + (GOLDEN * i as f64).fract()).collect(),
            sums: zeros.clone(),
            zero: zeros.clone(),
            point: zeros.clone(),
            product: zeros.clone(),
            size: zeros.clone(),
            value: zeros.clone(),
            before: zeros,
            largest: [0.0; 2],
        })
    }

    /// Whether the whole declaration is to be checked in a step of this size.
    pub(super) fn is_due(&mut self, h: f64) -> bool {
        if self.checked != Some(h) {
            self.interval = 1;
            return true;
        }
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// Refuses a field that is not what it declares, as far as its values at v₀ show at both ends of the step; at v = 1 where
    /// v₀ = 0.
    pub(super) fn check(&mut self, system: &System<'_>, at: Interval, v0: &[f64]) -> Result<(), SolveError> {
        let is_new = self.checked != Some(at.h);
        self.checked = self.checked.filter(|_| !is_new);
        self.point.copy_from_slice(v0);
        if is_zero(v0) {
            self.point.fill(1.0);
        }
        if self.is_linear {
            // A stays that of the first step of a size, whose factors later ones use.
            if let Some(a) = self.a.as_mut().filter(|_| is_new) {
                a.clear();
                system.field.add_jacobian(at.start, &self.zero, 1.0, a);
                a.check_structure()?;
                self.sums.fill(0.0);
                a.mul_transpose_add(1.0, &self.weights, &mut self.sums);
            }
            for t in [at.start, at.start + at.h] {
                self.check_linear(system, at.start, t)?;
            }
        }
        if self.is_autonomous {
            self.check_autonomous(system, at)?;
        }
        self.checked = Some(at.h);
        self.interval = (2 * self.interval).min(RARELY);
        self.left = self.interval;
        Ok(())
    }

    /// Refuses a field that at the end of a step, (t₁, v₁), is not A v + g with the A of its factors; `hg` is h g(t₁).
    pub(super) fn check_end(
        &mut self,
        system: &System<'_>,
        at: Interval,
        v: &[f64],
        hg: &[f64],
    ) -> Result<(), SolveError> {
        let Self { value, weights, sums, zero, product, largest: [largest, largest_term], .. } = self;
        system.field.rhs(at.start + at.h, v, value);
        let rows = value.iter().zip(hg);
        if self.a.is_some() {
            // wᵀf = (Aᵀw)ᵀv + wᵀg costs no product with A. It differs where a component does, but for chance and for components
            // far smaller than others, which the comparison of all of them finds.
            let (mut difference, mut size) = (0.0, 0.0);
            for (((f, hg), w), (sum, v)) in rows.zip(&*weights).zip(sums.iter().zip(v)) {
                (*largest, *largest_term) = (larger(*largest, *v), larger(*largest_term, *f));
                let terms = [w * f, -w * (hg / at.h), -sum * v];
                difference += terms.iter().sum::<f64>();
                size += terms.iter().map(|x| x.abs()).sum::<f64>();
            }
            if difference.abs() <= LINEAR * size {
                return Ok(());
            }
        } else {
            system.field.apply_jacobian(at.start, zero, v, product);
            let agrees = |((f, hg), product): ((&f64, &f64), &f64)| {
                (f - product - hg / at.h).abs() <= LINEAR * (f.abs() + (hg / at.h).abs())
            };
            if rows.zip(&*product).all(agrees) {
                return Ok(());
            }
        }
        // Sums that cancel agree to less than their own size tells.
        if self.value.iter().any(|f| !f.is_finite()) {
            return Err(SolveError::NonFinite);
        }
        self.point.copy_from_slice(v);
        self.check_linear(system, at.start, at.start + at.h)
    }

    /// Compares f at time t and the point with A v + g. Where M⁻¹ is part of f, roundings of its sums are those of terms that are larger than f and A v + g, and
    /// cancel: a difference that is small beside the largest component is one of these if f is linear at points whose components are all as large. So are roundings of
    /// terms that cancel in f itself, as large as any that it had before.
    fn check_linear(&mut self, system: &System<'_>, start: f64, t: f64) -> Result<(), SolveError> {
        let found = self.difference(system, (start, t), LINEAR);
        let (size, term) = (max_norm(&self.point), max_norm(&self.size));
        let [size, largest] = [size.max(self.largest[0]), term.max(self.largest[1])];
        let Some(error) = found else {
            self.largest = [size, largest];
            return Ok(());
        };
        let off = self.value.iter().zip(&self.product).map(|(f, product)| (f - product).abs()).fold(0.0, larger);
        if off > LINEAR * term && off > ROUNDINGS * f64::EPSILON * largest {
            return Err(error);
        }
        self.before.copy_from_slice(&self.point);
        let is_linear = [size, -size].into_iter().all(|size| {
            self.point.iter_mut().zip(&self.weights).for_each(|(x, w)| *x = size * w);
            self.difference(system, (start, t), LINEAR_IN_LARGE).is_none()
        });
        self.point.copy_from_slice(&self.before);
        if is_linear { Ok(()) } else { Err(error) }
    }

    /// The first component of f at time t and the point that is not A v + g, where a field without a matrix has its A at the start of the step.
    fn difference(&mut self, system: &System<'_>, (start, t): (f64, f64), within: f64) -> Option<SolveError> {
        let Self { a, zero, point, product, size, value, .. } = self;
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
                system.field.apply_jacobian(start, zero, point, product);
                size.fill(max_norm(product));
            }
        }
        system.field.rhs(t, zero, value);
        for ((product, size), g) in product.iter_mut().zip(size.iter_mut()).zip(&*value) {
            *product += g;
            *size += g.abs();
        }
        system.field.rhs(t, point, value);
        // Rounding of sums that cancel, with room for an f that is evaluated in another order; what is not a number tells nothing.
        let is_off = |((f, product), size): ((&f64, &f64), &f64)| (f - product).abs() > within * (size + f.abs());
        let row = value.iter().zip(&*product).zip(&*size).position(is_off)?;
        Some(SolveError::NotLinear { row, difference: value[row] - product[row] })
    }

    fn check_autonomous(&mut self, system: &System<'_>, at: Interval) -> Result<(), SolveError> {
        let Self { zero, point, value, before, is_linear, since, .. } = self;
        // What a linear f adds to every step is its value at zero.
        let v = if *is_linear { zero } else { point };
        system.field.rhs(*since.get_or_insert(at.start), v, before);
        for t in [at.start, at.start + at.h] {
            system.field.rhs(t, v, value);
            for (row, (before, value)) in before.iter().zip(&*value).enumerate() {
                if (value - before).abs() > 0.0 {
                    return Err(SolveError::NotAutonomous { row, difference: value - before });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mass::{Mass, MassInverse};

    /// v̇ = −v before t = 2, and from then on −2v.
    struct Switched;

    impl VectorField for Switched {
        fn dim(&self) -> usize {
            1
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = if t < 2.0 { -v[0] } else { -2.0 * v[0] };
        }
        fn add_jacobian(&self, t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 0, if t < 2.0 { -scale } else { -2.0 * scale });
        }
    }

    #[test]
    fn a_linear_field_is_looked_at_at_both_ends_of_a_step() {
        let mass_inverse = MassInverse::new(&Mass::Identity).expect("regular");
        let system =
            System { field: &Switched as &dyn VectorField, mass: &Mass::Identity, mass_inverse: &mass_inverse };
        let is_linear = |start: f64, h: f64| {
            let mut declared = Declared::of(&Switched, &Structure::Dense).expect("declares to be linear");
            declared.check(&system, Interval { start, h }, &[1.0]).is_ok()
        };
        assert_eq!([1.75, 1.875, 2.0].map(|start| is_linear(start, 0.125)), [true, false, true]);
    }
}
