use nalgebra::Complex;

use super::*;

/// Entries in [−1, 1] from a linear congruential generator, with a dominant diagonal every other row only.
fn fill(a: &mut Jacobian, structure: &Structure) {
    let mut seed = 12345_u64;
    let n = a.dim();
    for j in 0..n {
        for i in structure.rows(n, j) {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let x = (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
            a.add(i, j, if i == j && i % 2 == 0 { x + 4.0 } else { x });
        }
    }
}

fn structures(n: usize) -> [Structure; 5] {
    let band = |lower, upper| Structure::Banded { lower, upper };
    // Unknowns that all meet each other, and share some with the next: the pattern is symmetric, and columns are alike.
    let (step, size) = if n < 9 { (2, 4) } else { (6, 8) };
    let members = |first: usize| first..n.min(first + size);
    let cliques = (0..n).step_by(step).flat_map(|c| members(c).flat_map(move |i| members(c).map(move |j| (i, j))));
    let grid = (0..n).flat_map(|i| [(i, (i + 7) % n), (i, (i + 1) % n), ((i + 3) % n, i)]);
    let [cliques, grid] = [Structure::sparse(n, cliques), Structure::sparse(n, grid)].map(|s| s.expect("inside"));
    [Structure::Dense, band(1, 1), band(2, 4), cliques, grid]
}

/// A x = b and Aᵀ x = b have residuals within the backward error of elimination with growth at most 2^(bandwidth),
/// in practice a few n ε ‖A‖ ‖x‖.
#[test]
fn solves_in_every_structure() {
    for n in [1, 2, 3, 7, 9, 40] {
        for structure in structures(n) {
            let mut a = Jacobian::with_structure(n, &structure);
            fill(&mut a, &structure);
            let mut lu = Lu::of(&a);
            lu.factor(&a).expect("regular");
            let b: Vec<f64> = (0..n).map(|i| (i as f64 + 1.0).sin()).collect();
            for transposed in [false, true] {
                let (mut x, mut residual) = (b.clone(), b.clone());
                if transposed {
                    lu.solve_transpose(&mut x);
                    a.mul_transpose_add(-1.0, &x, &mut residual);
                } else {
                    lu.solve(&mut x);
                    a.mul_add(-1.0, &x, &mut residual);
                }
                let size = 5.0 * n as f64 * max_norm(&x);
                let bound = 16.0 * n as f64 * f64::EPSILON * size;
                assert!(max_norm(&residual) <= bound, "n = {n}, {structure:?}: {:e}", max_norm(&residual));
            }
        }
    }
}

/// What is kept of one sparse matrix is right for the next, whether its pivots serve, do not from some column on, or are none.
#[test]
fn factors_of_one_matrix_after_another_are_those_of_each() {
    let n = 40;
    let [_, _, _, cliques, grid] = structures(n);
    let taken_over = [cliques, grid].map(|structure| factor_one_after_another(n, &structure));
    assert!(taken_over.contains(&true), "pivots are taken over: {taken_over:?}");
}

/// Whether other pivots were taken over than a matrix would have by itself.
fn factor_one_after_another(n: usize, structure: &Structure) -> bool {
    let (mut a, mut first) = (Jacobian::with_structure(n, structure), Jacobian::with_structure(n, structure));
    let mut lu = Lu::<f64>::of(&a);
    fill(&mut first, structure);
    // By how much the entries of a row differ from those of the first matrix, and in which order they are added.
    let others: [&dyn Fn(usize) -> f64; 7] =
        [&|_| 1.0, &|_| 1e-9, &|_| 2.0, &|i| 1.0 + 1e-3 * i as f64, &|i| (5 * i) as f64, &|_| 0.0, &|_| 1.0];
    let (mut kept, mut taken_over) = (0, false);
    for (k, factor) in others.into_iter().enumerate() {
        let mut entries = Vec::new();
        first.for_each(|i, j, x| entries.push((i, j, if i == j { factor(i) * x } else { x })));
        if k == 5 {
            entries.iter_mut().filter(|entry| entry.1 == n / 2).for_each(|entry| entry.2 = 0.0);
        }
        if k % 2 == 1 {
            entries.reverse();
        }
        a.clear();
        entries.iter().for_each(|&(i, j, x)| a.add(i, j, x));
        assert!(entries.iter().all(|&(i, j, x)| a.get(i, j) == x), "matrix {k}");
        let (found, fresh) = (lu.factor(&a), a.factor_entries());
        assert_eq!(found.map_err(SolveError::from), fresh.clone().map(drop), "matrix {k}");
        let Ok(fresh) = fresh else { continue };
        assert!([kept, fresh].contains(&lu.entries()), "matrix {k}");
        kept = lu.entries();
        // Only pivots of another matrix have another fill.
        taken_over |= kept != fresh;
        let (mut x, mut residual) = (vec![1.0; n], vec![1.0; n]);
        lu.solve(&mut x);
        a.mul_add(-1.0, &x, &mut residual);
        let bound = 16.0 * n as f64 * f64::EPSILON * 200.0 * n as f64 * max_norm(&x);
        assert!(max_norm(&residual) <= bound, "matrix {k}: {:e}", max_norm(&residual));
    }
    assert_eq!(a, first);
    taken_over
}

/// Spokes whose own entry is a fifth of what they share with the point of an arrow are eliminated by it; a hundredth is too little.
#[test]
fn pivots_are_on_the_diagonal_while_they_are_steady() {
    let n = 200;
    let arrow: Vec<_> = (1..n).flat_map(|i| [(0, i), (i, 0)]).collect();
    let structure = Structure::sparse(n, arrow.iter().copied()).expect("inside");
    for (own, fill) in [(0.2, 0), (0.01, 1)] {
        let mut a = Jacobian::with_structure(n, &structure);
        // The point is not in proportion to what is left of the spokes.
        (0..n).for_each(|i| a.add(i, i, if i == 0 { 3.0 } else { own }));
        arrow.iter().for_each(|&(i, j)| a.add(i, j, 1.0));
        let more = a.factor_entries().expect("regular") - (3 * n - 2);
        assert_eq!(more.min(1), fill, "{own}: {more}");
        let mut lu = Lu::of(&a);
        lu.factor(&a).expect("regular");
        let (mut x, mut residual) = (vec![1.0; n], vec![1.0; n]);
        lu.solve(&mut x);
        a.mul_add(-1.0, &x, &mut residual);
        assert!(max_norm(&residual) <= 1e-10 * max_norm(&x), "{own}: {:e}", max_norm(&residual));
    }
}

/// Rings, whose fill is the same in every order, and tridiagonal matrices, where exchanges of rows may bring a second diagonal
/// above.
#[test]
fn counts_the_entries_of_the_factors_of_matrices_whose_fill_is_known() {
    for n in [4, 9, 200] {
        let ring: Vec<_> = (0..n).flat_map(|i| [(i, (i + 1) % n), ((i + 1) % n, i)]).collect();
        assert_eq!(sparse(n, &ring).factor_entries(), Ok(3 * n + 2 * (n - 3)), "ring of {n}");
        assert_eq!(dominated(n, &Structure::Dense, &ring).factor_entries(), Ok(n * n));
        let line: Vec<_> = (1..n).flat_map(|i| [(i - 1, i), (i, i - 1)]).collect();
        let band = Structure::Banded { lower: 1, upper: 1 };
        assert_eq!(dominated(n, &band, &line).factor_entries(), Ok(3 * n - 2 + (n - 2)));
    }
}

/// There is no fill where the point of an arrow is eliminated last, and nothing else where it is first.
#[test]
fn the_columns_of_a_sparse_matrix_are_ordered_for_little_fill() {
    let n = 200;
    let arrow: Vec<_> = (1..n).flat_map(|i| [(0, i), (i, 0)]).collect();
    assert_eq!(sparse(n, &arrow).factor_entries(), Ok(3 * n - 2));
}

/// The matrix with −1 at `entries` and a diagonal that is larger than the sum of each row.
fn dominated(n: usize, structure: &Structure, entries: &[(usize, usize)]) -> Jacobian {
    let mut a = Jacobian::with_structure(n, structure);
    (0..n).for_each(|i| a.add(i, i, 2.0 * n as f64));
    entries.iter().for_each(|(i, j)| a.add(*i, *j, -1.0));
    a
}

fn sparse(n: usize, entries: &[(usize, usize)]) -> Jacobian {
    dominated(n, &Structure::sparse(n, entries.iter().copied()).expect("inside"), entries)
}

#[test]
fn a_matrix_without_factors_has_no_entries_of_them() {
    assert_eq!(Jacobian::zeros(3).factor_entries(), Err(SolveError::Singular));
    let structure = Structure::sparse(3, []).expect("inside");
    let mut outside = Jacobian::with_structure(3, &structure);
    outside.add(0, 2, 1.0);
    assert_eq!(outside.factor_entries(), Err(SolveError::OutsideStructure { row: 0, column: 2 }));
    assert_eq!(Jacobian::with_structure(3, &Structure::MatrixFree).factor_entries(), Err(SolveError::NotAssembled));
}

/// (A − iσ) x = b in complex numbers, its real and imaginary part multiplied out; bounds as for real ones.
#[test]
fn solves_shifted_complex_systems_in_every_structure() {
    for n in [1, 2, 3, 7, 9, 40] {
        for structure in structures(n) {
            let mut a = Jacobian::with_structure(n, &structure);
            fill(&mut a, &structure);
            let mut lu = Lu::of(&a);
            lu.assign(&a, Complex::from).expect("inside");
            (0..n).for_each(|i| lu.add(i, i, Complex::new(0.0, -3.0)));
            lu.decompose().expect("regular");
            let b: Vec<Complex<f64>> = (0..n).map(|i| Complex::new((i as f64 + 1.0).sin(), (i as f64).cos())).collect();
            let mut x = b.clone();
            lu.solve(&mut x);
            let (re, im): (Vec<f64>, Vec<f64>) = x.iter().map(|x| (x.re, x.im)).unzip();
            let (mut real, mut imaginary): (Vec<f64>, Vec<f64>) = b.iter().map(|b| (b.re, b.im)).unzip();
            a.mul_add(-1.0, &re, &mut real);
            a.mul_add(-1.0, &im, &mut imaginary);
            let residuals = (0..n).map(|i| (real[i] - 3.0 * im[i]).abs().max((imaginary[i] + 3.0 * re[i]).abs()));
            let size = (5.0 * n as f64 + 3.0) * max_norm(&re).max(max_norm(&im));
            let bound = 16.0 * n as f64 * f64::EPSILON * size;
            residuals.for_each(|r| assert!(r <= bound, "n = {n}, {structure:?}: {r:e}"));
        }
    }
}

/// Rows and unknowns in units of their own, where rows have to be exchanged: nothing is lost.
#[test]
fn solves_with_rows_and_unknowns_in_any_units() {
    let tridiagonal = Structure::Banded { lower: 1, upper: 1 };
    for base in
        [[[1.0, 2.0, 0.0], [4.0, 1.0, 3.0], [0.0, 5.0, 1.0]], [[0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]]
    {
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            for (of_row, of_column) in
                [(1e30, 1e-30), (1e-30, 1e-30), (1e30, 1e-18), (1.0, 1e-30), (1e170, 1.0), (1e-170, 1.0)]
            {
                let unit = |i: usize, j: usize| {
                    (if i == row { of_row } else { 1.0 }) * (if j == column { of_column } else { 1.0 })
                };
                let entries =
                    || (0..3).flat_map(|i: usize| (0..3).map(move |j| (i, j))).filter(|(i, j)| i.abs_diff(*j) < 2);
                let mut a = Jacobian::with_structure(3, &tridiagonal);
                entries().for_each(|(i, j)| a.add(i, j, base[i][j] * unit(i, j)));
                let mut b = [0.0; 3];
                entries().for_each(|(i, j)| b[i] += base[i][j] * (j + 1) as f64 * unit(i, 3));
                let mut lu = Lu::of(&a);
                lu.factor(&a)
                    .unwrap_or_else(|error| panic!("{base:?}, {row} {of_row:e}, {column} {of_column:e}: {error:?}"));
                lu.solve(&mut b);
                for (j, x) in b.iter().enumerate() {
                    approx::assert_relative_eq!(x * unit(3, j), (j + 1) as f64, max_relative = 1e-13);
                }
            }
        }
    }
}

/// Beyond the squares of doubles: a complex pivot is divided by in the units of its row.
#[test]
fn solves_shifted_systems_in_any_units() {
    for unit in [1e-300, 1e-170, 1e170, 1e300] {
        for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }] {
            let mut a = Jacobian::with_structure(2, &structure);
            [(0, 0, 2.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 3.0)]
                .into_iter()
                .for_each(|(i, j, x)| a.add(i, j, unit * x));
            let mut lu = Lu::of(&a);
            lu.assign(&a, Complex::from).expect("inside");
            lu.shift(2, Complex::new(0.0, unit));
            lu.decompose().expect("regular");
            // x = (1, i).
            let mut b = [Complex::new(2.0, 2.0) * unit, Complex::new(0.0, 3.0) * unit];
            lu.solve(&mut b);
            let apart = [b[0] - 1.0, b[1] - Complex::new(0.0, 1.0)];
            assert!(apart.iter().all(|x| x.re.abs() + x.im.abs() <= 1e-14), "{unit:e}, {structure:?}: {b:?}");
        }
    }
}

/// Entries that are added to a matrix that was assigned are its own, and those outside its structure are none.
#[test]
fn entries_are_added_where_the_structure_has_them() {
    for structure in structures(5) {
        let (mut a, mut sum) = (Jacobian::with_structure(5, &structure), Jacobian::with_structure(5, &structure));
        fill(&mut a, &structure);
        a.for_each(|i, j, x| sum.add(i, j, x));
        let mut lu = Lu::of(&a);
        lu.assign(&a, f64::from).expect("inside");
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            let x = 0.25 * (i as f64 - 2.0 * j as f64 + 0.5);
            lu.add(i, j, x);
            if i < 5 && structure.rows(5, j.min(4)).any(|row| row == i && j < 5) {
                sum.add(i, j, x);
            }
        }
        lu.decompose().expect("regular");
        let (mut x, mut expected) = ([1.0; 5], [1.0; 5]);
        lu.solve(&mut x);
        let mut fresh = Lu::of(&sum);
        fresh.factor(&sum).expect("regular");
        fresh.solve(&mut expected);
        // The order of the pivots is the same.
        x.iter().zip(expected).for_each(|(x, e)| approx::assert_relative_eq!(*x, e, max_relative = 1e-12));
    }
}

/// With two diagonals below and one above, U reaches three above: 9 entries, 5 pivots and 7 multipliers.
#[test]
fn the_entries_of_the_factors_of_a_band_are_counted() {
    let structure = Structure::Banded { lower: 2, upper: 1 };
    let mut a = Jacobian::with_structure(5, &structure);
    fill(&mut a, &structure);
    assert_eq!(a.factor_entries(), Ok(9 + 5 + 7));
}

/// Two matrices at a time are factored and solved with as each by itself is, and neither is overlooked where it is singular.
#[test]
fn two_matrices_side_by_side_are_treated_as_each_by_itself() {
    for (n, structure) in [2, 3, 9, 40].into_iter().flat_map(|n| structures(n).map(|structure| (n, structure))) {
        let mut a = Jacobian::with_structure(n, &structure);
        fill(&mut a, &structure);
        // Without its last row it has no last pivot.
        let mut without = Jacobian::with_structure(n, &structure);
        a.for_each(|i, j, x| without.add(i, j, if i + 1 == n { 0.0 } else { x }));
        let assigned = |singular: [bool; 2]| {
            let (mut real, mut complex) = (Lu::<f64>::of(&a), Lu::<Complex<f64>>::of(&a));
            let [one, two] = singular.map(|is_singular| if is_singular { &without } else { &a });
            real.assign(one, |x| x).expect("inside");
            complex.assign(two, |x| Complex::new(0.0, x)).expect("inside");
            (real, complex)
        };
        let (mut real, mut complex) = assigned([false; 2]);
        real.decompose_both(&mut complex).expect("regular");
        let b: Vec<f64> = (0..n).map(|i| (i as f64 + 1.0).sin()).collect();
        let c: Vec<Complex<f64>> = b.iter().map(|b| Complex::new(b.cos(), *b)).collect();
        let (mut x, mut y) = (b.clone(), c.clone());
        real.solve_both(&mut x, &mut complex, &mut y);
        let (mut real, mut complex) = assigned([false; 2]);
        real.decompose().and_then(|()| complex.decompose()).expect("regular");
        let (mut alone, mut complex_alone) = (b, c);
        real.solve(&mut alone);
        complex.solve(&mut complex_alone);
        assert_eq!((x, y), (alone, complex_alone), "n = {n}, {structure:?}");
        for singular in [[true, false], [false, true]] {
            let (mut real, mut complex) = assigned(singular);
            assert_eq!(real.decompose_both(&mut complex), Err(FactorError::Singular), "n = {n}, {structure:?}");
        }
    }
}

/// The sign of the determinant by nalgebra, for the matrix and for two of its rows exchanged.
#[test]
fn knows_the_sign_of_the_determinant() {
    for n in [1, 2, 3, 7, 9, 40] {
        for structure in structures(n) {
            let mut a = Jacobian::with_structure(n, &structure);
            fill(&mut a, &structure);
            let mut lu = Lu::of(&a);
            lu.factor(&a).expect("regular");
            let sign = a.to_dense().determinant().signum();
            assert_eq!(lu.sign(), sign, "n = {n}, {structure:?}");
            let mut negated = Jacobian::with_structure(n, &structure);
            a.for_each(|i, j, x| negated.add(i, j, if i == 0 { -x } else { x }));
            lu.factor(&negated).expect("regular");
            assert_eq!(lu.sign(), -sign, "n = {n}, {structure:?}");
        }
    }
}

/// With a small diagonal rows are exchanged, two of them or all three in turn; with a large one none.
#[test]
fn knows_the_sign_of_the_determinant_whichever_rows_were_exchanged_before() {
    let structure = Structure::sparse(3, (0..3).flat_map(|i| (0..3).map(move |j| (i, j)))).expect("inside");
    let mut lu = Lu::<f64>::of(&Jacobian::with_structure(3, &structure));
    let places = [[0, 1, 2], [1, 0, 2], [1, 2, 0], [0, 2, 1], [2, 0, 1], [2, 1, 0]];
    for of in (0..6).flat_map(|k| (0..6).flat_map(move |l| [k, l])) {
        let mut a = Jacobian::with_structure(3, &structure);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            a.add(i, j, if places[of][i] == j { 1.0 } else { 1e-3 * (i + 2 * j) as f64 });
        }
        lu.factor(&a).expect("regular");
        assert_eq!(lu.sign(), a.to_dense().determinant().signum(), "{:?}", places[of]);
    }
}

#[test]
fn solves_badly_scaled_rows() {
    for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }] {
        let mut a = Jacobian::with_structure(3, &structure);
        for (i, row) in [[2e-30, 1e-30, 0.0], [1.0, -3.0, 4.0], [0.0, 5e20, 1e20]].iter().enumerate() {
            row.iter().enumerate().for_each(|(j, &x)| a.add(i, j, x));
        }
        let mut lu = Lu::of(&a);
        lu.factor(&a).expect("regular");
        let mut b = [4e-30, 7.0, 13e20];
        lu.solve(&mut b);
        for (x, exact) in b.iter().zip([1.0, 2.0, 3.0]) {
            approx::assert_relative_eq!(*x, exact, max_relative = 1e-14);
        }
    }
}

/// The first unknown has small units: no row has an entry of its size, and no pivot is lost.
#[test]
fn solves_with_unknowns_in_any_units() {
    for structure in structures(3) {
        for unit in [1e-18, 1e-30] {
            let mut a = Jacobian::with_structure(3, &structure);
            for (i, row) in [[2.0 * unit, 3.0, 0.0], [unit, -1.0, 4.0], [0.0, 2.0, 1.0]].iter().enumerate() {
                row.iter().enumerate().filter(|(_, x)| **x != 0.0).for_each(|(j, &x)| a.add(i, j, x));
            }
            if a.outside().is_some() {
                continue;
            }
            let mut lu = Lu::of(&a);
            lu.factor(&a).expect("regular");
            // x = (1/unit, 2, 3), and the transposed system for (1, 2, 3).
            let (mut b, mut transposed) = ([8.0, 11.0, 7.0], [4.0 * unit, 7.0, 11.0]);
            lu.solve(&mut b);
            lu.solve_transpose(&mut transposed);
            for (x, exact) in b.iter().chain(&transposed).zip([1.0 / unit, 2.0, 3.0, 1.0, 2.0, 3.0]) {
                approx::assert_relative_eq!(*x, exact, max_relative = 1e-14);
            }
        }
    }
}

#[test]
fn refuses_singular_matrices() {
    for (n, entries) in
        [(1, vec![0.0]), (2, vec![0.1, 0.3, 0.2, 0.6]), (3, vec![1.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0])]
    {
        for structure in structures(n) {
            let mut a = Jacobian::with_structure(n, &structure);
            (0..n * n).for_each(|k| a.add(k / n, k % n, entries[k]));
            if a.outside().is_none() {
                assert_eq!(Lu::<f64>::of(&a).factor(&a), Err(FactorError::Singular), "{structure:?}");
            }
        }
    }
}

#[test]
fn refuses_matrices_that_are_not_finite() {
    for bad in [f64::NAN, f64::INFINITY] {
        for structure in structures(3) {
            for j in 0..3 {
                let mut a = Jacobian::with_structure(3, &structure);
                (0..3).for_each(|i| a.add(i, i, 1.0));
                a.add(0, j, bad);
                if a.outside().is_none() {
                    let expected = Err(FactorError::NonFinite { row: 0, column: j });
                    assert_eq!(Lu::<f64>::of(&a).factor(&a), expected, "{structure:?}");
                }
            }
        }
    }
}

#[test]
fn refuses_entries_outside_the_structure() {
    for structure in [Structure::Banded { lower: 0, upper: 1 }, Structure::sparse(3, [(0, 2)]).expect("inside")] {
        let mut a = Jacobian::with_structure(3, &structure);
        (0..3).for_each(|i| a.add(i, i, 1.0));
        a.add(2, 0, 0.0);
        assert_eq!(Lu::<f64>::of(&a).factor(&a), Ok(()));
        a.add(2, 0, 1.0);
        assert_eq!(Lu::<f64>::of(&a).factor(&a), Err(FactorError::OutsideStructure { row: 2, column: 0 }));
        a.clear();
        a.add(0, 3, 1.0);
        a.add(2, 0, 1.0);
        assert_eq!(Lu::<f64>::of(&a).factor(&a), Err(FactorError::OutsideStructure { row: 0, column: 3 }));
    }
    assert!(Structure::sparse(3, [(1, 3)]).is_err());
}

/// ‖A⁻¹‖₁ of the second difference matrix of order n, h⁻² (−1, 2, −1) with h = 1/(n+1), is max_j ½ x_j (1 − x_j).
#[test]
fn estimates_the_norm_of_an_inverse() {
    let n = 99;
    let structure = Structure::Banded { lower: 1, upper: 1 };
    let mut a = Jacobian::with_structure(n, &structure);
    for i in 0..n {
        a.add(i, i, 2e4);
        if i > 0 {
            a.add(i, i - 1, -1e4);
            a.add(i - 1, i, -1e4);
        }
    }
    let mut lu = Lu::of(&a);
    lu.factor(&a).expect("regular");
    let estimate = inverse_norm(|b| lu.solve(b), &mut [vec![0.0; n], vec![0.0; n]]);
    // The inverse is non-negative, for which the estimate is exact; condition number 1e4/ (π²/4).
    approx::assert_relative_eq!(estimate, 0.125, max_relative = 1e-11);
}

#[test]
fn the_norm_of_a_vector_with_a_nan_is_nan_wherever_it_is() {
    for vector in [[f64::NAN, 1.0, 2.0], [1.0, f64::NAN, 2.0], [1.0, 2.0, f64::NAN]] {
        assert!(max_norm(&vector).is_nan(), "{vector:?}");
    }
    assert!(max_norm(&[-3.0, 2.0]) == 3.0 && max_norm(&[]) == 0.0);
}

/// Of A⁻¹ = 1 + θ w wᵀ, w = (1, −1, 0, 0), the iteration sees 1: its start and the column it looks at are orthogonal to w.
#[test]
fn estimates_the_norm_of_an_inverse_whose_large_part_cancels() {
    let theta = f64::from(1 << 20);
    let solve = |b: &mut [f64]| {
        let large = theta * (b[0] - b[1]);
        (b[0], b[1]) = (b[0] + large, b[1] - large);
    };
    let (estimate, exact) = (inverse_norm(solve, &mut [vec![0.0; 4], vec![0.0; 4]]), 1.0 + 2.0 * theta);
    assert!(estimate <= exact && 3.0 * estimate >= exact, "{estimate} for {exact}");
}

#[test]
fn entries_beyond_the_last_row_or_column_are_outside() {
    let n = 4;
    for structure in structures(n) {
        for (i, j) in [(n, n - 1), (n - 1, n), (n, n), (n + 1, n - 1)] {
            let mut a = Jacobian::with_structure(n, &structure);
            fill(&mut a, &structure);
            let before = a.clone();
            assert_eq!(a.get(i, j), 0.0);
            a.add(i, j, 1.0);
            assert_eq!(a.outside(), Some((i, j)), "{structure:?}");
            (0..n).for_each(|j| (0..n).for_each(|i| assert_eq!(a.get(i, j), before.get(i, j), "({i}, {j})")));
        }
    }
}

#[test]
fn a_pattern_of_another_order_is_cut_to_the_matrix_and_one_of_its_own_is_shared() {
    let pattern = Structure::sparse(3, [(2, 0), (0, 1)]).expect("inside");
    let (whole, part) = (Jacobian::with_structure(3, &pattern), Jacobian::with_structure(2, &pattern));
    assert_eq!((whole.structure(), part.dim()), (pattern, 2));
    let mut part = part;
    part.add(0, 1, 2.0);
    assert_eq!((part.get(0, 1), part.outside()), (2.0, None));
}

#[test]
fn pivots_of_complex_matrices_are_told_by_both_parts() {
    assert_eq!(Complex::new(3.0, -4.0).magnitude(), 7.0);
    assert_eq!(Complex::new(0.0, 2.0).magnitude(), 2.0);
}

#[test]
fn a_metric_may_be_asymmetric_by_the_rounding_of_its_entries() {
    for size in [1e-6, 1.0, 1e6] {
        let metric = |off: f64| {
            let mut a = Jacobian::zeros(2);
            [(0, 0, 2.0), (1, 1, 2.0), (0, 1, 1.0), (1, 0, off)].iter().for_each(|&(i, j, x)| a.add(i, j, x * size));
            a.cholesky()
        };
        assert!(metric(1.0 + 4.0 * f64::EPSILON).is_ok(), "{size}");
        assert!(metric(1.0 + 64.0 * f64::EPSILON).is_err(), "{size}");
    }
}

#[test]
fn a_pattern_has_no_entries_beyond_its_own_columns() {
    let pattern = Structure::sparse(3, [(2, 0), (0, 1)]).expect("inside");
    assert_eq!(pattern.rows(5, 0).collect::<Vec<_>>(), [0, 2]);
    assert_eq!(pattern.rows(5, 3).count() + pattern.rows(5, 4).count(), 0);
    let mut larger = Jacobian::with_structure(5, &pattern);
    larger.add(4, 4, 2.0);
    assert_eq!((larger.get(4, 4), larger.outside()), (2.0, None));
}

/// The sums by rows and columns are those of dense matrices, and what was there before stays, in bands that are just wide enough, wider,
/// or too narrow, where the entries that have no place are told.
#[test]
fn sums_with_transposes_and_gram_products_are_those_of_dense_matrices() {
    let weight = |i: usize| 0.5 + i as f64;
    for n in [1, 2, 5, 9] {
        let band = |lower, upper| Structure::Banded { lower, upper };
        let own = structures(n).into_iter().chain([band(0, 0), band(0, 2), band(3, 0)]);
        for structure in own.filter(|structure| *structure != Structure::Dense) {
            let mut a = Jacobian::with_structure(n, &structure);
            fill(&mut a, &structure);
            let rows = Rows::of(&a);
            let dense = a.to_dense();
            let d = DMatrix::from_fn(n, n, |i, j| if i == j { weight(i) } else { 0.0 });
            let (sum, gram) = (&dense * 2.0 - dense.transpose() * 3.0, dense.tr_mul(&(d * &dense)));
            for room in [structure.gram(n), band(n, n), Structure::Dense, band(0, 0)] {
                let mut start = Jacobian::with_structure(n, &room);
                fill(&mut start, &room);
                type Addition<'a> = &'a dyn Fn(&mut Jacobian);
                let added: [(&DMatrix<f64>, Addition<'_>); 2] = [
                    (&sum, &|out| add_with_transpose(2.0, -3.0, &a, out)),
                    (&gram, &|out| rows.add_gram(&a, weight, out)),
                ];
                for (expected, add) in added {
                    let mut out = start.clone();
                    add(&mut out);
                    let difference = out.to_dense() - start.to_dense();
                    let is_told = out.outside().is_some();
                    let mut is_missing = false;
                    for j in 0..n {
                        for i in 0..n {
                            let has_place = room.rows(n, j).any(|row| row == i);
                            is_missing |= !has_place && expected[(i, j)] != 0.0;
                            // Entries below 10, and sums of a few tens of products with weights up to 9.
                            let error = difference[(i, j)] - if has_place { expected[(i, j)] } else { 0.0 };
                            assert!(error.abs() <= 1e-12, "{structure:?} to {room:?}, ({i}, {j}): {error:e}");
                        }
                    }
                    assert_eq!(is_told, is_missing, "{structure:?} to {room:?}");
                }
            }
        }
    }
}

/// A product of dense matrices is added to any storage, as far as it has room.
#[test]
fn products_of_dense_matrices_are_added_to_every_structure() {
    let n = 5;
    let matrix = |shift: f64| DMatrix::from_fn(n, n, |i, j| (shift + (i * n + j) as f64).sin());
    let (a, b) = (matrix(0.0), matrix(0.5));
    let expected = a.transpose() * &b * 2.0;
    for structure in structures(n) {
        let mut out = Jacobian::with_structure(n, &structure);
        out.add_product_tr(2.0, &a, &b);
        out.for_each(|i, j, x| approx::assert_relative_eq!(x, expected[(i, j)], epsilon = 1e-14));
        assert_eq!(out.outside().is_some(), structure != Structure::Dense);
    }
}

/// Of the same pattern or of another, and beyond it.
#[test]
fn what_is_added_of_a_matrix_is_added_entry_by_entry() {
    for structure in structures(9) {
        for room in structures(9).into_iter().chain([structure.clone()]) {
            let (mut a, mut b) = (Jacobian::with_structure(9, &room), Jacobian::with_structure(9, &structure));
            fill(&mut a, &room);
            fill(&mut b, &structure);
            let mut expected = a.clone();
            b.for_each(|i, j, x| expected.add(i, j, 3.0 * x));
            a.add_scaled(3.0, &b);
            assert!(a == expected, "{structure:?} to {room:?}");
        }
    }
}

#[test]
fn a_sum_of_matrices_knows_what_its_terms_lack() {
    let structure = Structure::Banded { lower: 1, upper: 1 };
    let matrix = |x: f64| {
        let mut a = Jacobian::with_structure(4, &structure);
        a.add(1, 2, x);
        a
    };
    let mut terms = [matrix(1.0), matrix(10.0)];
    let mut sum = matrix(5.0);
    sum.set_sum([2.0, 3.0], &terms);
    assert_eq!((sum.get(1, 2), sum.get(0, 0), sum.outside()), (32.0, 0.0, None));
    terms[1].add(0, 3, 1.0);
    sum.set_sum([2.0, 3.0], &terms);
    assert_eq!(sum.outside(), Some((0, 3)));
}

#[test]
fn matrices_are_equal_with_the_same_structure_and_the_same_entries() {
    for structure in structures(9) {
        let (mut one, mut same, mut other) = {
            let zeros = Jacobian::with_structure(9, &structure);
            (zeros.clone(), zeros.clone(), zeros)
        };
        [&mut one, &mut same, &mut other].into_iter().for_each(|a| fill(a, &structure));
        assert!(one == same);
        other.add(4, 4, 1.0);
        assert!(one != other, "{structure:?}");
        // In another order, as an assembly may be.
        let mut turned = Jacobian::with_structure(9, &structure);
        let mut entries = Vec::new();
        one.for_each(|i, j, x| entries.push((i, j, x)));
        entries.into_iter().rev().for_each(|(i, j, x)| turned.add(i, j, x));
        assert!(one == turned, "{structure:?}");
    }
    let [dense, tridiagonal, band, _, sparse] = structures(9).map(|structure| Jacobian::with_structure(9, &structure));
    assert!(dense != tridiagonal && tridiagonal != band && band != sparse && sparse != dense);
    let another = Structure::sparse(9, [(0, 0), (8, 3)]).expect("inside");
    assert!(sparse != Jacobian::with_structure(9, &another), "of another pattern");
}

#[test]
fn a_matrix_has_the_structure_that_it_was_made_with() {
    for structure in structures(9).into_iter().chain([Structure::MatrixFree]) {
        assert_eq!(Jacobian::with_structure(9, &structure).structure(), structure);
    }
}

#[test]
fn zero_is_either_zero_and_nothing_else() {
    assert!(is_zero(&[]) && is_zero(&[0.0, -0.0]));
    for x in [f64::MIN_POSITIVE * f64::EPSILON, -1.0, f64::INFINITY, f64::NAN, -f64::NAN] {
        assert!(!is_zero(&[0.0, x, -0.0]), "{x}");
    }
}
