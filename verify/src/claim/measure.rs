//! What claims write.

use crate::evidence::number;

/// A number for a sentence: three significant digits, four from 1 to 2.
pub(super) fn text(x: f64) -> String {
    if x == f64::INFINITY {
        return "no solution".into();
    }
    let digits = if (1.0..2.0).contains(&x.abs()) { 4 } else { 3 };
    number::Short::new(x, digits).text()
}
