//! A command with a limit on its time and on what it writes, run in a process group of its own: at the limit the group ends, and
//! with it whatever the command has started.

use std::collections::BTreeSet;
use std::io::{self, Read};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Most bytes of standard output that are read; a row of a table has some tens.
pub(super) const MOST: u64 = 256 << 20;

/// Bytes of standard error that are kept, the last ones: where the reason stands.
const KEPT: usize = 1 << 12;

/// What became of a command.
#[derive(Debug)]
pub(super) enum Ended {
    /// It ended by itself.
    Itself { status: ExitStatus, stdout: Vec<u8>, stderr: Vec<u8> },
    /// It was ended at the limit of its time.
    TimedOut,
    /// It was ended after [`MOST`] bytes.
    TooLong,
}

/// Runs `command` for `limit` at most.
///
/// # Errors
/// If it does not start, or its output cannot be read.
pub(super) fn run(command: &mut Command, limit: Duration) -> io::Result<Ended> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    lead(command);
    let mut child = command.spawn()?;
    let group = Group::of(child.id());
    let (out, err) = (child.stdout.take(), child.stderr.take());
    thread::scope(|scope| {
        let (done, time) = channel::<()>();
        let group = &group;
        let watch = scope.spawn(move || {
            let late = time.recv_timeout(limit) == Err(RecvTimeoutError::Timeout);
            if late {
                group.end();
            }
            late
        });
        let errors = scope.spawn(|| err.map_or_else(|| Ok(Vec::new()), tail));
        let mut stdout = Vec::new();
        let read = out.map_or(Ok(0), |out| out.take(MOST + 1).read_to_end(&mut stdout));
        let is_long = stdout.len() as u64 > MOST;
        if is_long || read.is_err() {
            group.end();
        }
        // A thread that panicked has read nothing.
        let stderr = errors.join().unwrap_or_else(|_| Ok(Vec::new()));
        let status = child.wait();
        drop(done);
        let late = watch.join().unwrap_or(false);
        match (late, is_long) {
            (true, _) => Ok(Ended::TimedOut),
            (false, true) => Ok(Ended::TooLong),
            (false, false) => read.and(stderr).and_then(|stderr| Ok(Ended::Itself { status: status?, stdout, stderr })),
        }
    })
}

/// The last bytes of `input`, which is read to its end.
fn tail(mut input: impl Read) -> io::Result<Vec<u8>> {
    let (mut kept, mut chunk) = (Vec::new(), [0; KEPT]);
    loop {
        match input.read(&mut chunk)? {
            0 => return Ok(kept),
            n => kept.extend_from_slice(&chunk[..n]),
        }
        kept.drain(..kept.len().saturating_sub(KEPT));
    }
}

/// A running process group, by the process that leads it.
#[derive(Debug)]
struct Group(u32);

/// The groups that run.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

fn running() -> MutexGuard<'static, BTreeSet<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends every program that runs, with all that it has started: a signal from the terminal does not reach their groups.
pub fn end_all() {
    running().iter().for_each(|leader| end(*leader));
}

impl Group {
    fn of(leader: u32) -> Self {
        running().insert(leader);
        Self(leader)
    }

    fn end(&self) {
        end(self.0);
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        running().remove(&self.0);
    }
}

#[cfg(unix)]
fn lead(command: &mut Command) {
    std::os::unix::process::CommandExt::process_group(command, 0);
}

#[cfg(unix)]
fn end(leader: u32) {
    use nix::sys::signal::{Signal, killpg};
    use nix::unistd::Pid;
    if let Ok(leader) = i32::try_from(leader) {
        // A group that has ended by itself is gone.
        let _ = killpg(Pid::from_raw(leader), Signal::SIGKILL);
    }
}

#[cfg(not(unix))]
fn lead(_: &mut Command) {}

#[cfg(not(unix))]
fn end(leader: u32) {
    let _ = Command::new("taskkill").args(["/F", "/T", "/PID", &leader.to_string()]).status();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_is_known_while_it_runs() {
        // No process has this number.
        let leader = u32::MAX;
        let group = Group::of(leader);
        assert!(running().contains(&leader));
        drop(group);
        assert!(!running().contains(&leader));
    }

    /// In a process of its own, as it would end the programs of other tests.
    #[test]
    #[cfg(unix)]
    fn all_that_runs_is_ended_together() {
        const ALONE: &str = "ALL_THAT_RUNS_IS_ENDED";
        if std::env::var_os(ALONE).is_none() {
            let (_, module) = module_path!().split_once("::").expect("a module of a crate");
            let name = format!("{module}::all_that_runs_is_ended_together");
            let tests = std::env::current_exe().expect("the program of the tests");
            let alone = Command::new(tests).args(["--exact", &name]).env(ALONE, "").output().expect("it starts");
            let said = String::from_utf8_lossy(&alone.stdout);
            assert!(alone.status.success() && said.contains("1 passed"), "{said}");
            return;
        }
        let limit = Duration::from_secs(20);
        let sleeps = [(); 2].map(|()| thread::spawn(move || run(Command::new("sleep").arg("20"), limit)));
        let start = std::time::Instant::now();
        while running().len() < sleeps.len() {
            assert!(start.elapsed() < limit, "they do not start");
            thread::sleep(Duration::from_millis(1));
        }
        end_all();
        for sleep in sleeps {
            let ended = sleep.join().expect("it runs");
            assert!(matches!(&ended, Ok(Ended::Itself { status, .. }) if !status.success()), "{ended:?}");
        }
    }
}
