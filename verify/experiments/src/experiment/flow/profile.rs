//! Velocities of the cavity on its centre lines, and those that others have published.

/// A velocity in the literature.
#[derive(Debug, Clone, serde::Deserialize)]
pub struct Published {
    /// Reynolds number.
    pub re: f64,
    /// `u` at (½, coord) or `v` at (coord, ½).
    pub line: char,
    /// Coordinate along the line.
    pub coord: f64,
    /// Velocity there.
    pub velocity: f64,
    /// Publication.
    pub source: String,
}

const TABLE: &str = include_str!("../../../../data/cavity-published.csv");

/// All of them.
pub fn published() -> Result<Vec<Published>, csv::Error> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes()).deserialize().collect()
}

/// Velocities on the centre lines of a cavity of an even number of cells, from those of the faces.
#[derive(Debug, Clone)]
pub struct Profile {
    /// (y, u) at x = ½, then (x, v) at y = ½, the walls included.
    lines: [Vec<(f64, f64)>; 2],
}

impl Profile {
    /// Faces as a problem observes them: u row by row, then v row by row, without those on the walls.
    pub fn new(cells: usize, faces: &[f64]) -> Self {
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

    /// Points of the line `u` or `v`.
    pub fn line(&self, line: char) -> &[(f64, f64)] {
        &self.lines[usize::from(line == 'v')]
    }

    /// The velocity at a coordinate, by the cubic through the four nearest points.
    pub fn at(&self, line: char, coord: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of the velocities, and of their products with the coordinates, of the tables that these were copied from, so that neither a digit
    /// nor the place of an entry can differ.
    #[test]
    fn the_published_velocities_are_those_that_were_transcribed() {
        const SUMS: [(&str, f64, char, [f64; 2]); 12] = [
            ("Ghia 1982", 100.0, 'u', [3.28674, 3.789867949]),
            ("Ghia 1982", 100.0, 'v', [0.0273, -0.687734448]),
            ("Ghia 1982", 400.0, 'u', [2.81385, 3.608936696]),
            ("Ghia 1982", 400.0, 'v', [-0.16126, -1.439499143]),
            ("Ghia 1982", 1000.0, 'u', [2.05789, 3.301448458]),
            ("Ghia 1982", 1000.0, 'v', [-0.23732, -1.942942070]),
            ("Botella 1998", 1000.0, 'u', [2.0712685, 3.324942603]),
            ("Botella 1998", 1000.0, 'v', [-0.2784137, -2.013308021]),
            ("Marchi 2009", 100.0, 'u', [-0.461400385, 0.346507543]),
            ("Marchi 2009", 100.0, 'v', [0.000381332, -0.567051103]),
            ("Marchi 2009", 400.0, 'u', [-0.435784557, 0.626973549]),
            ("Marchi 2009", 400.0, 'v', [-0.004772342, -0.964439677]),
        ];
        let table = published().expect("it is well-formed");
        // Marchi and others leave out what lies on the walls.
        let of_each = |source: &str| if source == "Marchi 2009" { 15 } else { 17 };
        assert_eq!(table.len(), SUMS.iter().map(|(source, ..)| of_each(source)).sum::<usize>());
        for (source, re, line, [sum, moment]) in SUMS {
            let of: Vec<_> = table.iter().filter(|p| (&*p.source, p.re, p.line) == (source, re, line)).collect();
            let found: f64 = of.iter().map(|p| p.velocity).sum();
            assert!((found - sum).abs() < 1e-10, "{source}, Re = {re}, {line}: {found}");
            let found: f64 = of.iter().map(|p| p.coord * p.velocity).sum();
            assert!((found - moment).abs() < 1e-9, "{source}, Re = {re}, {line}: {found}");
            assert_eq!(of.len(), of_each(source), "{source}, Re = {re}, {line}");
            if of.len() == 15 {
                continue;
            }
            // What lies on a wall moves with it; the others decide what is published in between.
            let at = |end: f64| of.iter().find(|p| p.coord == end).map(|p| p.velocity);
            assert_eq!([at(0.0), at(1.0)], [Some(0.0), Some(if line == 'u' { 1.0 } else { 0.0 })]);
        }
    }

    /// u = y³ + x − ½ and v = x − x² + y − ½: on the centre lines y³, and x − x².
    #[test]
    fn a_profile_is_that_of_the_centre_lines() {
        let n = 6;
        let place = |i: usize| i as f64 / n as f64;
        let middle = |i: usize| (i as f64 + 0.5) / n as f64;
        let u = (0..n).flat_map(|j| (1..n).map(move |i| middle(j).powi(3) + place(i) - 0.5));
        let v = (1..n).flat_map(|j| (0..n).map(move |i| middle(i) - middle(i).powi(2) + place(j) - 0.5));
        let profile = Profile::new(n, &u.chain(v).collect::<Vec<_>>());
        for x in [0.0, 0.0625, 0.3, 0.5, 0.77, 0.9766, 1.0] {
            assert!((profile.at('u', x) - x.powi(3)).abs() < 1e-14);
            assert!((profile.at('v', x) - (x - x * x)).abs() < 1e-14);
        }
    }

    /// u = y⁴ lies off the cubic through four points by the product of its distances from them.
    #[test]
    fn a_velocity_is_that_of_the_cubic_through_two_points_on_either_side() {
        let n = 8;
        let middle = |i: usize| (i as f64 + 0.5) / n as f64;
        let u = (0..n).flat_map(|j| (1..n).map(move |_| middle(j).powi(4)));
        let profile = Profile::new(n, &u.chain(vec![0.0; n * (n - 1)]).collect::<Vec<_>>());
        let places: Vec<f64> = [0.0].into_iter().chain((0..n).map(middle)).chain([1.0]).collect();
        for (pair, y) in places.windows(2).enumerate().map(|(i, pair)| (i, 0.4 * pair[0] + 0.6 * pair[1])) {
            let near = &places[pair.saturating_sub(1).min(places.len() - 4)..][..4];
            let off: f64 = near.iter().map(|place| y - place).product();
            assert!((y.powi(4) - profile.at('u', y) - off).abs() < 1e-14, "at {y}");
        }
    }
}
