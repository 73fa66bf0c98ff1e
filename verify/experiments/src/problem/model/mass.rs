//! The mass matrix of a model M u̇ = F(t, u), which its equations are solved for.

use diffsl::discretise::DiscreteModel;
use diffsl::{Compiler, CraneliftJitModule};
use nalgebra::{DMatrix, DVectorViewMut, Dyn, LU};

use super::affine::{Kind, kind_of};

/// Largest system with an M that is not diagonal, whose inverse fills ∂(M⁻¹F)/∂u.
const LARGEST: usize = 512;

/// M⁻¹.
pub(super) enum Inverse {
    /// Of M = I, or of a model without M.
    Identity,
    /// By the diagonal of M.
    Diagonal(Vec<f64>),
    /// By its factors.
    Factors(LU<f64, Dyn, Dyn>),
}

impl Inverse {
    /// That of the M of a model; an M that is singular, or not constant, or no matrix, is refused with the reason.
    pub(super) fn of(
        model: &mut DiscreteModel,
        compiler: &Compiler<CraneliftJitModule, f64>,
        inputs: &[f64],
    ) -> Result<Self, String> {
        let Some(lhs) = model.lhs() else { return Ok(Self::Identity) };
        let rates = model.state_dot().ok_or("without dudt, the components of which dudt_i { … } names")?;
        // Where M depends on t its product with dudt is not affine in dudt; on u, DiffSL refuses it.
        if kind_of(model, lhs, rates, Kind::Other) > Kind::Affine {
            return Err("of which M depends on t, or that is not linear in dudt; solve for the derivatives".into());
        }
        let n = model.state().nnz();
        let mut data = compiler.get_new_data();
        compiler.set_inputs(inputs, &mut data, 0);
        compiler.set_u0(&mut vec![0.0; n], &mut data);
        let mut product = |x: &[f64]| {
            let mut product = vec![0.0; n];
            compiler.mass(0.0, x, &mut data, &mut product);
            product
        };
        let of_rest = product(&vec![0.0; n]);
        if let Some(row) = of_rest.iter().position(|x| !x.is_finite()) {
            return Err(infinite(row));
        }
        if of_rest.iter().any(|x| *x != 0.0) {
            return Err("with a part that has no dudt, which F has to have".into());
        }
        if n > LARGEST {
            return if model.take_mass_state_deps().iter().all(|(i, j)| i == j) {
                Self::of_diagonal(product(&vec![1.0; n]))
            } else {
                Err(format!(
                    "of which M is not diagonal, which is for {LARGEST} unknowns at most; solve for the derivatives"
                ))
            };
        }
        let mut m = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            m.set_column(j, &product(&unit).into());
        }
        if (0..n).all(|j| (0..n).all(|i| i == j || m[(i, j)] == 0.0)) {
            return Self::of_diagonal(m.diagonal().as_slice().to_vec());
        }
        Self::of_matrix(m)
    }

    fn of_diagonal(m: Vec<f64>) -> Result<Self, String> {
        check_rows(&m)?;
        Ok(if m.iter().all(|m| *m == 1.0) { Self::Identity } else { Self::Diagonal(m) })
    }

    fn of_matrix(m: DMatrix<f64>) -> Result<Self, String> {
        // What is not a number passes a maximum.
        let sizes: Vec<f64> = m.row_iter().map(|row| row.iter().map(|m| m.abs()).sum()).collect();
        check_rows(&sizes)?;
        // Of rows of the size 1 a pivot as small as their roundings is what is left of a row that others add up to.
        let n = m.nrows();
        let scaled = DMatrix::from_fn(n, n, |i, j| m[(i, j)] / sizes[i]);
        let pivots = scaled.lu().u().diagonal();
        if pivots.iter().any(|pivot| pivot.abs() <= n as f64 * f64::EPSILON) {
            return Err("of which M is singular: its rows depend on each other, so that some equations are algebraic; solve those for as many \
                        components, and leave these out of the state"
                .into());
        }
        Ok(Self::Factors(m.lu()))
    }

    /// Whether M⁻¹ leaves entries of F where they are.
    pub(super) fn is_diagonal(&self) -> bool {
        !matches!(self, Self::Factors(_))
    }

    /// Overwrites b with M⁻¹ b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        match self {
            Self::Identity => {}
            Self::Diagonal(m) => b.iter_mut().zip(m).for_each(|(b, m)| *b /= m),
            Self::Factors(lu) => {
                let n = b.len();
                let is_regular = lu.solve_mut(&mut DVectorViewMut::from_slice(b, n));
                debug_assert!(is_regular, "no pivot is zero");
            }
        }
    }
}

/// Refuses a row of the size 0, and one that is not finite.
fn check_rows(sizes: &[f64]) -> Result<(), String> {
    match sizes.iter().position(|size| *size == 0.0 || !size.is_finite()) {
        Some(row) if sizes[row] == 0.0 => Err(format!(
            "of which row {} has no dudt, so that its equation is algebraic; solve it for a component, and leave that out of the state",
            row + 1
        )),
        Some(row) => Err(infinite(row)),
        None => Ok(()),
    }
}

fn infinite(row: usize) -> String {
    format!("of which row {} is not finite", row + 1)
}

#[cfg(test)]
mod tests {
    use lsvi::{Jacobian, VectorField};

    use crate::problem::Problem;
    use crate::problem::model::Model;

    fn load(text: &str) -> Result<Model, String> {
        Model::of_text(text, &[], None).map_err(|error| error.to_string())
    }

    /// f, ∂f/∂v, and whether f is linear, at t = 0.3 and a state.
    fn seen(text: &str, v: &[f64]) -> (Vec<f64>, Vec<f64>, bool) {
        let model = load(text).expect("a model");
        let field = model.field();
        let mut f = vec![0.0; v.len()];
        field.rhs(0.3, v, &mut f);
        let mut jacobian = Jacobian::with_structure(v.len(), &field.structure());
        field.add_jacobian(0.3, v, 1.0, &mut jacobian);
        (f, jacobian.to_dense().as_slice().to_vec(), field.is_linear())
    }

    const STATE: &str = "in_i { m = 4 } u_i { x = 1, y = 2 } dudt_i { dxdt = 0, dydt = 0 }";

    #[test]
    fn a_model_with_a_mass_matrix_is_that_solved_for_its_rates() {
        let v = [0.7, -0.4];
        for (mass, f, solved) in [
            ("m * dxdt, dydt / 2", "-x * y + t, x", "(-x * y + t) / m, 2 * x"),
            // The inverse of [[2, 1], [1, 1]] is [[1, −1], [−1, 2]].
            ("2 * dxdt + dydt, dxdt + dydt", "-x * y, x - y + t", "-x * y - (x - y + t), x * y + 2 * (x - y + t)"),
            // Not symmetric: the inverse of [[1, 1], [0, 1]] is [[1, −1], [0, 1]].
            ("dxdt + dydt, dydt", "3 * x, -y + t", "3 * x - (-y + t), -y + t"),
            // Rows in another order.
            ("dydt, dxdt", "3 * x, -y", "-y, 3 * x"),
            ("dxdt, dydt", "-x, -y", "-x, -y"),
        ] {
            let with = seen(&format!("{STATE} M_i {{ {mass} }} F_i {{ {f} }}"), &v);
            let without = seen(&format!("in_i {{ m = 4 }} u_i {{ x = 1, y = 2 }} F_i {{ {solved} }}"), &v);
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 4.0 * f64::EPSILON);
            assert!(near(&with.0, &without.0) && near(&with.1, &without.1), "{mass}: {with:?} {without:?}");
            assert_eq!(with.2, without.2, "{mass}");
        }
    }

    #[test]
    fn a_mass_matrix_may_be_stated_as_a_tensor() {
        let text = "a_ij { (0, 0): 2, (0, 1): 1, (1, 0): 1, (1, 1): 1 }
            u_i { x = 1, y = 2 } dudt_i { dxdt = 0, dydt = 0 } M_i { a_ij * dudt_j } F_i { x, y }";
        let f = seen(text, &[0.7, -0.4]).0;
        assert!((f[0] - 1.1).abs() < 1e-15 && (f[1] + 1.5).abs() < 1e-15, "{f:?}");
    }

    /// Its pivots are 3·10⁵ and 2·10⁻²⁰.
    #[test]
    fn rows_of_a_mass_matrix_have_units_of_their_own() {
        let mass = "1e-20 * dxdt + 2e-20 * dydt, 3e5 * dxdt + 1e5 * dydt";
        let f = seen(&format!("{STATE} M_i {{ {mass} }} F_i {{ 1e-20 * x, 1e5 * y }}"), &[5.0, 10.0]).0;
        // ẋ + 2ẏ = 5 and 3ẋ + ẏ = 10.
        assert!((f[0] - 3.0).abs() < 1e-14 && (f[1] - 1.0).abs() < 1e-14, "{f:?}");
    }

    #[test]
    fn a_mass_without_rates_is_refused() {
        let error = load("u_i { x = 1 } M_i { 2 } F_i { -x }").err();
        assert!(error.as_ref().is_some_and(|error| error.contains("a product without dudt")), "{error:?}");
    }

    #[test]
    fn what_is_no_constant_regular_matrix_is_refused_with_the_reason() {
        for (mass, reason) in [
            ("dxdt, 0 * dydt", "row 2 has no dudt"),
            ("dxdt + dydt, 0 * dxdt", "row 2 has no dudt"),
            ("dxdt, 2 * dxdt", "M is singular"),
            ("dxdt + dydt, dxdt + dydt", "M is singular"),
            ("dxdt + 3 * dydt, dxdt / 3 + dydt", "M is singular"),
            ("dxdt, t * dydt", "M depends on t,"),
            ("dxdt, x * dydt", "M must not be dependent on u"),
            ("dxdt, dydt * dydt", "not linear in dudt"),
            ("dxdt, dydt + 1", "a part that has no dudt"),
            ("dxdt, dydt / (m - 4)", "row 2 is not finite"),
        ] {
            let error = load(&format!("{STATE} M_i {{ {mass} }} F_i {{ x, y }}")).err();
            assert!(error.as_ref().is_some_and(|error| error.contains(reason)), "{mass}: {error:?}");
        }
        let misplaced =
            load("u_i { x = 1, y = 2 } dudt_i { dydt = 0, dxdt = 0 } M_i { 2 * dxdt, dydt } F_i { x, y }").err();
        assert!(misplaced.as_ref().is_some_and(|error| error.contains("`dydt` is at the place of x")), "{misplaced:?}");
    }

    /// A diagonal one leaves a large system sparse, and others are for small systems.
    #[test]
    fn a_large_diagonal_mass_matrix_keeps_the_band() {
        let text = |mass: &str| {
            format!(
                "a_ij {{ (0..600, 0..600): -2, (0..599, 1..600): 1 }} u_i {{ (0:600): y = 1 }} dudt_i {{ (0:600): dy = 0 }}
                 M_i {{ {mass} }} F_i {{ a_ij * u_j }}"
            )
        };
        let model = load(&text("2 * dudt_i")).expect("a model");
        assert_eq!(model.field().structure(), lsvi::Structure::Banded { lower: 0, upper: 1 });
        let error = load(&text("a_ij * dudt_j")).err();
        assert!(error.as_ref().is_some_and(|error| error.contains("M is not diagonal")), "{error:?}");
    }
}
