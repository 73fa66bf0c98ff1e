//! How a series looks: one colour and one shape a method, the same in every figure of the report.

use crate::evidence::{COLORS, Mark};

const DASHES: [&str; 4] = ["", "8 4", "2 3", "8 3 2 3"];

/// The names that have a look of their own, the methods first: their places decide it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Palette<'a>(pub(super) &'a [String]);

/// The legend's entry for the [`Mark::Other`] series.
pub(super) fn others(count: usize) -> String {
    format!("others ({count})")
}

/// Shapes of markers; `H` is a dot or a square by its line cap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Dot,
    Square,
    Up,
    Diamond,
    Down,
    Cross,
    Plus,
}

/// Colour, dash and marker: `--s0` to `--s7` of the page, then that of guides and that of the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Style {
    pub(super) color: usize,
    pub(super) dash: usize,
    pub(super) shape: Shape,
}

impl Shape {
    const ALL: [Self; 7] = [Self::Dot, Self::Square, Self::Up, Self::Diamond, Self::Down, Self::Cross, Self::Plus];

    /// The class of its path: dots and squares are points of a thick line, the others are outlines.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Dot => "dot",
            Self::Square => "square",
            Self::Cross | Self::Plus => "cross",
            Self::Up | Self::Diamond | Self::Down => "shape",
        }
    }

    /// The path around the current point.
    pub(super) fn path(self) -> &'static str {
        match self {
            Self::Dot | Self::Square => "h0",
            Self::Up => "m0-5l4 8h-8z",
            Self::Diamond => "m0-5l4 5-4 5-4-5z",
            Self::Down => "m0 5l4-8h-8z",
            Self::Cross => "m-3-3l6 6m0-6l-6 6",
            Self::Plus => "m-4 0h8m-4-4v8",
        }
    }
}

impl Palette<'_> {
    /// The look of `label` wherever it stands; one that begins with no known name gets that of its `place` in the figure.
    pub(super) fn style(self, label: &str, place: usize, mark: Mark) -> Style {
        let head = label.split(['(', ' ', ',']).next().unwrap_or_default();
        // A method by its whole name, with its arguments; one with other arguments shifts the shape and dash of its plain name.
        let whole = self.0.iter().position(|name| name == label.split(' ').next().unwrap_or_default());
        let known = self.0.iter().position(|name| name == head);
        let rest: usize = label[head.len()..].bytes().map(usize::from).sum();
        let (place, shift) = match (whole, known) {
            (Some(position), _) => (position, 0),
            (None, Some(position)) => (position, rest),
            (None, None) => (place, 0),
        };
        if mark == Mark::Other {
            return Style { color: COLORS + 1, dash: 0, shape: Shape::Dot };
        }
        if mark == Mark::Guide {
            return Style { color: COLORS, dash: 1 + place % (DASHES.len() - 1), shape: Shape::Dot };
        }
        let dash = match mark {
            // Markers tell these apart already.
            Mark::LineMarkers | Mark::Markers => place / COLORS,
            _ => place / COLORS + shift,
        };
        Style {
            color: place % COLORS,
            dash: dash % DASHES.len(),
            shape: Shape::ALL[(place + place / COLORS + shift) % Shape::ALL.len()],
        }
    }
}

impl Style {
    /// The style and, in the same colour, those that serve where another label of the figure has it.
    pub(super) fn variants(self) -> impl Iterator<Item = Self> {
        let shape = Shape::ALL.iter().position(|shape| *shape == self.shape).unwrap_or(0);
        (0..DASHES.len()).map(move |k| Self {
            dash: (self.dash + k) % DASHES.len(),
            shape: Shape::ALL[(shape + k) % Shape::ALL.len()],
            ..self
        })
    }

    /// Whether a series of such marks looks like one in another style: markers tell apart by their shapes, lines by their dashes.
    pub(super) fn looks_like(self, other: Self, mark: Mark) -> bool {
        let is_same = match mark {
            Mark::LineMarkers | Mark::Markers => self.shape == other.shape,
            Mark::Line | Mark::Guide | Mark::Other => self.dash == other.dash,
        };
        self.color == other.color && is_same
    }

    /// The attributes of a line in this style.
    pub(super) fn line(self) -> String {
        match DASHES[self.dash] {
            "" => format!("class=\"l s{}\"", self.color),
            dash => format!("class=\"l s{}\" stroke-dasharray=\"{dash}\"", self.color),
        }
    }

    /// The attributes of its markers.
    pub(super) fn markers(self) -> String {
        format!("class=\"{} s{}\"", self.shape.class(), self.color)
    }

    /// A small drawing for a legend, an element with these attributes.
    pub(super) fn swatch(self, mark: Mark, attributes: &str) -> String {
        let line = match mark {
            Mark::Markers => String::new(),
            _ => format!("<path {} d=\"M1 7h32\"/>", self.line()),
        };
        let marker = match mark {
            Mark::LineMarkers | Mark::Markers => {
                format!("<path {} d=\"M17 7{}\"/>", self.markers(), self.shape.path())
            }
            Mark::Line | Mark::Guide | Mark::Other => String::new(),
        };
        format!("<svg {attributes} viewBox=\"0 0 34 14\" aria-hidden=\"true\">{line}{marker}</svg>")
    }
}

/// The class of band `index` between `levels`: distinct tints for categories; where the bands are ordered, shades of one hue, or
/// of two on both sides of zero if the levels have both signs, so that zero is the palest.
pub(super) fn band(index: usize, levels: &[f64], is_ordered: bool) -> String {
    const SHADES: usize = 8;
    /// Shades on either side of the middle one.
    const SIDE: usize = 7;
    let last = levels.len();
    let below = levels.iter().filter(|level| **level < 0.0).count();
    let above = levels.iter().filter(|level| **level > 0.0).count();
    if !is_ordered {
        return format!("c{}", index % SHADES);
    }
    if below == 0 || above == 0 {
        return format!("q{}", index * (SHADES - 1) / last.max(1));
    }
    // Without a level at zero, the band around it is the middle one.
    let has_zero = usize::from(below + above < last);
    let (down, up) = ((below + has_zero).saturating_sub(index), index.saturating_sub(below));
    let most = below.max(above) + has_zero;
    let shade = |steps: usize| steps * SIDE / most;
    match (down, up) {
        (0, up) => format!("d{}", SIDE + shade(up)),
        (down, _) => format!("d{}", SIDE - shade(down)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_style_has_variants_that_differ_in_line_and_marker() {
        let style = Palette(&[]).style("", 3, Mark::Line);
        let variants: Vec<Style> = style.variants().collect();
        assert_eq!(variants[0], style);
        for (i, a) in variants.iter().enumerate() {
            assert!(
                variants[..i].iter().all(|b| [Mark::Line, Mark::Markers].iter().all(|mark| !a.looks_like(*b, *mark)))
            );
            assert_eq!(a.color, style.color);
        }
    }

    #[test]
    fn a_method_looks_the_same_wherever_it_stands() {
        let names: Vec<String> = (0..40).map(|n| format!("method-{n}")).collect();
        let palette = Palette(&names);
        let looks = |label: &str, place| palette.style(label, place, Mark::LineMarkers);
        assert_eq!(looks("method-3", 0), looks("method-3", 17));
        assert_eq!(looks("method-3(2,gauss)", 0).color, looks("method-3", 5).color);
        assert_ne!(looks("method-3(2)", 0), looks("method-3(3)", 0));
        // Colour and shape together tell the methods apart.
        let mut seen: Vec<_> = names
            .iter()
            .map(|name| looks(name, 0))
            .map(|s| (s.color, s.shape.class(), s.shape.path(), s.dash))
            .collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), names.len());
        assert_ne!(looks("an exact curve", 0), looks("an exact curve", 1));
    }

    #[test]
    fn bands_of_signed_values_are_palest_at_zero_and_all_differ() {
        let classes = |levels: &[f64]| (0..=levels.len()).map(|i| band(i, levels, true)).collect::<Vec<_>>();
        assert_eq!(classes(&[-2.0, -1.0, 1.0, 2.0]), ["d0", "d4", "d7", "d10", "d14"]);
        assert_eq!(classes(&[-1.0, 0.0, 1.0]), ["d0", "d4", "d10", "d14"]);
        // The streamlines of a cavity.
        let psi = classes(&[-0.1, -0.07, -0.04, -0.02, -0.005, -1e-5, 1e-5]);
        assert_eq!(psi.iter().collect::<std::collections::HashSet<_>>().len(), 8, "{psi:?}");
        assert_eq!(psi[6], "d7");
        let far: Vec<f64> = (-6..=6).filter(|k| *k != 0).map(f64::from).collect();
        assert_eq!(classes(&far).iter().collect::<std::collections::HashSet<_>>().len(), 13);
        assert_eq!(classes(&[0.1, 0.3, 1.0]), ["q0", "q2", "q4", "q7"]);
    }
}
