//! Misprints that exchange two entries: of a row, of a list, or two rows of a matrix.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::facts::mended;
use super::mend::{System, failing, hold, numbers};
use super::real::Real;
use super::tableau::{Coefficient, Place};

/// Longest list in which exchanges are looked for: their number grows with the cube of the stages.
pub(super) const LONGEST: usize = 16;

/// Failing conditions that sort out most exchanges before all are evaluated.
const FIRST: usize = 2;

/// Two entries or rows to be exchanged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exchange {
    /// What they are: `b[2]`, `row 3 of a`.
    pub names: [String; 2],
    /// Whether c_i and c_j have to be exchanged with rows i and j.
    pub with_c: bool,
    /// How many conditions fail as the file stands and hold with the change.
    pub mends: usize,
}

impl Exchange {
    /// `b[2] ↔ b[3]`, with what it mends.
    pub fn sentence(&self) -> String {
        let [one, other] = &self.names;
        let with_c = if self.with_c { ", and their c with them" } else { "" };
        format!("{one} ↔ {other}{with_c}, mends {}", mended(self.mends))
    }
}

/// An exchange that has not been looked at yet.
struct Candidate {
    names: [String; 2],
    with_c: bool,
    swaps: Vec<(usize, usize)>,
}

/// The first of `systems`, the lowest order last, all of whose conditions some exchange makes hold, and every exchange that does.
pub(super) fn exchanges(systems: &[&dyn System]) -> Option<(usize, Vec<Exchange>)> {
    let lowest = systems.last()?;
    let (entries, printed) = (lowest.entries(), numbers(*lowest));
    let wrong = failing(*lowest, &printed);
    if wrong.is_empty() {
        return None;
    }
    let with = |candidate: &Candidate| {
        let mut changed = printed.clone();
        candidate.swaps.iter().for_each(|&(k, l)| changed.swap(k, l));
        changed
    };
    let differs =
        |candidate: &Candidate| candidate.swaps.iter().any(|&(k, l)| !(&printed[k] - &printed[l]).may_be_zero());
    let first = &wrong[..FIRST.min(wrong.len())];
    let passes = |it: &Candidate| differs(it) && lowest.residuals(&with(it), first).iter().all(Real::may_be_zero);
    let left: Vec<Candidate> = candidates(*lowest, &entries).into_par_iter().filter(passes).collect();
    systems.iter().enumerate().find_map(|(k, system)| {
        let wrong = failing(*system, &printed);
        let mut mended: Vec<&Candidate> = left.iter().filter(|it| hold(*system, &with(it), &wrong)).collect();
        // Whole rows are exchanged where no two entries do: with c that may be the stages in another sequence.
        let least = mended.iter().map(|candidate| candidate.swaps.len()).min()?;
        mended.retain(|candidate| candidate.swaps.len() == least);
        let exchange = |it: &Candidate| Exchange { names: it.names.clone(), with_c: it.with_c, mends: wrong.len() };
        Some((k, mended.into_iter().map(exchange).collect()))
    })
}

/// All exchanges of two entries of one list or row, and of two rows of one matrix.
fn candidates(system: &dyn System, entries: &[(Place, &Coefficient)]) -> Vec<Candidate> {
    let mut blocks: BTreeMap<(&'static str, Option<usize>), Vec<usize>> = BTreeMap::new();
    for (k, (place, _)) in entries.iter().enumerate() {
        blocks.entry(place.block()).or_default().push(k);
    }
    if blocks.values().any(|block| block.len() > LONGEST) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for ((_, row), block) in &blocks {
        // A zero on or above the diagonal is of the shape of the method.
        let may_move = |k: &&usize| row.is_none_or(|i| entries[**k].0.column() < i || !entries[**k].1.real.is_zero());
        let block: Vec<usize> = block.iter().filter(may_move).copied().collect();
        for (at, &k) in block.iter().enumerate() {
            found.extend(block[at + 1..].iter().map(|&l| Candidate {
                names: [k, l].map(|k| entries[k].0.to_string()),
                with_c: false,
                swaps: vec![(k, l)],
            }));
        }
    }
    let rows: Vec<(&str, usize, &Vec<usize>)> =
        blocks.iter().filter_map(|((name, row), block)| Some((*name, (*row)?, block))).collect();
    let sum = |row: &[usize]| {
        let place = system.sum(entries[*row.first()?].0)?;
        entries.iter().position(|(other, _)| *other == place)
    };
    for (at, (name, i, one)) in rows.iter().enumerate() {
        for (_, j, other) in rows[at + 1..].iter().filter(|(matrix, ..)| matrix == name) {
            let names = [i, j].map(|i| format!("row {} of {name}", i + 1));
            let swaps: Vec<_> = one.iter().copied().zip(other.iter().copied()).collect();
            if let (Some(k), Some(l)) = (sum(one), sum(other)) {
                let swaps = [swaps.as_slice(), &[(k, l)]].concat();
                found.push(Candidate { names: names.clone(), with_c: true, swaps });
            }
            found.push(Candidate { names, with_c: false, swaps });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile};
    use super::super::repair::Target;
    use super::super::tableau_system::TableauSystem;
    use super::*;

    /// a₂₂ makes row 2 one of a diagonal, and the other zeros on and above that of a stay where they are.
    #[test]
    fn entries_of_a_row_are_exchanged_below_the_diagonal_and_rows_with_their_times_and_without() {
        let text = "kind = 'partitioned-runge-kutta'\nc = [0, '1/3', '1/4']\n\
                    a = [[0, 0, 0], [0, '1/3', 0], ['1/4', 0, 0]]\nb = ['1/6', '1/3', '1/2']\n\
                    a_hat = [[0, 0, 0], ['1/5', 0, 0], ['1/7', 0, 0]]\nb_hat = ['1/6', '1/3', '1/2']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let system = file.body.system(1).expect("it has conditions");
        let entries = system.entries();
        let found = candidates(&*system, &entries);
        let names = |of: &str| -> Vec<String> {
            found.iter().map(|it| it.names.join(" ↔ ")).filter(|names| names.starts_with(of)).collect()
        };
        assert_eq!(names("a["), ["a[2,1] ↔ a[2,2]", "a[3,1] ↔ a[3,2]"]);
        assert_eq!(names("a_hat["), ["a_hat[3,1] ↔ a_hat[3,2]"]);
        assert_eq!(names("b["), ["b[1] ↔ b[2]", "b[1] ↔ b[3]", "b[2] ↔ b[3]"]);
        let rows: Vec<_> = found.iter().filter(|it| it.names[0].ends_with(" of a")).collect();
        let named: Vec<_> = rows.iter().map(|it| (it.names.join(" ↔ "), it.with_c)).collect();
        let both = |names: &str| [true, false].map(|with_c| (names.to_owned(), with_c));
        let pairs = [both("row 1 of a ↔ row 2 of a"), both("row 1 of a ↔ row 3 of a"), both("row 2 of a ↔ row 3 of a")];
        assert_eq!(named, pairs.concat());
        let last = rows[0].swaps.last().map(|&(k, l)| [k, l].map(|k| entries[k].0));
        assert_eq!(last, Some([Place::In("c", 0), Place::In("c", 1)]));
    }

    #[test]
    fn entries_of_opposite_signs_are_exchanged() {
        let text = "kind = 'multistep'\nrho = [1, -1]\nsigma = ['1/2', '1/2']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let system = file.body.system(2).expect("it has conditions");
        let (_, found) = exchanges(&[&*system]).expect("there is one");
        let [exchange] = &found[..] else { panic!("{found:?}") };
        assert_eq!(exchange.names, ["rho[1]", "rho[2]"]);
    }

    /// The classical method with its first weights exchanged.
    #[test]
    fn an_exchange_mends_the_conditions_of_the_highest_order_that_it_reaches() {
        let text = "kind = 'runge-kutta'\na = [[0, 0, 0, 0], ['1/2', 0, 0, 0], [0, '1/2', 0, 0], [0, 0, 1, 0]]\n\
                    b = ['1/3', '1/6', '1/3', '1/6']\n";
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let Body::RungeKutta(tableau) = &file.body else { panic!("a tableau") };
        let [four, two] = [4, 2].map(|order| TableauSystem::new(tableau, Target { order, embedded: None }));
        let wrong = [&four, &two].map(|system| failing(system, &numbers(system)).len());
        assert!(wrong[0] > wrong[1] && wrong[1] > 0, "{wrong:?}");
        let (reached, found) = exchanges(&[&four, &two]).expect("there is one");
        let named = found.iter().map(|it| (it.names.join(" ↔ "), it.mends)).collect::<Vec<_>>();
        assert_eq!((reached, named), (0, vec![("b[1] ↔ b[2]".into(), wrong[0])]));
    }

    #[test]
    fn lists_are_looked_at_up_to_the_longest() {
        let count = |length: usize| {
            let list = |first: &str| format!("[{first}{}, 1]", ", 0".repeat(length - 2));
            let text = format!("kind = 'multistep'\nrho = {}\nsigma = {}\n", list("-1"), list("0"));
            let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            let system = file.body.system(1).expect("it has conditions");
            candidates(&*system, &system.entries()).len()
        };
        assert_eq!([LONGEST, LONGEST + 1].map(count), [LONGEST * (LONGEST - 1), 0]);
    }
}
