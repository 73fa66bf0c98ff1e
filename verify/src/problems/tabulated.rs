//! Solutions without closed form, computed in 60-digit arithmetic by `verify/data/tabulated.py`.

const TABLE: &str = include_str!("../../data/tabulated.csv");

/// The state of the default problem `name` at time `t`, rounded to doubles, if it is tabulated.
pub(super) fn lookup(name: &str, t: f64) -> Option<Vec<f64>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes());
    let rows = reader.deserialize::<(String, f64, usize, f64)>().filter_map(Result::ok);
    let mut components: Vec<(usize, f64)> =
        rows.filter(|(problem, time, ..)| problem == name && *time == t).map(|(_, _, i, value)| (i, value)).collect();
    components.sort_by_key(|(i, _)| *i);
    (!components.is_empty()).then(|| components.into_iter().map(|(_, value)| value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_readable_and_states_are_whole() {
        let rows = TABLE.lines().filter(|line| !line.starts_with('#')).count() - 1;
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes());
        let parsed: Vec<(String, f64, usize, f64)> =
            reader.deserialize().map(|row| row.expect("well-formed")).collect();
        assert_eq!(parsed.len(), rows);
        for (name, t, ..) in &parsed {
            let problem = super::super::build(name, &[]).expect("registered");
            assert_eq!(lookup(name, *t).map(|v| v.len()), Some(problem.initial().len()), "{name} at t = {t}");
            assert_eq!(problem.tabulated(*t), lookup(name, *t));
        }
        assert_eq!(lookup("van-der-pol", 0.123), None);
    }
}
