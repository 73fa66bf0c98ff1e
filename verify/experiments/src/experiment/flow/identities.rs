//! What discrete equations of a flow owe to each other, at states without pattern.

use lsvi::VectorField;

use super::setting;
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::max_norm;

/// The identities of a flow with its parameters.
#[derive(Debug)]
pub struct Identities {
    /// Name of the flow.
    pub flow: &'static str,
    /// Whether nothing but viscosity changes ½ vᵀMv, the energy in the metric of the velocity and the enstrophy in that of the vorticity.
    pub is_closed: bool,
}

/// By how much they fail, relative to what they equate.
#[derive(Debug)]
pub struct Found {
    /// How many unknowns there are.
    pub unknowns: usize,
    /// yᵀ(J x) = (Jᵀy)ᵀx.
    pub adjoint: f64,
    /// J x is the derivative of f, which is quadratic, so that central differences have no error but rounding.
    pub jacobian: f64,
    /// vᵀf = 0 without viscosity, where the flow is closed.
    pub work: Option<f64>,
}

impl Experiment for Identities {
    const ID: &'static str = "flow-identities";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let problem = setting(self.flow)?;
        let (unknowns, [adjoint, jacobian]) = (problem.field().dim(), of_products(&*problem.field()));
        let work = if self.is_closed { Some(work(self.flow)?) } else { None };
        context.tick();
        Ok(Found { unknowns, adjoint, jacobian, work })
    }
}

/// What is found of the products with J and with its transpose.
fn of_products(field: &dyn VectorField) -> [f64; 2] {
    const T: f64 = 0.3;
    let [v, x, y] = [1.7, 2.3, 3.1].map(|seed| scattered(field.dim(), seed));
    let (mut jx, mut jty) = (vec![0.0; v.len()], vec![0.0; v.len()]);
    field.apply_jacobian(T, &v, &x, &mut jx);
    field.apply_transpose(T, &v, &y, &mut jty);
    let [above, below] = [1.0, -1.0].map(|sign| {
        let at: Vec<f64> = v.iter().zip(&x).map(|(v, x)| v + sign * x).collect();
        rhs(field, T, &at)
    });
    let apart = jx.iter().zip(above.iter().zip(&below)).map(|(j, (a, b))| j - 0.5 * (a - b));
    let apart: Vec<f64> = apart.collect();
    [adjoint((&x, &jx), (&y, &jty)), max_norm(&apart) / max_norm(&jx)]
}

/// |yᵀ(J x) − (Jᵀy)ᵀx| over |y| |J x|.
fn adjoint((x, jx): (&[f64], &[f64]), (y, jty): (&[f64], &[f64])) -> f64 {
    (dot(y, jx) - dot(jty, x)).abs() / (dot(y, y) * dot(jx, jx)).sqrt()
}

/// |vᵀf| over the sum of its terms' sizes, with the smallest viscosity that there is.
fn work(flow: &str) -> Result<f64, StudyError> {
    let problem = setting(&format!("{flow} re=1e300"))?;
    let field = problem.field();
    let v = scattered(field.dim(), 1.1);
    let f = rhs(&*field, 0.0, &v);
    Ok(dot(&v, &f).abs() / v.iter().zip(&f).map(|(v, f)| (v * f).abs()).sum::<f64>())
}

fn rhs(field: &dyn VectorField, t: f64, v: &[f64]) -> Vec<f64> {
    let mut f = vec![0.0; v.len()];
    field.rhs(t, v, &mut f);
    f
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Numbers in [−1, 1] without pattern.
fn scattered(n: usize, seed: f64) -> Vec<f64> {
    (1..=n).map(|i| (seed * (i * i) as f64).sin()).collect()
}

#[cfg(test)]
mod tests {
    use lsvi::Jacobian;

    use super::*;

    #[test]
    fn a_transpose_that_is_half_of_the_right_one_is_off_by_half() {
        // J = (0 3; 0 0).
        let (x, jx, y) = ([0.0, 2.0], [6.0, 0.0], [5.0, 0.0]);
        assert_eq!(adjoint((&x, &jx), (&y, &[0.0, 15.0])), 0.0);
        assert_eq!(adjoint((&x, &jx), (&y, &[0.0, 7.5])), 0.5);
    }

    /// The rotation v̇ = (−v₂, v₁), with a transpose that is so many times J.
    struct Rotation(f64);

    impl VectorField for Rotation {
        fn dim(&self) -> usize {
            2
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv.copy_from_slice(&[-v[1], v[0]]);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], _scale: f64, _out: &mut Jacobian) {}
        fn apply_jacobian(&self, t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
            self.rhs(t, x, out);
        }
        fn apply_transpose(&self, t: f64, _v: &[f64], w: &[f64], out: &mut [f64]) {
            self.rhs(t, w, out);
            out.iter_mut().for_each(|x| *x *= self.0);
        }
    }

    /// Of one vector alone, xᵀJ x = xᵀJᵀx whatever J is.
    #[test]
    fn a_skew_part_with_the_wrong_sign_in_the_transpose_is_found() {
        let [right, wrong] = [-1.0, 1.0].map(|sign| of_products(&Rotation(sign)));
        assert!(right[0] < 8.0 * f64::EPSILON && wrong[0] > 0.1, "{right:?} and {wrong:?}");
        assert!(right[1] < 8.0 * f64::EPSILON, "{right:?}");
    }
}
