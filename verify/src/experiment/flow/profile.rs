//! Velocities of the cavity on its centre lines, and those that others have published.

/// A velocity in the literature.
#[derive(Debug, Clone, serde::Deserialize)]
pub(crate) struct Published {
    pub(crate) re: f64,
    /// `u` at (½, coord) or `v` at (coord, ½).
    pub(crate) line: char,
    pub(crate) coord: f64,
    pub(crate) velocity: f64,
    pub(crate) source: String,
}

const TABLE: &str = include_str!("../../../data/cavity-published.csv");

/// All of them.
pub(crate) fn published() -> Result<Vec<Published>, csv::Error> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes()).deserialize().collect()
}

/// Velocities on the centre lines of a cavity of an even number of cells, from those of the faces.
#[derive(Debug, Clone)]
pub(crate) struct Profile {
    /// (y, u) at x = ½, then (x, v) at y = ½, the walls included.
    lines: [Vec<(f64, f64)>; 2],
}

impl Profile {
    /// Faces as a problem observes them: u row by row, then v row by row, without those on the walls.
    pub(crate) fn new(cells: usize, faces: &[f64]) -> Self {
        let (inside, middle, n) = (cells - 1, cells / 2, cells as f64);
        let (u, v) = faces.split_at(cells * inside);
        let place = |i: usize| (i as f64 + 0.5) / n;
        let closed = |inner: Vec<(f64, f64)>, end: f64| {
            [(0.0, 0.0)].into_iter().chain(inner).chain([(1.0, end)]).collect::<Vec<_>>()
        };
        let vertical = (0..cells).map(|j| (place(j), u[j * inside + middle - 1])).collect();
        let horizontal = (0..cells).map(|i| (place(i), v[(middle - 1) * cells + i])).collect();
        Self { lines: [closed(vertical, 1.0), closed(horizontal, 0.0)] }
    }

    pub(crate) fn line(&self, line: char) -> &[(f64, f64)] {
        &self.lines[usize::from(line == 'v')]
    }

    /// The velocity at a coordinate, by the cubic through the four nearest points.
    pub(crate) fn at(&self, line: char, coord: f64) -> f64 {
        let points = self.line(line);
        let after = points.partition_point(|(x, _)| *x < coord);
        let first = after.saturating_sub(2).min(points.len() - 4);
        let near = &points[first..first + 4];
        let weight = |i: usize| {
            let others = near.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, (x, _))| (coord - x) / (near[i].0 - x)).product::<f64>()
        };
        near.iter().enumerate().map(|(i, (_, u))| u * weight(i)).sum()
    }
}
