//! What variational integrators do to the harmonic oscillator: their recurrences in closed form.

/// The recurrence x_{k+1} = R(τ) x_k − x_{k−1} of a method on ẍ = −x with steps of τ.
#[derive(Debug, Clone, Copy)]
pub struct Recurrence {
    /// The method.
    pub method: &'static str,
    /// Where it is printed, `[KY21] (16)`, or what it is.
    pub source: &'static str,
    of_square: fn(f64) -> f64,
}

impl Recurrence {
    /// R(τ), the trace of the map (x, p) of one step.
    pub fn trace(&self, tau: f64) -> f64 {
        (self.of_square)(tau * tau)
    }

    /// That of a method, where it is known.
    pub fn of(method: &str) -> Option<&'static Self> {
        RECURRENCES.iter().find(|known| known.method == method)
    }

    /// The number of its equation in \[KY21\], `(16)`.
    pub fn equation(&self) -> &'static str {
        self.source.strip_prefix("[KY21] ").unwrap_or(self.source)
    }
}

/// Those of \[KY21\], as printed.
pub const PRINTED: &[Recurrence] = RECURRENCES.split_at(4).0;

/// All that are known in closed form, with R as a function of τ².
pub const RECURRENCES: &[Recurrence] = &[
    known("path-fitted(2)", "[KY21] (16)", |s| (16.0 - 6.0 * s) / (8.0 + s)),
    known("midpoint-vi", "[KY21] (17)", |s| (8.0 - 2.0 * s) / (4.0 + s)),
    known("path-fitted(3)", "[KY21] (18)", |s| ((22.0 * s - 468.0) * s + 972.0) / ((2.0 * s + 9.0) * s + 486.0)),
    known("path-fitted(4)", "[KY21] (19)", |s| {
        (((-150.0 * s + 9616.0) * s - 142_848.0) * s + 294_912.0) / (((9.0 * s - 184.0) * s + 2304.0) * s + 147_456.0)
    }),
    known("path-fitted(3,gauss)", "Gauss, m = 3", |s| ((14.0 * s - 384.0) * s + 864.0) / ((s + 24.0) * s + 432.0)),
    known("path-fitted(4,gauss)", "Gauss, m = 4", |s| {
        (((-26.0 * s + 2736.0) * s - 53_280.0) * s + 115_200.0) / (((s + 48.0) * s + 2160.0) * s + 57_600.0)
    }),
    known("stormer-verlet", "2 − τ²", |s| 2.0 - s),
];

const fn known(method: &'static str, source: &'static str, of_square: fn(f64) -> f64) -> Recurrence {
    Recurrence { method, source, of_square }
}
