//! A judgement as evidence, for the report.

use nalgebra::Complex;

use super::Judgement;
use super::tableau::{Coefficient, Tableau};
use super::theory::WeightsTheory;
use evidence::{Axis, Cell, Evidence, Field, Figure, Mark, Panel, Series, Table};

/// Points of the map of the region along each axis.
const GRID: usize = 81;

impl Judgement {
    /// The verdicts as checks, theory and conditions as tables, the region of stability as a figure.
    pub fn evidence(&self) -> Evidence {
        let mut notes = vec![format!("{}.", self.headline())];
        notes.extend(self.file.note.clone());
        notes.extend(self.diagnosis_text());
        notes.extend(self.changes().iter().map(|change| format!("`{change}`")));
        Evidence {
            checks: self.verdicts.iter().map(|verdict| verdict.check.clone()).collect(),
            tables: [
                vec![self.facts_table(), self.file.body.table()],
                self.theory.tables(),
                vec![self.orders_table()],
                self.work_tables(),
            ]
            .concat(),
            figures: [self.theory.figures(), vec![self.orders_figure()]].concat(),
            notes,
            ..Evidence::default()
        }
    }

    fn facts_table(&self) -> Table {
        let row = |(label, text): (&str, String)| vec![Cell::Text(label.into()), Cell::Text(text)];
        table(
            "theory",
            "What the coefficients say.",
            &["property", "value"],
            self.facts().into_iter().map(row).collect(),
        )
    }

    fn work_tables(&self) -> Vec<Table> {
        let points = self.work.iter().filter_map(|work| work.as_ref().ok());
        points.map(|(_, points)| super::work::work_table(points)).collect()
    }

    fn orders_table(&self) -> Table {
        let fits = self.measured.iter().filter_map(|measured| Some((measured, measured.result.as_ref().ok()?)));
        let rows = fits.flat_map(|(measured, fit)| {
            fit.points().into_iter().filter_map(|(sample, reason)| {
                let point = sample.result.as_ref().ok()?;
                Some(vec![
                    Cell::Text(measured.kind.into()),
                    Cell::Number(sample.h),
                    Cell::Number(point.error),
                    Cell::Number(point.floor),
                    Cell::Text(reason.map_or_else(|| "in the fit".into(), ToString::to_string)),
                ])
            })
        });
        let rows = rows.collect();
        Table { shown: false, ..table("runs", "Errors of the runs.", &["problem", "h", "error", "floor", "fit"], rows) }
    }

    fn orders_figure(&self) -> Figure {
        let fits = self.measured.iter().filter_map(|measured| Some((measured, measured.result.as_ref().ok()?)));
        let series = fits.map(|(measured, fit)| Series {
            label: measured.kind.into(),
            points: fit.points().iter().filter_map(|(s, _)| Some((s.h, s.result.as_ref().ok()?.error))).collect(),
            mark: Mark::LineMarkers,
        });
        let axis = |label: &str| Axis { label: label.into(), log: true, limits: None };
        let panel = Panel { x: axis("h"), y: axis("error"), series: series.collect(), ..Panel::default() };
        let caption = "Errors of the runs against the step size.".into();
        Figure { id: "errors".into(), caption, data: "runs".into(), panels: vec![panel], columns: 1 }
    }
}

/// The region where a step on v̇ = λ v multiplies by no more than 1, z = hλ, in a window of about this `size`.
pub(super) fn region(size: f64, growth: impl Fn(Complex<f64>) -> f64) -> Figure {
    let size = size.clamp(4.0, 60.0);
    let range = |low: f64, high: f64| (0..GRID).map(move |k| low + (high - low) * k as f64 / (GRID - 1) as f64);
    let (x, y): (Vec<f64>, Vec<f64>) = (range(-size, 0.6 * size).collect(), range(-size, size).collect());
    // Of real coefficients the region is symmetric.
    let mut values: Vec<Vec<f64>> =
        y[..y.len().div_ceil(2)].iter().map(|&y| x.iter().map(|&x| growth(Complex::new(x, y))).collect()).collect();
    values.extend(values[..y.len() / 2].iter().rev().cloned().collect::<Vec<_>>());
    let field = Field {
        x,
        y,
        values,
        levels: vec![1.0 + 8.0 * f64::EPSILON],
        bands: vec!["|R(z)| ≤ 1".into(), "|R(z)| > 1".into()],
        contours: false,
    };
    let axis = |label: &str| Axis { label: label.into(), log: false, limits: None };
    let panel = Panel { x: axis("Re z"), y: axis("Im z"), field: Some(field), ..Panel::default() };
    let caption = "The region of stability, where a step on v̇ = λv with z = hλ does not grow.".into();
    Figure { id: "region".into(), caption, data: "theory".into(), panels: vec![panel], columns: 1 }
}

impl WeightsTheory {
    /// The conditions of several sets of weights.
    pub(super) fn table<'a>(weights: impl Iterator<Item = (&'a str, &'a Self)>) -> Table {
        let mut rows = Vec::new();
        for (name, weights) in weights {
            for condition in &weights.conditions {
                rows.push(vec![
                    Cell::Integer(condition.order.into()),
                    Cell::Text(weights.forest.brackets(condition.tree)),
                    Cell::Text(weights.formula(condition.tree, name)),
                    Cell::Number(condition.residual.to_f64()),
                    Cell::Number(condition.residual.radius()),
                    Cell::Text(if condition.holds() { "holds" } else { "fails" }.into()),
                ]);
            }
        }
        let caption = "Order conditions: what each is off by, and how far the digits given leave that open.";
        table("conditions", caption, &["order", "tree", "condition", "residual", "uncertainty", "verdict"], rows)
    }
}

impl Tableau {
    /// The coefficients as texts.
    pub(super) fn table(&self) -> Table {
        let numbers = self.numbers();
        let row = |(i, row): (usize, &Vec<Coefficient>)| {
            let c = self.c.as_ref().map_or_else(|| numbers.c[i].decimal(10), |c| c[i].text.clone());
            coefficient_row(&c, row)
        };
        let mut rows: Vec<Vec<Cell>> = self.a.iter().enumerate().map(row).collect();
        rows.push(coefficient_row("b", &self.b));
        rows.extend(self.b_hat.as_ref().map(|b| coefficient_row("b̂", b)));
        let columns: Vec<String> =
            std::iter::once("c".into()).chain((1..=self.stages()).map(|j| format!("a_{j}"))).collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        table("tableau", "The coefficients as the file has them.", &columns, rows)
    }
}

/// A row of coefficients behind their name.
pub(super) fn coefficient_row(name: &str, row: &[Coefficient]) -> Vec<Cell> {
    std::iter::once(Cell::Text(name.into())).chain(row.iter().map(Cell::from)).collect()
}

impl From<&Coefficient> for Cell {
    fn from(coefficient: &Coefficient) -> Self {
        Self::Text(coefficient.text.clone())
    }
}

pub(super) fn table(id: &str, caption: &str, columns: &[&str], rows: Vec<Vec<Cell>>) -> Table {
    let columns = columns.iter().map(|column| (*column).to_owned()).collect();
    Table { id: id.into(), caption: caption.into(), columns, rows, shown: true }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Effort;
    use crate::file::{MethodFile, Shipped};
    use crate::measured::MeasuredOrder;
    use experiments::measure::order::{self, Sample};

    #[test]
    fn a_region_lies_in_the_complex_plane() {
        let figure = region(4.0, |z| (1.0 + z).norm());
        let [panel] = &figure.panels[..] else { panic!("one panel") };
        assert_eq!([&panel.x.label, &panel.y.label], ["Re z", "Im z"]);
        // Of explicit Euler −1 is stable and 2 is not.
        let field = panel.field.as_ref().expect("a map");
        let value = |x: f64| {
            let nearest = |of: &[f64], x: f64| {
                (0..of.len()).min_by(|i, j| (of[*i] - x).abs().total_cmp(&(of[*j] - x).abs())).expect("points")
            };
            field.values[nearest(&field.y, 0.0)][nearest(&field.x, x)]
        };
        assert!(value(-1.0) < field.levels[0] && value(2.0) > field.levels[0]);
        assert_eq!(field.bands, ["|R(z)| ≤ 1", "|R(z)| > 1"]);
    }

    fn parsed(text: &str) -> MethodFile {
        MethodFile::parse("m.toml", "m", text).expect("well-formed")
    }

    fn texts(rows: &[Vec<Cell>]) -> Vec<Vec<String>> {
        rows.iter().map(|row| row.iter().map(ToString::to_string).collect()).collect()
    }

    /// Heun's method with Euler's beside it.
    #[test]
    fn a_table_of_coefficients_has_the_weights_of_both_methods() {
        let file =
            parsed("kind = 'runge-kutta'\na = [[0, 0], [1, 0]]\nb = ['1/2', '1/2']\nb_hat = [1, 0]\nc = [0, 1]\n");
        let rows = texts(&file.body.table().rows);
        assert_eq!(rows, [["0", "0", "0"], ["1", "1", "0"], ["b", "1/2", "1/2"], ["b̂", "1", "0"]]);
    }

    /// 0.333333 and 0.666668 add up to 1.000001, give or take half a unit of the last place each.
    #[test]
    fn a_condition_is_shown_with_what_its_digits_leave_open() {
        let file = parsed("kind = 'runge-kutta'\na = [[0, 0], [1, 0]]\nb = [0.333333, 0.666668]\n");
        let tables = Judgement::new(file, Effort::Theory).theory.tables();
        let conditions = tables.iter().find(|table| table.id == "conditions").expect("conditions");
        let [residual, uncertainty] = [3, 4].map(|column| conditions.rows[0][column].number().expect("a number"));
        approx::assert_relative_eq!(residual, 1e-6, max_relative = 1e-9);
        approx::assert_relative_eq!(uncertainty, 1e-6, max_relative = 1e-9);
    }

    #[test]
    fn a_run_is_shown_with_its_error_and_what_that_is_known_to() {
        let file = Shipped::by_name("implicit-euler").expect("it comes along").read().expect("a method");
        let samples: Vec<Sample> = (0..6).map(|k| 0.5_f64.powi(k)).map(|h| Sample::new(h, h, 1e-9 * h)).collect();
        let result = Ok(order::fit_freely(&samples, 0.1));
        let run =
            MeasuredOrder { kind: "linear", problem: "linear-drag", from: "its conditions", expected: None, result };
        let judgement = Judgement { measured: vec![run], ..Judgement::new(file, Effort::Theory) };
        let numbers: Vec<Vec<f64>> = judgement
            .orders_table()
            .rows
            .iter()
            .map(|row| row[1..4].iter().map(|cell| cell.number().expect("a number")).collect())
            .collect();
        let expected: Vec<Vec<f64>> = (0..6).map(|k| 0.5_f64.powi(k)).map(|h| vec![h, h, 1e-9 * h]).collect();
        assert_eq!(numbers, expected);
    }

    #[test]
    fn errors_are_shown_against_steps_in_powers_of_ten() {
        let file = Shipped::by_name("implicit-euler").expect("it comes along").read().expect("a method");
        let figure = Judgement::new(file, Effort::Theory).orders_figure();
        let [panel] = &figure.panels[..] else { panic!("one panel") };
        assert_eq!([&panel.x.label, &panel.y.label], ["h", "error"]);
        assert!(panel.x.log && panel.y.log);
    }
}
