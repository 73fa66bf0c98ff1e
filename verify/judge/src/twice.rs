//! A misprint that stands at several places: a weight that the last row of A repeats, a coefficient of both parts of a method, a
//! number with the sum that was made of it.

use std::collections::BTreeMap;

use super::mend::{System, candidates, failing, hold, numbers, radicands};
use super::real::Real;
use super::repair::{Repair, fitting, is_printed};
use super::tableau::{Coefficient, Place};

/// The entries of a system, as it lists them.
type Entries<'a> = [(Place, &'a Coefficient)];

/// Every change of one number at several places that makes all conditions hold, the one nearest to the printed text first. What
/// satisfies one condition alone is no discovery.
pub(super) fn repairs(system: &dyn System) -> Vec<Repair> {
    let (entries, printed) = (system.entries(), numbers(system));
    let wrong = failing(system, &printed);
    if wrong.len() < 2 {
        return Vec::new();
    }
    let radicands = radicands(system);
    let mut found = Vec::new();
    for group in groups(system, &entries) {
        let (place, old) = entries[group[0]];
        let sums = sums(system, &entries, &group);
        let with = |x: &Real| {
            let mut changed = printed.clone();
            for &k in &group {
                changed[k] = x.clone();
                if let Some(sum) = sums.get(&k) {
                    changed[*sum] = &changed[*sum] + &(x - &old.real);
                }
            }
            changed
        };
        for x in candidates(system, &wrong, with) {
            if is_printed(&x, old) {
                continue;
            }
            let holds = |value: &Real| hold(system, &with(value), &wrong);
            if let Some((text, value)) = fitting(&x, old, &radicands, holds) {
                let mut follows: Vec<Place> = sums.values().map(|&sum| entries[sum].0).collect();
                follows.dedup();
                let also = group[1..].iter().map(|&k| entries[k].0).collect();
                let (was, mends) = (old.text.clone(), wrong.len());
                found.push(Repair { place, also, follows, makes_implicit: false, was, text, value, mends });
            }
        }
    }
    let distance = |repair: &Repair| strsim::damerau_levenshtein(&repair.was, &repair.text);
    found.sort_by_key(|repair| (repair.also.len(), distance(repair), repair.place));
    found
}

/// The places that one misprint may have reached together, each set once.
fn groups(system: &dyn System, entries: &Entries<'_>) -> Vec<Vec<usize>> {
    let counts = |k: &usize| !entries[*k].1.real.may_be_zero() && entries[*k].0.block().0 != "c";
    let all: Vec<usize> = (0..entries.len()).filter(counts).collect();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (at, &k) in all.iter().enumerate() {
        let twins: Vec<usize> = all[at + 1..].iter().filter(|&&l| are_twins(entries, k, l)).copied().collect();
        groups.extend(twins.iter().map(|&l| vec![k, l]));
        groups.push([vec![k], twins].concat());
    }
    // A single entry has been tried, but for the sum that follows it: that of Runge–Kutta methods does there.
    let follows = |k: usize| matches!(entries[k].0, Place::Of(..)) && system.sum(entries[k].0).is_some();
    groups.retain(|group| group.len() > 1 || follows(group[0]));
    let mut texts: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    all.into_iter().for_each(|k| texts.entry(entries[k].1.text.as_str()).or_default().push(k));
    groups.extend(texts.into_values().filter(|group| group.len() > 1));
    groups.sort();
    groups.dedup();
    groups
}

/// Whether two entries are the same number for a reason: in both parts of a method, or in a row of A that is b.
fn are_twins(entries: &Entries<'_>, k: usize, l: usize) -> bool {
    let same = |x: &Coefficient, y: &Coefficient| (&x.real - &y.real).may_be_zero();
    let (one, other) = (entries[k].0, entries[l].0);
    if one.column() != other.column() || !same(entries[k].1, entries[l].1) {
        return false;
    }
    match (one.block(), other.block()) {
        ((a, Some(i)), (a_hat, Some(j))) => a != a_hat && i == j,
        ((b, None), (b_hat, None)) => b != b_hat,
        (row, list) => {
            let of = |block| entries.iter().filter(move |(place, _)| place.block() == block);
            of(row).zip(of(list)).all(|((_, x), (_, y))| same(x, y))
        }
    }
}

/// Where the sum of the row of each of `group` stands, if that is right as printed.
fn sums(system: &dyn System, entries: &Entries<'_>, group: &[usize]) -> BTreeMap<usize, usize> {
    let sum = |&k: &usize| {
        let place = system.sum(entries[k].0)?;
        let at = entries.iter().position(|(other, _)| *other == place)?;
        let row = entries.iter().filter(|(other, _)| other.block() == entries[k].0.block());
        let total: Real = row.map(|(_, x)| &x.real).sum();
        (&entries[at].1.real - &total).may_be_zero().then_some((k, at))
    };
    group.iter().filter_map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile};
    use super::super::repair::Target;
    use super::super::tableau_system::TableauSystem;
    use super::*;

    fn groups_of(text: &str) -> Vec<Vec<String>> {
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let system = file.body.system(1).expect("it has conditions");
        let entries = system.entries();
        let named = |group: Vec<usize>| group.into_iter().map(|k| entries[k].0.to_string()).collect();
        groups(&*system, &entries).into_iter().map(named).collect()
    }

    /// Zeros are of the shape of a method, and c follows its rows.
    #[test]
    fn a_misprint_is_looked_for_wherever_a_text_stands_but_in_zeros_and_times() {
        let text = "kind = 'nystrom'\na = [[0, 0], ['1/9', 0]]\nb_bar = ['1/4', '1/4']\nb = ['1/2', '1/2']\nc = ['1/2', '1/2']\n";
        assert_eq!(groups_of(text), [["b_bar[1]", "b_bar[2]"], ["b[1]", "b[2]"]]);
    }

    /// Shu and Osher's method with 1/5 for 1/4 at both places of its last row, and the sum of that.
    #[test]
    fn the_sum_of_a_row_follows_every_entry_that_is_changed() {
        let text = "kind = 'runge-kutta'\na = [[0, 0, 0], [1, 0, 0], ['1/5', '1/5', 0]]\nb = ['1/6', '1/6', '2/3']\nc = [0, 1, '2/5']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let Body::RungeKutta(tableau) = &file.body else { panic!("a tableau") };
        let found = repairs(&TableauSystem::new(tableau, Target { order: 3, embedded: None }));
        let named = |places: &[Place]| places.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let told = |it: &Repair| (it.place.to_string(), named(&it.also), named(&it.follows), it.text.clone());
        let expected = ["a[3,1]", "a[3,2]", "c[3]", "1/4"].map(String::from);
        assert!(found.iter().map(told).any(|(a, b, c, d)| [a, b, c, d] == expected), "{found:?}");
    }

    #[test]
    fn a_number_of_both_parts_is_one_however_it_is_written() {
        let text = "kind = 'partitioned-runge-kutta'\na = [['1/2']]\na_hat = [['2/4']]\nb = ['1']\nb_hat = ['2/2']\n";
        assert_eq!(groups_of(text), [["a[1,1]", "a_hat[1,1]"], ["b[1]", "b_hat[1]"]]);
    }
}
