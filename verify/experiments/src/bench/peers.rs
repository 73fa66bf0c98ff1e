//! Work and precision beside other solvers, by the crate that links them: a workspace of its own, which nobody else builds.

use std::env;
use std::path::Path;
use std::process::Command;

use super::BenchError;

/// CPU times of runs with the same error, in nanoseconds; of the fastest on each side.
#[derive(Debug, Clone, PartialEq)]
pub struct AtEqualError {
    /// The problem, and the error.
    pub case: String,
    /// By the library; nothing where it does not reach the error.
    pub ours: Option<f64>,
    /// What `other` is of.
    pub side: Other,
    /// Whom the library is compared with, and the time; nothing where it does not reach the error.
    pub other: Option<(String, f64)>,
}

/// Whom the library is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Other {
    /// The fastest of the other solvers.
    Peer,
    /// A loop written by hand.
    ByHand,
}

/// What the program of `manifest` measures, with medians over so many rounds. Cargo builds it, and it prints its tables.
///
/// # Errors
/// [`BenchError::Cargo`] if it cannot be started, [`BenchError::Peers`] if it does not run to its end, [`BenchError::PeersTable`] if it writes something else than its table.
pub fn beside_peers(manifest: &Path, rounds: u16) -> Result<Vec<AtEqualError>, BenchError> {
    let dir = tempfile::tempdir().map_err(BenchError::Counts)?;
    let table = dir.path().join("peers.csv");
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--release", "--manifest-path"]).arg(manifest);
    command.args(["--", "--rounds", &rounds.to_string(), "--out"]).arg(&table);
    let status = command.status().map_err(|source| BenchError::Cargo { manifest: manifest.to_owned(), source })?;
    if !status.success() {
        return Err(BenchError::Peers(manifest.to_owned()));
    }
    read(&table).map_err(|said| BenchError::PeersTable { manifest: manifest.to_owned(), said })
}

/// The rows of the table of the peers.
fn read(path: &Path) -> Result<Vec<AtEqualError>, String> {
    let mut table = csv::Reader::from_path(path).map_err(|error| error.to_string())?;
    let expected = ["set", "case", "error", "ours", "ours_us", "peer", "peer_us", "ratio"];
    let header = table.headers().map_err(|error| error.to_string())?;
    if *header != expected[..] {
        return Err(format!("it begins with {header:?}"));
    }
    let mut rows = Vec::new();
    for row in table.records() {
        let row = row.map_err(|error| error.to_string())?;
        let time = |field: &str| match field {
            "" => Ok(None),
            text => text.parse().map(|us: f64| Some(1e3 * us)).map_err(|_| format!("`{text}` is no time")),
        };
        let side = if &row[0] == "BY HAND" { Other::ByHand } else { Other::Peer };
        rows.push(AtEqualError {
            case: format!("{} at {}{}", &row[1], &row[2], if side == Other::ByHand { ", adaptive" } else { "" }),
            ours: time(&row[4])?,
            side,
            other: time(&row[6])?.map(|time| (row[5].to_owned(), time)),
        });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Result<Vec<AtEqualError>, String> {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("peers.csv");
        std::fs::write(&path, text).expect("writable");
        read(&path)
    }

    const HEADER: &str = "set,case,error,ours,ours_us,peer,peer_us,ratio\n";

    #[test]
    fn times_are_in_nanoseconds_and_what_fails_has_none() {
        let found = rows(&format!("{HEADER}STIFF,HIRES,1e-3,us,3,them,4,.75\nBY HAND,HIRES,1e-6,us,5,,,\n"));
        let [peer, by_hand] = &found.expect("a table")[..] else { panic!("two rows") };
        assert_eq!((peer.case.as_str(), peer.side, peer.ours), ("HIRES at 1e-3", Other::Peer, Some(3e3)));
        assert_eq!(peer.other, Some(("them".into(), 4e3)));
        assert_eq!((by_hand.side, by_hand.ours, &by_hand.other), (Other::ByHand, Some(5e3), &None));
    }

    #[test]
    fn another_table_is_refused() {
        for text in ["a,b\n1,2\n", &format!("{HEADER}STIFF,HIRES,1e-3,us,soon,them,4,1\n"), ""] {
            assert!(rows(text).is_err(), "{text}");
        }
        assert!(read(Path::new("/nowhere/peers.csv")).is_err());
    }
}
