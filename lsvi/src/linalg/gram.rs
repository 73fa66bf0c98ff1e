//! Sums of matrices that are not dense with their transposes and Gram products AᵀDA, D diagonal.

use super::Jacobian;
use super::banded::Band;
use super::jacobian::Entries;

/// The rows of the matrices of one structure, whose storage is by columns.
#[derive(Debug)]
pub(crate) struct Rows(Vec<Vec<Place>>);

#[derive(Debug, Clone, Copy)]
struct Place {
    column: usize,
    /// Where the entry is among the values.
    at: usize,
}

impl Rows {
    /// Those of the structure of `a`.
    pub(crate) fn of(a: &Jacobian) -> Self {
        let mut rows = vec![Vec::new(); a.dim()];
        a.for_each_place(|i, column, at| rows[i].push(Place { column, at }));
        Self(rows)
    }

    /// Adds AᵀDA to `out`, D_ii = `weight(i)`.
    pub(crate) fn add_gram(&self, a: &Jacobian, weight: impl Fn(usize) -> f64, out: &mut Jacobian) {
        if let (Entries::Banded(a), Entries::Banded(out)) = (a.entries(), out.entries_mut())
            && out.has_room_for_gram_of(a)
        {
            return add_banded(a, weight, out);
        }
        let values = a.values();
        a.for_each(|i, b, x| {
            if x != 0.0 {
                let weighted = weight(i) * x;
                self.0[i].iter().for_each(|place| out.add(place.column, b, weighted * values[place.at]));
            }
        });
    }
}

/// Adds `scale` A + `transposed` Aᵀ to `out`, and takes over an entry outside its structure.
pub(crate) fn add_with_transpose(scale: f64, transposed: f64, a: &Jacobian, out: &mut Jacobian) {
    out.inherit_outside(a);
    if let (Entries::Banded(a), Entries::Banded(out)) = (a.entries(), out.entries_mut())
        && out.has_room_for_gram_of(a)
    {
        return add_bands(scale, transposed, a, out);
    }
    if scale != 0.0 {
        a.for_each(|i, j, x| out.add(i, j, scale * x));
    }
    if transposed != 0.0 {
        a.for_each(|i, j, x| out.add(j, i, transposed * x));
    }
}

fn add_bands(scale: f64, transposed: f64, a: &Band, out: &mut Band) {
    for j in 0..a.dim() {
        if scale != 0.0 {
            let (rows, places) = a.places(j);
            let column = out.column_from_mut(rows.start, j);
            column.iter_mut().zip(&a.values()[places]).for_each(|(o, x)| *o += scale * x);
        }
        if transposed != 0.0 {
            out.column_from_mut(a.first_column(j), j).iter_mut().zip(a.row(j)).for_each(|(o, x)| *o += transposed * x);
        }
    }
}

/// Entry (i, b) times row i goes to consecutive entries of column b.
fn add_banded(a: &Band, weight: impl Fn(usize) -> f64, out: &mut Band) {
    for b in 0..a.dim() {
        for (i, x) in a.column(b) {
            let weighted = weight(i) * x;
            out.column_from_mut(a.first_column(i), b).iter_mut().zip(a.row(i)).for_each(|(o, y)| *o += weighted * y);
        }
    }
}
