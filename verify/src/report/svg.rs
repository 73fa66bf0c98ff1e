//! A drawing in fewer bytes: what cannot be seen at a tenth of a pixel is left out.
//!
//! kuva writes coordinates to seventeen digits, an element for each line of the grid, and every point of a curve.

use std::fmt::Write;

/// Coordinates are written in multiples of a tenth of a pixel.
const UNITS: f64 = 10.0;

/// How far a curve may pass a point that is left out, in those units: less than a tenth of its width.
const TOLERANCE: f64 = 1.5;

/// Attributes that hold coordinates and lengths.
const LENGTHS: [&str; 12] = ["x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "width", "height", "stroke-width"];

/// The same drawing with rounded coordinates, curves without needless points, and neighbouring lines of one stroke as one path.
pub(super) fn compact(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len() / 2);
    let mut lines = Lines::default();
    let mut rest = svg;
    while let Some((text, after)) = rest.split_once('<') {
        let Some((tag, after)) = after.split_once('>') else { break };
        if !text.is_empty() {
            lines.flush(&mut out);
            out.push_str(text);
        }
        if !lines.take(tag, &mut out) {
            lines.flush(&mut out);
            element(tag, &mut out);
        }
        rest = after;
    }
    lines.flush(&mut out);
    out.push_str(rest);
    out
}

/// Lines of one stroke that follow each other.
#[derive(Default)]
struct Lines {
    d: String,
    stroke: String,
}

impl Lines {
    /// Whether `tag` is a line with nothing but ends and a stroke; it is then kept back.
    fn take(&mut self, tag: &str, out: &mut String) -> bool {
        let Some((ends, stroke)) = tag.strip_prefix("line ").and_then(|tag| tag.split_once(" stroke=")) else {
            return false;
        };
        let mut ends = ends.split('"').skip(1).step_by(2).map(units);
        let [Some(x1), Some(y1), Some(x2), Some(y2)] = [(); 4].map(|()| ends.next().flatten()) else { return false };
        if ends.next().is_some() {
            return false;
        }
        let stroke = stroke.trim_end_matches(['/', ' ']);
        if stroke != self.stroke {
            self.flush(out);
            self.stroke = stroke.into();
        }
        polyline(&[(x1, y1), (x2, y2)], &mut self.d);
        true
    }

    fn flush(&mut self, out: &mut String) {
        if !self.d.is_empty() {
            out.push_str("<path d=\"");
            out.push_str(&self.d);
            out.push_str("\" stroke=");
            // The stroke and its width, as they were written.
            attributes(&self.stroke, out);
            out.push_str("/>");
            self.d.clear();
            self.stroke.clear();
        }
    }
}

fn element(tag: &str, out: &mut String) {
    out.push('<');
    attributes(tag, out);
    out.push('>');
}

/// Copies a tag, with its lengths and paths rewritten.
fn attributes(tag: &str, out: &mut String) {
    let mut name = "";
    for (index, part) in tag.split('"').enumerate() {
        if index > 0 {
            out.push('"');
        }
        let is_value = index % 2 == 1;
        match (is_value, name) {
            (true, "d") => path(part, out),
            (true, name) if LENGTHS.contains(&name) => match units(part) {
                Some(length) => write_units(length, out),
                None => out.push_str(part),
            },
            _ => out.push_str(part),
        }
        name = if is_value { "" } else { part.trim_end_matches('=').rsplit(' ').next().unwrap_or_default() };
    }
}

fn units(length: &str) -> Option<i64> {
    length.parse::<f64>().ok().filter(|x| x.abs() < 1e6).map(|x| (x * UNITS).round() as i64)
}

fn write_units(length: i64, out: &mut String) {
    let (whole, part) = (length.abs() / UNITS as i64, length.abs() % UNITS as i64);
    let sign = if length < 0 { "-" } else { "" };
    let _ = match (whole, part) {
        (_, 0) => write!(out, "{sign}{whole}"),
        (0, _) => write!(out, "{sign}.{part}"),
        _ => write!(out, "{sign}{whole}.{part}"),
    };
}

/// Copies a path; rewrites one of straight lines between absolute points.
fn path(d: &str, out: &mut String) {
    match subpaths(d) {
        Some(subpaths) => {
            for (points, is_closed) in subpaths {
                polyline(&simplified(&points), out);
                if is_closed {
                    out.push('Z');
                }
            }
        }
        None => out.push_str(d),
    }
}

/// A point in units.
type Point = (i64, i64);

/// The stretches of a path, and whether each is closed; `None` if it has anything but `M`, `L` and `Z`.
fn subpaths(d: &str) -> Option<Vec<(Vec<Point>, bool)>> {
    let mut subpaths: Vec<(Vec<Point>, bool)> = Vec::new();
    let mut rest = d.trim_start();
    while let Some(command) = rest.chars().next() {
        let arguments = rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(&rest[1..], |end| &rest[1..=end]);
        rest = &rest[1 + arguments.len()..];
        let numbers: Vec<i64> =
            arguments.split([' ', ',']).filter(|text| !text.is_empty()).map(units).collect::<Option<_>>()?;
        match (command, numbers.as_slice()) {
            ('M', &[x, y]) => subpaths.push((vec![(x, y)], false)),
            ('L', &[x, y]) => subpaths.last_mut().filter(|(_, is_closed)| !is_closed)?.0.push((x, y)),
            ('Z', &[]) => subpaths.last_mut()?.1 = true,
            _ => return None,
        }
    }
    Some(subpaths)
}

/// Writes the points with relative steps.
fn polyline(points: &[Point], out: &mut String) {
    let mut numbers = |command: char, (x, y): Point| {
        if command != ' ' {
            out.push(command);
        } else if x >= 0 {
            out.push(' ');
        }
        write_units(x, out);
        if y >= 0 {
            out.push(' ');
        }
        write_units(y, out);
    };
    for (index, &(x, y)) in points.iter().enumerate() {
        match index {
            0 => numbers('M', (x, y)),
            _ => {
                let (x0, y0) = points[index - 1];
                numbers(if index == 1 { 'l' } else { ' ' }, (x - x0, y - y0));
            }
        }
    }
}

/// The points without those that lie within [`TOLERANCE`] of the line through their neighbours (Ramer, Douglas and Peucker).
fn simplified(points: &[Point]) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut is_kept = vec![false; points.len()];
    let last = points.len() - 1;
    (is_kept[0], is_kept[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let between = from + 1..to;
        let distance = |i: &usize| distance(points[*i], points[from], points[to]);
        let Some(far) = between.max_by(|a, b| distance(a).total_cmp(&distance(b))) else { continue };
        if distance(&far) > TOLERANCE {
            is_kept[far] = true;
            stretches.extend([(from, far), (far, to)]);
        }
    }
    points.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(point, _)| *point).collect()
}

/// The distance of `p` from the line between `a` and `b`.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let difference = |p: Point, q: Point| ((p.0 - q.0) as f64, (p.1 - q.1) as f64);
    let ((px, py), (dx, dy)) = (difference(p, a), difference(b, a));
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (px - along * dx).hypot(py - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_one_stroke_become_one_path() {
        let line = |x: &str, color: &str| {
            format!(
                "<line x1=\"{x}\" y1=\"10\" x2=\"{x}\" y2=\"248\" stroke=\"{color}\" stroke-width=\"0.7000000000000001\" />"
            )
        };
        let drawing =
            line("122.97", "grid") + &line("0.04", "grid") + &line("1", "axis") + "<text x=\"1.25\">1.25 &gt; x</text>";
        assert_eq!(
            compact(&drawing),
            "<path d=\"M123 10l0 238M0 10l0 238\" stroke=\"grid\" stroke-width=\".7\"/>\
             <path d=\"M1 10l0 238\" stroke=\"axis\" stroke-width=\".7\"/><text x=\"1.3\">1.25 &gt; x</text>"
        );
        let dashed =
            "<line x1=\"1\" y1=\"1\" x2=\"2\" y2=\"2\" opacity=\"0.123\" stroke=\"a\" stroke-dasharray=\"2 3\" />";
        assert_eq!(
            compact(dashed),
            "<line x1=\"1\" y1=\"1\" x2=\"2\" y2=\"2\" opacity=\"0.123\" stroke=\"a\" stroke-dasharray=\"2 3\" />"
        );
    }

    #[test]
    fn what_is_not_a_length_stays() {
        for drawing in [
            "<g clip-path=\"url(#f-1.25)\" opacity=\"0.25\" transform=\"rotate(-90,1.25,2.75)\"></g>",
            "<path d=\"M1.23 2A3 3 0 0 1 4.56 5\" fill=\"none\" />",
            "a < b",
            "",
        ] {
            assert_eq!(compact(drawing), drawing);
        }
        let triangle = "<path d=\"M236.2,219.45000000000002 L232.8,225.23 L239.6,225.23 Z\" fill=\"a\" />";
        assert_eq!(compact(triangle), "<path d=\"M236.2 219.5l-3.4 5.7 6.8 0Z\" fill=\"a\" />");
    }

    /// No point of a curve is further from the drawn one than the tolerance and the rounding, half a unit in each direction.
    #[test]
    fn a_curve_keeps_its_shape() {
        let wave = |i: f64| (0.1 * i, 50.0 + 40.0 * (0.01 * i).sin() + if i == 1234.0 { 30.0 } else { 0.0 });
        let points: Vec<(f64, f64)> = (0..4000).map(|i| wave(f64::from(i))).collect();
        let d: Vec<String> = points.iter().map(|(x, y)| format!("{x} {y}")).collect();
        let all = &subpaths(&format!("M {}", d.join(" L "))).expect("straight lines")[0].0;
        let kept = simplified(all);
        assert!(kept.len() < 200, "{} points", kept.len());
        for point in all {
            let nearest = kept.windows(2).map(|ends| distance(*point, ends[0], ends[1])).fold(f64::MAX, f64::min);
            assert!(nearest <= TOLERANCE, "{point:?}: {nearest}");
        }
        assert!(kept.contains(&all[1234]), "the spike is lost");
    }
}
