//! Solutions without closed form, computed by the scripts beside the tables in as many digits as their headers state.

use std::sync::LazyLock;

const TABLES: [&str; 2] = [include_str!("../../../data/tabulated.csv"), include_str!("../../../data/stiff.csv")];

/// The state at time `t` of the default problem `name`, or of `name parameter=value …`, rounded to doubles, if it is tabulated.
pub(super) fn lookup(name: &str, t: f64) -> Option<Vec<f64>> {
    /// Read once: it is asked for in every run.
    static ROWS: LazyLock<Vec<Row>> =
        LazyLock::new(|| TABLES.into_iter().flat_map(rows).filter_map(Result::ok).collect());
    let rows = ROWS.iter().filter(|(problem, time, ..)| *time == t && problem == name);
    let mut components: Vec<(usize, f64)> = rows.map(|(_, _, i, value)| (*i, *value)).collect();
    components.sort_by_key(|(i, _)| *i);
    (!components.is_empty()).then(|| components.into_iter().map(|(_, value)| value).collect())
}

/// The digits of the arithmetic that `table` was computed in, as its first line states: `…, 60 digits`.
pub(super) fn digits(table: &str) -> Option<u32> {
    let words: Vec<&str> = table.lines().next()?.split([' ', ',', ';']).collect();
    words.windows(2).find(|pair| pair[1] == "digits")?[0].parse().ok()
}

/// The fewest digits that a tabulated solution was computed in.
pub fn tabulated_digits() -> u32 {
    TABLES.into_iter().map(|table| digits(table).unwrap_or(0)).min().unwrap_or(0)
}

/// Problem, time, component, value.
type Row = (String, f64, usize, f64);

fn rows(table: &'static str) -> impl Iterator<Item = Result<Row, csv::Error>> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(table.as_bytes()).into_deserialize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y₁ + y₂ + y₃ = 1 holds of Robertson's system to the digits of the table.
    #[test]
    fn tabulated_states_keep_the_mass() {
        let mut count = 0;
        for table in TABLES {
            let times = rows(table).map(|row| row.expect("well-formed")).filter(|(name, ..)| name == "robertson");
            for (name, t, ..) in times {
                let sum = lookup(&name, t).expect("tabulated").iter().sum::<f64>();
                assert!((sum - 1.0).abs() <= 4.0 * f64::EPSILON, "{sum} at t = {t}");
                count += 1;
            }
        }
        assert!(count > 0);
    }

    #[test]
    fn every_row_is_readable_and_states_are_whole() {
        // A double has 16.
        assert!(tabulated_digits() >= 32);
        for table in TABLES {
            let lines = table.lines().filter(|line| !line.starts_with('#')).count() - 1;
            let parsed: Vec<Row> = rows(table).map(|row| row.expect("well-formed")).collect();
            assert_eq!(parsed.len(), lines);
            for (name, t, ..) in &parsed {
                let problem = super::super::build_setting(name).expect("registered");
                assert_eq!(lookup(name, *t).map(|v| v.len()), Some(problem.initial().len()), "{name} at t = {t}");
                assert_eq!(problem.tabulated(*t), lookup(name, *t));
            }
        }
        assert_eq!(lookup("van-der-pol", 0.123), None);
    }
}
