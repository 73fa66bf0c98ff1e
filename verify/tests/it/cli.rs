//! The command line, as a user runs it: names, columns, exit statuses, messages.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use verify::measure::norm::{distance, max_norm};
use verify::names::Parameter;
use verify::{chapter, method, problem, reference, run, theory};

use crate::{fits_a_terminal, flat, scratch, written};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_verify"));
    command.args(arguments).env("NO_COLOR", "1").env_remove("COLUMNS");
    command
}

fn verify(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the program starts")
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

/// Runs words separated by blanks and returns exit status, standard output and standard error.
fn say(line: &str) -> (i32, String, String) {
    let output = verify(&line.split_whitespace().collect::<Vec<_>>());
    (output.status.code().expect("no signal"), stdout(&output).into(), stderr(&output).into())
}

/// A fresh directory for one test.
fn directory(name: &str) -> PathBuf {
    let path = scratch(&format!("cli/{name}"));
    fs::create_dir_all(&path).expect("writable");
    path
}

/// Header and rows of a CSV text.
fn table(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let header = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let rows = reader.deserialize().collect::<Result<Vec<Vec<Option<f64>>>, _>>().expect("numbers");
    (header, rows.into_iter().map(|row| row.into_iter().map(|cell| cell.unwrap_or(f64::NAN)).collect()).collect())
}

/// Ctrl-C in the middle of ten thousand million steps.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_nothing_behind() {
    use nix::sys::signal::{Signal, kill};
    let place = tempfile::tempdir().expect("a directory");
    let file = place.path().join("rows.csv");
    let entries = || fs::read_dir(place.path()).expect("a directory").count();
    let line = "solve --problem logistic --method rk4 --h 1e-9 --t-end 10 --no-estimate --csv";
    let mut run =
        command(&line.split(' ').collect::<Vec<_>>()).arg(&file).stderr(Stdio::null()).spawn().expect("it starts");
    while entries() == 0 {
        assert!(run.try_wait().expect("its status").is_none(), "it ended by itself");
    }
    kill(nix::unistd::Pid::from_raw(run.id().cast_signed()), Signal::SIGINT).expect("it runs");
    assert_eq!((run.wait().expect("its status").code(), entries()), (Some(130), 0));
}

#[test]
fn help_teaches_and_fits() {
    for name in ["", "report", "list", "solve", "order", "compare", "golden", "bench", "judge", "advise"] {
        for flag in ["--help", "-h"] {
            let (status, text, _) = say(&format!("{name} {flag}"));
            assert_eq!(status, 0, "{name}");
            assert!(text.contains("Examples:\n  verify "), "{name}: no example");
            fits_a_terminal(&text);
        }
    }
    let (status, text, _) = say("golden diff --help");
    assert_eq!(status, 0);
    fits_a_terminal(&text);
}

#[test]
fn bench_prints_what_it_measured_and_writes_the_same_as_a_table() {
    let folder = directory("bench");
    let out = folder.to_str().expect("UTF-8");
    let (status, text, errors) = say(&format!("bench --only pendulum --rounds 1 --out {out}"));
    assert_eq!(status, 0, "{errors}");
    fits_a_terminal(&text);
    let lines: Vec<_> = text.lines().collect();
    assert!(lines[0].starts_with("case") && lines[0].ends_with("wanted"), "{text}");
    assert!(lines[1].starts_with("Method I, damped pendulum ") && lines[1].ends_with("≤ 2"), "{text}");
    let path = folder.join("data").join("bench.csv");
    let mut table = csv::Reader::from_path(&path).expect("the table");
    let header = ["case", "ours_ns", "limit_ns", "peer", "peer_ns", "ratio_limit", "ratio_peer"];
    assert_eq!(table.headers().expect("a header"), &header[..]);
    let rows: Vec<_> = table.records().collect::<Result<_, _>>().expect("records");
    // By its own type and in a box.
    assert_eq!(rows.len(), 2, "{rows:?}");
    assert!(lines[2].starts_with("Method I, boxed pendulum ") && lines[2].ends_with("≤ 5"), "{text}");
    let number = |i: usize| rows[0][i].parse::<f64>().expect("a number");
    assert!(number(1) > 0.0 && number(2) > 0.0, "{rows:?}");
    assert_eq!(number(5), number(1) / number(2), "{rows:?}");
    // What is printed is what is written.
    let printed: Vec<f64> = lines[1].split_whitespace().filter_map(|word| word.parse().ok()).collect();
    for (printed, i) in printed.iter().take(3).zip([1, 2, 5]) {
        approx::assert_relative_eq!(*printed, number(i), max_relative = 0.01);
    }
    let (status, _, errors) = say(&format!("bench --only nothing --out {out}"));
    assert_eq!(status, 2, "{errors}");
    // A name that others begin with means its own case alone.
    let (status, text, errors) = {
        let output = verify(&["bench", "--only", "channel, N = 1000", "--rounds", "1", "--out", out]);
        (output.status.code(), stdout(&output).to_string(), stderr(&output).to_string())
    };
    assert_eq!(status, Some(0), "{errors}");
    assert_eq!(text.lines().filter(|line| line.starts_with("channel")).count(), 1, "{text}");
}

/// By a cargo that prints a table and writes it where it is told, or fails.
#[cfg(unix)]
#[test]
fn bench_has_the_program_of_the_peers_built_and_adds_its_table() {
    use std::os::unix::fs::PermissionsExt;
    let folder = directory("bench-peers");
    let out = folder.to_str().expect("UTF-8");
    let cargo = folder.join("cargo");
    let bench = |script: &str| {
        fs::write(&cargo, format!("#!/bin/sh\n{script}\n")).expect("writable");
        fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).expect("it is ours");
        let mut command = command(&["bench", "--peers", "--rounds", "1", "--out", out]);
        let output = command.env("CARGO", &cargo).current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("starts");
        (output.status.code(), stdout(&output).to_string(), stderr(&output).to_string())
    };
    let header = "set,case,error,ours,ours_us,peer,peer_us,ratio";
    let rows = "STIFF,HIRES,1e-3,Radau,3,CVODE,4,.75\\nBY HAND,HIRES,1e-3,Radau,3,Radau IIA-5,2,1.5\\n";
    let writes = |header: &str| format!("echo \"$*\"; for last; do :; done; printf '{header}\\n{rows}' >\"$last\"");
    let (status, text, errors) = bench(&writes(header));
    assert_eq!(status, Some(0), "{errors}");
    let manifest = fs::canonicalize(concat!(env!("CARGO_MANIFEST_DIR"), "/peers/Cargo.toml")).expect("it is there");
    let said = format!("run --release --manifest-path {} -- --rounds 1 --out ", manifest.display());
    assert!(text.contains(&said), "{text}");
    let table = fs::read_to_string(folder.join("data").join("bench.csv")).expect("the table");
    let ends: Vec<&str> = table.lines().rev().take(2).collect();
    assert_eq!(
        ends,
        ["\"HIRES at 1e-3, adaptive\",3000,2000,,,1.5,", "HIRES at 1e-3,3000,,CVODE,4000,,0.75"],
        "{table}"
    );
    let failures = [
        ("exit 3".to_owned(), "did not run to its end"),
        (writes("a,b,c,d,e,f,g,h"), "cannot be read: it begins with"),
    ];
    for (script, said) in failures {
        let (status, _, errors) = bench(&script);
        // Without the ends of lines, which are where the terminal's are.
        let errors = errors.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(status == Some(1) && errors.contains(said), "{status:?}: {errors}");
    }
}

#[test]
fn bench_counts_instructions_that_repeat_or_says_that_valgrind_is_missing() {
    let arguments = ["bench", "--only", "midpoint", "--instructions"];
    let without = command(&arguments).env("PATH", "").output().expect("starts");
    assert!(without.status.code() == Some(1) && stderr(&without).contains("apt-get install valgrind"), "{without:?}");
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../golden/callgrind");
    let all = verify(&["bench", "--instructions", "--golden", golden]);
    if stderr(&all).contains("apt-get install valgrind") {
        return;
    }
    let text = stdout(&all);
    let (status, once, errors) = say(&arguments.join(" "));
    assert_eq!(status, 0, "{errors}");
    let row = once.lines().nth(1).expect("a row");
    let numbers = |row: &str| row.split(' ').filter_map(|word| word.parse().ok()).collect::<Vec<f64>>();
    let [ours, by_hand, ratio] = numbers(row)[..] else { panic!("{row}") };
    // The same binary takes the same instructions but for a few hundred a run of the allocator, which takes the way that the cases before have left.
    let among_all = text.lines().find_map(|line| line.strip_prefix("midpoint, Kepler")).expect("a row for each case");
    for (among_all, alone) in numbers(among_all).into_iter().zip([ours, by_hand]) {
        approx::assert_relative_eq!(among_all, alone, max_relative = 1e-3);
    }
    approx::assert_relative_eq!(ratio, ours / by_hand, max_relative = 0.01);
    // Where the loops by hand take as many as the golden's, to the digits shown, compiler and processor are those of the golden, and the steps are
    // to take as many too.
    let counts = fs::read_to_string(Path::new(golden).join("instructions.snap.csv")).expect("readable");
    let is_alike = |row: &str| -> bool {
        let Some((name, rest)) = row.trim_start_matches('"').split_once(": by hand\",") else { return true };
        let golden: f64 = rest.split(',').next().and_then(|x| x.parse().ok()).expect("a number");
        let shown = text.lines().find_map(|line| line.strip_prefix(name)).expect("a row for each case");
        (numbers(shown)[1] / golden - 1.0).abs() < 1e-3
    };
    let is_same_machine = counts.lines().all(is_alike);
    assert!(all.status.success() || !is_same_machine, "{text}");
}

#[test]
fn a_step_that_stalls_says_so_with_a_remedy() {
    let line = "solve --problem cavity --set re=10000 --set cells=8 --method method-i --h 1000 --t-end 1000";
    let output = command(&line.split(' ').collect::<Vec<_>>()).output().expect("starts");
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(flat(message).contains("|g| = ") && flat(message).contains("|f| = "), "{message}");
    assert!(flat(message).contains("hint: a smaller `--h` may help"), "{message}");
}

/// Taylor and Green's vortices are two waves, carried by the mean flow with frequencies 3/2 and 1/2, that decay with the rate 1/5: a
/// step z = x + iy of Method I multiplies each by 2 (1 + iy)/(1 + (1 − x)² + y²).
#[test]
fn a_solve_says_what_is_lost_of_energy_and_enstrophy() {
    let line = "solve --problem taylor-green --set cells=8 --method method-i --h 0.05 --t-end 0.5";
    let output = command(&line.split(' ').collect::<Vec<_>>()).output().expect("starts");
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    let kept = |y: f64| (4.0 * (1.0 + y * y) / (1.0 + 1.01 * 1.01 + y * y).powi(2)).powi(10);
    let expected = 0.5 * (kept(0.075) + kept(0.025)) - 1.0;
    for (name, start) in [("energy", "0.250000"), ("enstrophy", "0.500000")] {
        let told = said.lines().find(|line| line.starts_with(&format!("{name} "))).unwrap_or_else(|| panic!("{said}"));
        assert!(told.starts_with(&format!("{name} {start} at t = 0, relative change -")), "{told}");
        let change: f64 = told.rsplit(' ').next().and_then(|x| x.parse().ok()).expect("a number");
        approx::assert_relative_eq!(change, expected, max_relative = 1e-5);
    }
    let line = "solve --problem kepler --method stormer-verlet --h 0.05 --t-end 1";
    let output = command(&line.split(' ').collect::<Vec<_>>()).output().expect("starts");
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(said.contains("\nangular momentum "), "{said}");
    // Nothing is a part of zero.
    assert!(
        said.contains("\nRunge–Lenz y 0 at t = 0, change ") && said.contains(" at t = 0, relative change "),
        "{said}"
    );
    let line = "solve --problem logistic --method rk4 --h 0.05 --t-end 1";
    let output = command(&line.split(' ').collect::<Vec<_>>()).output().expect("starts");
    assert!(!String::from_utf8(output.stdout).expect("UTF-8").contains("relative change"));
}

/// At rest |f| is what the tolerances of a step leave of it, and each step takes a system at least.
#[test]
fn a_solve_of_a_flow_ends_with_the_size_of_f_and_its_linear_systems() {
    let ends = |h: f64, steps: u32| {
        let line = format!(
            "solve --problem cavity --set cells=6 --method tr-bdf2 --h {h} --t-end {} --no-estimate",
            h * f64::from(steps)
        );
        let (status, out, message) = say(&line);
        assert_eq!(status, 0, "{message}");
        let told = out.lines().last().and_then(|line| line.strip_prefix("|f| = ")).unwrap_or_else(|| panic!("{out}"));
        let (rate, systems) = told.split_once(" at the end; ").expect("two parts");
        let systems = systems.strip_suffix(" linear systems solved").expect("a number");
        (rate.parse::<f64>().expect("a number"), systems.parse::<u32>().expect("a number"))
    };
    let problem = problem::build_setting("cavity cells=6").expect("known");
    let mut f = vec![0.0; 25];
    let end = run::run(&*problem, &*method::parse("tr-bdf2").expect("known"), 0.25, 0.5, |_| {}).expect("it runs");
    problem.field().rhs(0.5, &end.end.q, &mut f);
    let largest = max_norm(&f);
    let (rate, systems) = ends(0.25, 2);
    approx::assert_relative_eq!(rate, largest, max_relative = 1e-3);
    assert_eq!(u64::from(systems), end.work.factorizations);
    assert!(ends(100.0, 20).0 < 1e-8);
    let (_, out, _) = say("solve --problem logistic --method trapezoidal --h 0.1 --t-end 1");
    assert!(!out.contains("|f|"), "{out}");
}

/// Of an adaptive run with the default tolerances, of which the relative one allows most here.
#[test]
fn what_the_default_tolerances_allow_is_not_warned_of() {
    let (status, _, message) = say("solve --problem kepler --method radau-adaptive --t-end 200");
    assert!(status == 0 && !message.contains("what the tolerances allow"), "{message}");
}

/// Every `verify …` line in the help is a command that the program accepts.
#[test]
fn examples_in_the_help_work() {
    let directory = directory("examples");
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    for model in ["van-der-pol.ds", "predator-prey.ds"] {
        fs::copy(models.join(model), directory.join(model)).expect("readable");
    }
    fs::write(directory.join("drag.csv"), "cells,drag\n64,1.0016\n512,1.0004\n4096,1.0001\n32768,1.000025\n")
        .expect("writable");
    let method = Path::new(env!("CARGO_MANIFEST_DIR")).join("methods/rk4.toml");
    fs::copy(method, directory.join("mine.toml")).expect("readable");
    let mut count = 0;
    for name in ["", "list", "solve", "order", "compare"] {
        let (_, text, _) = say(&format!("{name} --help"));
        let (_, examples) = text.split_once("Examples:\n").expect("examples");
        let (examples, _) = examples.split_once("\n\n").unwrap_or((examples, ""));
        for line in examples.replace(" \\\n     ", "").lines() {
            // Explanations stand behind three blanks, pipes are the shell's. The report has a test of its own.
            let line = line.trim().split("   ").next().unwrap_or_default().split('|').next().unwrap_or_default();
            let arguments: Vec<_> = line.split_whitespace().skip(1).map(|word| word.trim_matches('\'')).collect();
            // A program is its user's.
            if arguments != ["report"] && !arguments.contains(&"--program") {
                let output = command(&arguments).current_dir(&directory).output().expect("starts");
                assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
                count += 1;
            }
        }
    }
    assert!(count >= 12, "only {count} examples found");
}

#[test]
fn an_order_is_written_for_a_pull_request_too() {
    let (status, text, _) = say("order --problem logistic --method method-i --format markdown");
    assert!(status == 0 && text.starts_with("`method-i` on `logistic`, errors against exact"), "{text}");
    let rows = text.lines().skip_while(|line| *line != "| h | error | order | in the fit |").skip(2);
    assert_eq!(rows.take_while(|line| line.starts_with("| ") && line.matches('|').count() == 5).count(), 13, "{text}");
}

#[test]
fn lists_name_everything() {
    let (status, all, _) = say("list");
    assert_eq!(status, 0);
    fits_a_terminal(&all);
    let names = |kind: &str| say(&format!("list {kind}")).1;
    let named = |text: &str, name: &str| text.lines().any(|line| line.split_whitespace().next() == Some(name));
    assert!(["rk4", "blanes-moan"].iter().all(|name| named(&names("method-files"), name)));
    for spec in problem::ALL {
        assert!(named(&names("problems"), spec.name), "{}", spec.name);
        for Parameter { name, default, .. } in spec.parameters {
            assert!(named(&all, &format!("{name}={default}")), "{name}");
        }
    }
    let methods_text = names("methods");
    method::ALL.iter().for_each(|spec| assert!(named(&methods_text, spec.form), "{}", spec.form));
    let references_text = names("references");
    for reference in reference::all() {
        assert!(named(&references_text, reference.name()));
        let row = references_text.lines().find(|line| line.starts_with(&format!("{} ", reference.name())));
        let is_for_stiff = row.is_some_and(|row| row.contains("; stiff and non-stiff problems"));
        // By what the methods are: Adams' and explicit ones are for problems that are not stiff.
        let is_explicit = ["cvode-adams", "diffsol-tsit45"].contains(&reference.name());
        assert!(is_for_stiff != is_explicit || reference.library().is_none(), "{references_text}");
    }
    let studies_text = names("studies");
    chapter::ALL.iter().for_each(|study| assert!(named(&studies_text, study.id)));
    let (status, _, message) = say("list problem");
    assert_eq!(status, 2);
    assert!(flat(&message).contains("problems"), "{message}");
}

/// Every method solves every problem that it applies to. The numbers of the file, which a seventh of the pairs write, so that each problem and each
/// method do with many, read back as the very doubles of the run.
#[test]
fn csv_has_the_columns_and_the_numbers_of_the_run() {
    for (row, spec) in problem::ALL.iter().enumerate() {
        for (column, method) in method::examples().into_iter().enumerate() {
            let problem = problem::small(spec.name).expect("defaults");
            if method.build(&*problem).is_err() {
                continue;
            }
            let (h, t_end) = if problem.is_stiff() { (1e-4, 1e-3) } else { (0.03, 0.1) };
            let name = method.name();
            let mut expected = Vec::new();
            let solved = run::run(&*problem, &*method, h, t_end, |state| {
                let values = problem.observe(state.t, &state.q);
                let error = problem.exact(state.t).map(|exact| distance(&values, &exact));
                expected.push([state.t].into_iter().chain(values).chain(error).collect::<Vec<_>>());
            });
            let breaks_down = solved.is_err() && theory::breakdown(&*problem, &*method, problem.horizon()).is_some();
            assert!(breaks_down || solved.is_ok(), "{} by {name}: {solved:?}", spec.name);
            if (row + column) % 7 != 0 {
                continue;
            }
            let (h, t_end) = (h.to_string(), t_end.to_string());
            let arguments =
                ["solve", "--problem", spec.name, "--method", &name, "--h", &h, "--t-end", &t_end, "--csv", "-"];
            let settings =
                problem::small_settings(spec.name).into_iter().map(|(name, value)| format!("--set={name}={value}"));
            let settings: Vec<String> = settings.collect();
            let output = verify(&arguments.into_iter().chain(settings.iter().map(String::as_str)).collect::<Vec<_>>());
            assert_eq!(
                output.status.code(),
                Some(i32::from(breaks_down)),
                "{} by {name}: {}",
                spec.name,
                stderr(&output)
            );
            if breaks_down {
                continue;
            }
            let (header, mut rows) = table(stdout(&output));
            for row in &mut rows {
                let estimate = row.pop().expect("an estimate");
                assert!(estimate.is_nan() || estimate >= 0.0, "{} by {name}: {estimate}", spec.name);
            }
            let mut expected_header = vec!["t".to_owned()];
            expected_header.extend(problem::component_names(&*problem));
            expected_header.extend(problem.exact(0.0).map(|_| "error".to_owned()));
            expected_header.push("estimate".to_owned());
            assert_eq!(header, expected_header);
            assert_eq!(rows, expected, "{} by {name}", spec.name);
        }
    }
}

/// The second run has taken a step of BDF2 by then, whose error constant is five times that of the step with which both start.
#[test]
fn the_first_row_of_bdf2_alone_has_an_estimate_that_is_a_small_part_of_the_error() {
    for problem in ["quadratic-drag", "linear-drag", "logistic"] {
        let rows = table(&say(&format!("solve --problem {problem} --method bdf2 --h 0.05 --t-end 1 --csv -")).1).1;
        let parts: Vec<_> = rows[1..].iter().map(|row| row[3] / row[2]).collect();
        // Less than half is what is called coarse.
        let is_coarse = |part: &f64| !(0.5..=2.0).contains(part);
        assert!(is_coarse(&parts[0]) && !parts[1..].iter().any(is_coarse), "{parts:?}");
    }
}

#[test]
fn an_estimate_stands_beside_the_error_and_can_be_left_out() {
    let solve = "solve --problem logistic --method trapezoidal --h 0.1 --t-end 2 --csv -";
    let (header, rows) = table(&say(solve).1);
    assert_eq!(header, ["t", "v", "error", "estimate"]);
    // Of the error of second order the next term is a hundredth here.
    assert!(rows[1..].iter().all(|row| (row[3] / row[2] - 1.0).abs() < 0.02), "{rows:?}");
    let (header, without) = table(&say(&format!("{solve} --no-estimate")).1);
    assert_eq!(header, ["t", "v", "error"]);
    assert!(rows.iter().zip(&without).all(|(row, other)| row[..3] == other[..]));

    // Of what is shown, which are velocities where the state is a stream function, at the time that is shown.
    let shown = |h: &str| {
        let line =
            format!("solve --problem cavity-manufactured --set cells=4 --method tr-bdf2 --h {h} --t-end 0.25 --csv -");
        table(&say(&line).1)
    };
    let ((header, coarse), (_, fine)) = (shown("0.125"), shown("0.0625"));
    let components = header.iter().position(|name| name == "error" || name == "estimate").expect("a column");
    for (k, row) in coarse.iter().enumerate() {
        let apart = (1..components).map(|i| (row[i] - fine[2 * k][i]).abs()).fold(0.0, verify::measure::norm::larger);
        assert!((0.75 * row[row.len() - 1] - apart).abs() <= 1e-9, "{apart} in {row:?}");
    }

    // Beside a model, and with tolerances.
    let model = format!("{}/models/van-der-pol.ds", env!("CARGO_MANIFEST_DIR"));
    let (status, text, message) = say(&format!("solve --model {model} --method radau-adaptive --rtol 1e-5 --t-end 2"));
    assert_eq!(status, 0, "{message}");
    assert!(
        text.lines().next().is_some_and(|line| line.ends_with("estimate")) && text.contains("\nlargest estimate "),
        "{text}"
    );

    // A finer run that fails is told, and leaves empty cells.
    let (status, text, message) = say("solve --problem van-der-pol --method linear(-0.5,1) --h 3 --t-end 3 --csv -");
    let early = "the estimate ends early, and what rows from t = 3 on are off by is not known: the finer run fails";
    assert!(status == 0 && flat(&message).contains(early), "{message}");
    assert!(text.contains("# the estimate ends early") && table(&text).1[1][3].is_nan(), "{text}");
}

/// With 2h = 3 the steps of RK4 grow, which the estimate of h = 1.5 knows nothing of; at h = 2.5 a warning says more.
#[test]
fn a_coarse_estimate_is_said_to_be_one() {
    let solve = |h: &str| say(&format!("solve --problem linear-drag --method rk4 --h {h} --t-end 10 --csv -"));
    let (status, text, message) = solve("1.5");
    let message = flat(&message);
    assert!(
        status == 0 && message.contains("note: the estimate is coarse: at the end runs with 2h, h and"),
        "{message}"
    );
    assert!(text.contains("# the estimate is coarse: "), "{text}");
    let motion = "solve --problem pendulum --method stormer-verlet --h 1 --t-end 10";
    assert!(flat(&say(motion).2).contains("note: the estimate is coarse: "), "{}", say(motion).2);
    let (_, _, message) = solve("2.5");
    assert!(message.contains("warning: ") && !message.contains("coarse"), "{message}");
    let (status, text, message) = solve("0.1");
    assert!(status == 0 && message.is_empty() && !text.contains('#'), "{text}{message}");
}

#[test]
fn rows_run_from_zero_to_the_end_by_a_shortened_last_step() {
    let times = |line: &str| -> Vec<f64> {
        let (status, text, message) = say(line);
        // Of a few steps the estimate is coarse.
        assert!(status == 0 && !message.contains("warning"), "{message}");
        table(&text).1.iter().map(|row| row[0]).collect()
    };
    let solve = "solve --problem logistic --method method-i --csv -";
    assert_eq!(times(&format!("{solve} --h 0.3 --t-end 1")), [0.0, 0.3, 0.6, 3.0 * 0.3, 1.0]);
    assert_eq!(times(&format!("{solve} --h 0.5 --t-end 1")), [0.0, 0.5, 1.0]);
    assert_eq!(times(&format!("{solve} --h 3 --t-end 1")), [0.0, 1.0]);
    assert_eq!(times(&format!("{solve} --h 3 --t-end 0")), [0.0]);
}

#[test]
fn parameters_and_arguments_reach_the_computation() {
    let rows = |arguments: &[&str]| {
        let mut all = vec!["solve", "--h", "0.1", "--t-end", "0.1", "--csv", "-"];
        all.extend(arguments);
        let output = verify(&all);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        table(stdout(&output)).1
    };
    let plain = rows(&["--problem", "logistic", "--method", "linear(-0.001,25)"]);
    assert_eq!(rows(&["--problem", "logistic", "--method", "linear( -1e-3 , +2.5E1 )"]), plain);
    assert_ne!(rows(&["--problem", "logistic", "--method", "linear(0.5,1)"]), plain);
    let set = rows(&["--problem", "linear-drag", "--method", "rk4", "--set", "v0=-1", "--set", "lambda = 2"]);
    assert_eq!(set[0][1], -1.0);
    assert!((set[1][1] + (-0.2_f64).exp()).abs() < 1e-5, "{set:?}");
    let euler = |problem: &str, set: &str| rows(&["--problem", problem, "--method", "implicit-euler", "--set", set]);
    // One implicit Euler step of v̇ = k (γ − 2v) from 0 with γ = 2: 2kh/(1 + 2kh), k = 3/2 averaged, 5/4 Galerkin.
    for (problem, set, k) in [
        ("poiseuille-ansatz", "gamma=2", 1.5),
        ("poiseuille-ansatz", "reduction=galerkin", 1.25),
        ("poiseuille-galerkin", "gamma=2", 1.25),
    ] {
        let v = euler(problem, set)[1][1];
        assert!((v - 0.2 * k / (1.0 + 0.2 * k)).abs() < 4.0 * f64::EPSILON, "{problem} {set}: {v}");
    }
}

#[test]
fn bad_usage_is_status_2_with_a_message() {
    let solve = "solve --problem logistic --method method-i --h 0.1 --t-end 1";
    for (line, words) in [
        (
            "solve --problem logistik --method rk4 --h 0.1 --t-end 1",
            "unknown problem `logistik`; did you mean `logistic`?",
        ),
        (
            "solve --problem logistic --method metod-i --h 0.1 --t-end 1",
            "unknown method `metod-i`; did you mean `method-i`?",
        ),
        (&format!("{solve} --set lamda=1"), "unknown parameter `lamda`; did you mean `lambda`?"),
        (&format!("{solve} --set lambda=quick"), "lambda = quick: not a finite number"),
        (&format!("{solve} --set lambda"), "expected name=value"),
        ("solve --problem logistic --method linear(0,0) --h 0.1 --t-end 1", "linear(0,0)"),
        ("solve --problem logistic --method linear(1) --h 0.1 --t-end 1", "linear(ALPHA,BETA)"),
        ("solve --problem logistic --method rk4 --h 0 --t-end 1", "step size h = 0 must be positive"),
        ("solve --problem logistic --method rk4 --h -1e-3 --t-end 1", "step size h = -0.001 must be positive"),
        ("solve --problem logistic --method rk4 --h NaN --t-end 1", "step size h = NaN must be positive"),
        ("solve --problem logistic --method rk4 --h 1e-30 --t-end 1", "cannot resolve"),
        ("solve --problem logistic --method rk4 --h 0.1 --t-end -1", "end time -1 must be"),
        ("solve --problem logistic --method rk4 --h 0.1 --t-end inf", "expected a finite number"),
        ("solve --problem logistic --method rk4 --h fast --t-end 1", "--h"),
        ("solve --problem logistic --method rk4 --t-end 1", "--h"),
        ("solve --problem logistic --method rk4 --h 0.1 --rtol 1e-6 --t-end 1", "no tolerance"),
        ("solve --problem logistic --method radau-adaptive --rtol 0 --t-end 1", "tolerance 0"),
        ("solve --problem logistic --method radau-adaptive --atol -1 --t-end 1", "tolerance -1"),
        ("order --problem logistic --method radau-adaptive", "chooses its steps"),
        ("order --problem logistic --method rk4 --reference cvod", "cvode"),
        ("order --problem van-der-pol --set mu=2 --method rk4 --reference exact", "no exact solution"),
        ("compare --problem keppler", "unknown problem `keppler`; did you mean `kepler`?"),
        ("report --only order", "unknown study `order`; did you mean `orders`?"),
        ("golden", "Usage: verify golden"),
        ("golden chek", "check"),
        ("golden check --only order", "orders"),
        ("slove", "solve"),
        ("", "Usage: verify"),
    ] {
        let (status, out, message) = say(line);
        assert_eq!((status, out.as_str()), (2, ""), "{line}: {message}");
        assert!(flat(&message).contains(words), "{line}: {message}");
        assert!(!flat(&message).contains("panicked"), "{message}");
    }
    let (_, _, message) = say("solve --problem logistic --method rk4 --h 0 --t-end 1");
    assert_eq!(message.lines().nth(1), Some("hint: for example `--h 0.1`"));
}

/// Method II on the van der Pol oscillator loses its branch soon after t = 0.16.
const BREAKS_OFF: &str = "solve --problem van-der-pol --method method-ii --h 0.001 --t-end 5";

#[test]
fn a_solve_that_fails_says_where_and_leaves_no_file() {
    let directory = directory("failure");
    let path = directory.join("out.csv");
    let to_file = format!("{BREAKS_OFF} --csv {}", path.display());
    let entries = || fs::read_dir(&directory).expect("readable").count();

    let (status, out, message) = say(&to_file);
    assert_eq!((status, out.as_str()), (1, ""));
    assert!(message.starts_with("error: van-der-pol by method-ii: step from t = 0."), "{message}");
    assert!(flat(&message).contains("branch of solutions") && message.contains("\nhint: "), "{message}");
    assert_eq!(entries(), 0, "a file was left behind");

    fs::write(&path, "precious").expect("writable");
    assert_eq!(say(&to_file).0, 1);
    assert_eq!(fs::read_to_string(&path).expect("still there"), "precious");
    assert_eq!(entries(), 1, "a file was left behind");

    // To standard output, the rows before the failure stand, and the last one is where the message says.
    let (status, out, message) = say(&format!("{BREAKS_OFF} --csv -"));
    assert_eq!(status, 1);
    let (_, rows) = table(&out);
    let last = rows.last().expect("rows")[0];
    assert!(rows.len() > 100 && flat(&message).contains(&format!("step from t = {last} ")), "{last}: {message}");

    // So do the rows of the table.
    let (status, out, message) = say(BREAKS_OFF);
    assert_eq!(status, 1);
    assert!(out.lines().count() > 10 && message.starts_with("error: "), "{out}{message}");
    fits_a_terminal(&out);

    // On the very first step there is nothing but the initial state.
    let (status, out, message) = say("solve --problem quadratic-drag --method method-ii --h 1 --t-end 5 --csv -");
    assert_eq!((status, out.as_str()), (1, "t,v,error,estimate\n0.0,1.0,0.0,0.0\n"));
    assert!(flat(&message).contains("step from t = 0 with h = 1"), "{message}");
}

#[test]
fn a_solve_that_succeeds_replaces_the_file_and_says_what_it_wrote() {
    let directory = directory("success");
    let path = directory.join("out.csv");
    fs::write(&path, "old").expect("writable");
    let solve = "solve --problem logistic --method method-i --h 0.1 --t-end 10 --csv";
    let (status, out, message) = say(&format!("{solve} {}", path.display()));
    assert_eq!((status, message.as_str()), (0, ""));
    assert!(out.starts_with("101 rows written to "), "{out}");
    let text = fs::read_to_string(&path).expect("written");
    assert_eq!(text, say(&format!("{solve} -")).1);
    assert_eq!(fs::read_dir(&directory).expect("readable").count(), 1, "a file was left behind");

    let (_, rows) = table(&text);
    let largest = rows.iter().map(|row| row[2]).max_by(f64::total_cmp).expect("entries");
    assert!(out.contains(&format!("100 steps to t = 10; largest error {largest:.5e}")), "{out}");

    #[cfg(unix)]
    {
        // A link is followed, not replaced, and a device is written to, not renamed over.
        let link = directory.join("link.csv");
        std::os::unix::fs::symlink(&path, &link).expect("writable");
        assert_eq!(say(&format!("{solve} {} --set v0=0.5", link.display())).0, 0);
        assert!(link.is_symlink());
        assert_ne!(fs::read_to_string(&path).expect("written"), text);
        assert_eq!(say(&format!("{solve} /dev/null")).0, 0);
        assert!(!fs::metadata("/dev/null").expect("there").is_file());
    }
}

#[test]
fn what_cannot_be_written_is_status_2() {
    let directory = directory("unwritable");
    let inside = directory.join("missing/out.csv").display().to_string();
    let solve = "solve --problem logistic --method rk4 --h 0.1 --t-end 1 --csv";
    for path in [inside, directory.display().to_string()] {
        let (status, out, message) = say(&format!("{solve} {path}"));
        assert_eq!((status, out.as_str()), (2, ""), "{message}");
        assert!(flat(&message).starts_with(&format!("error: cannot write {path}: ")), "{message}");
        assert!(!message.contains(".partial"), "{message}");
    }
    let file = directory.join("file");
    fs::write(&file, "").expect("writable");
    let (status, _, message) = say(&format!("report --only symplecticity --out {}/report", file.display()));
    // Refused before anything is computed.
    assert_eq!(status, 2);
    assert!(flat(&message).starts_with(&format!("error: cannot write into {}/report: ", file.display())), "{message}");
    let (status, out, message) = say(&format!("bench --out {}", file.display()));
    assert_eq!((status, out.as_str()), (2, ""), "{message}");
    assert!(
        flat(&message).starts_with(&format!("error: cannot write {}/data/bench.csv: ", file.display())),
        "{message}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_reported() {
    for line in ["list", "solve --problem logistic --method rk4 --h 0.1 --t-end 1 --csv -"] {
        let full = fs::File::options().write(true).open("/dev/full").expect("Linux has it");
        let output = command(&line.split(' ').collect::<Vec<_>>()).stdout(full).output().expect("starts");
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).starts_with("error: cannot write to standard output: "), "{}", stderr(&output));
    }
}

/// A reader who has seen enough ends a solve of a billion steps, without a complaint.
#[test]
fn a_closed_pipe_is_no_error() {
    for line in ["solve --problem logistic --method rk4 --h 2e-6 --t-end 10 --csv -", "list", "--help"] {
        let arguments: Vec<_> = line.split(' ').collect();
        let mut child = command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
        let mut first = [0; 2];
        child.stdout.take().expect("piped").read_exact(&mut first).expect("some output");
        let output = child.wait_with_output().expect("ends");
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""), "{line}");
    }
}

#[test]
fn a_table_is_one_screen_however_many_rows() {
    for (h, steps) in [("0.5", 4), ("0.1", 20), ("0.001", 2000), ("0.0009", 2223)] {
        let (status, out, _) = say(&format!("solve --problem logistic --method method-i --h {h} --t-end 2"));
        assert_eq!(status, 0);
        fits_a_terminal(&out);
        let lines: Vec<_> = out.lines().collect();
        assert!(lines.len() <= 23, "{out}");
        assert_eq!(lines[0].split_whitespace().collect::<Vec<_>>(), ["t", "v", "error", "estimate"]);
        assert_eq!(lines[1].split_whitespace().collect::<Vec<_>>(), ["0", "0.100000", "0", "0"]);
        let rows: Vec<f64> =
            lines[1..].iter().filter_map(|line| line.trim_start().split("  ").next()?.parse().ok()).collect();
        assert!(rows.is_sorted() && rows.last() == Some(&2.0), "{out}");
        let [.., summary, estimate] = lines[..] else { panic!("{out}") };
        assert!(summary.starts_with(&format!("{steps} steps to t = 2; largest error ")), "{out}");
        assert!(estimate.starts_with("largest estimate "), "{out}");
        assert_eq!(out.contains("writes them all"), rows.len() <= steps);
    }
}

#[test]
fn order_passes_fails_or_cannot_tell() {
    let (status, out, _) = say("order --problem quadratic-drag --method method-i");
    assert_eq!(status, 0, "{out}");
    let heading = "method-i on quadratic-drag, errors against exact\nthe largest difference of a component of the state at t = 2\n";
    assert!(out.starts_with(heading), "{out}");
    assert!(out.contains("\nPASS: order ") && out.contains(" is 2 ± 0.1"), "{out}");
    fits_a_terminal(&out);

    // The local error of the trapezoidal rule is −h³v⃛/12, and on v̇ = v(1 − v) it adds up to a multiple of
    // ∫ v⃛/v̇ dt = T − 6(v(T) − v₀). Where that vanishes at T = 2 the rule is of order 4, which refutes no 2.
    let v0 = 1.0 / 3.0 - (1.0 / 9.0 - 1.0 / (3.0 * (2_f64.exp() - 1.0))).sqrt();
    let (status, out, _) = say(&format!("order --problem logistic --set v0={v0} --method trapezoidal"));
    assert_eq!(status, 3, "{out}");
    assert!(out.contains("\nINCONCLUSIVE: order 4.0") && out.contains("is not 2 ± 0.1"), "{out}");
    let (status, out, _) = say("order --problem logistic --method trapezoidal --expect 3");
    assert!(status == 1 && out.contains("\nFAIL: order 2.0") && out.contains("is not 3 ± 0.1"), "{out}");

    // The steady state is met exactly at every step size.
    let (status, out, _) = say("order --problem logistic --set v0=1 --method trapezoidal");
    assert_eq!(status, 3, "{out}");
    assert!(out.contains("\nINCONCLUSIVE: ") && out.contains("no: at the floor"), "{out}");
    fits_a_terminal(&out);
}

#[test]
fn order_as_json_keeps_to_its_schema() {
    let json = |line: &str| -> (i32, serde_json::Value) {
        let (status, out, message) = say(&format!("order --format json {line}"));
        (status, serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}{message}")))
    };
    let (status, value) = json("--problem prothero-robinson --method method-i --reference diffsol");
    assert_eq!(status, 0);
    let keys: Vec<_> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    let mut expected =
        ["problem", "method", "reference", "t_end", "expected", "declared", "slope", "stderr", "r_squared"].to_vec();
    expected.extend(["verdict", "reason", "notes", "points"]);
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!(value["problem"], "prothero-robinson");
    assert_eq!(value["reference"], "diffsol-bdf");
    assert_eq!((value["expected"]["order"].as_f64(), value["declared"]["nominal"].as_f64()), (Some(1.0), Some(2.0)));
    assert_eq!(value["verdict"], "pass");

    let (status, value) = json("--problem logistic --method rk4");
    assert_eq!((status, &value["verdict"], &value["declared"]), (0, &"pass".into(), &serde_json::Value::Null));
    let points = value["points"].as_array().expect("a list");
    let h: Vec<f64> = points.iter().map(|point| point["h"].as_f64().expect("a number")).collect();
    assert!(h.is_sorted_by(|a, b| a > b), "{h:?}");
    assert!(points[0]["local_order"].is_null());
    for point in points {
        assert_eq!(point["kept"].as_bool(), Some(point["reason"].is_null()), "{point}");
        assert!(point["error"].as_f64() >= Some(0.0) && point["floor"].as_f64() >= Some(0.0), "{point}");
    }
    // A local order is that of its own point and the next coarser one.
    let (coarse, fine) = (&points[1], &points[2]);
    let of = |key: &str| coarse[key].as_f64().expect("a number") / fine[key].as_f64().expect("a number");
    let local = fine["local_order"].as_f64().expect("a number");
    assert!((of("error").ln() / of("h").ln() - local).abs() < 1e-9, "{local}");

    let (status, value) = json("--problem logistic --set v0=1 --method rk4");
    assert_eq!((status, &value["verdict"], &value["slope"]), (3, &"inconclusive".into(), &serde_json::Value::Null));
}

#[test]
fn order_takes_the_reference_that_is_asked_for() {
    let reference = |line: &str| say(&format!("order {line}")).1.lines().next().unwrap_or_default().to_owned();
    let drag = "--problem quadratic-drag --method method-i";
    assert!(reference(drag).ends_with("against exact"));
    assert!(reference(&format!("{drag} --reference diffsol")).ends_with("against diffsol-tsit45"));
    let default = reference("--problem van-der-pol --set mu=2 --method rk4");
    if cfg!(feature = "cvode") {
        assert!(default.ends_with("against cvode-adams"), "{default}");
        assert!(reference(&format!("{drag} --reference cvode")).ends_with("against cvode-adams"));
    } else {
        assert!(default.ends_with("against diffsol-tsit45"), "{default}");
        let (status, _, message) = say(&format!("order {drag} --reference cvode"));
        assert_eq!(status, 2);
        assert!(flat(&message).contains("not compiled in") && flat(&message).contains("hint: "), "{message}");
    }
    // Every closure has a limit of its own on the ansatz; with another start than rest none of them is tabulated.
    for method in ["method-i", "method-ii", "rk4"] {
        let line = format!("--problem poiseuille-ansatz --set v0=0.5 --method {method}");
        assert_eq!(say(&format!("order {line}")).0, 0, "{method}");
    }
    // The solution of v̇ = v² from 1 ends at t = 1, before the horizon.
    let (status, out, message) = say("order --problem quadratic-drag --set lambda=-1 --method rk4");
    assert_eq!((status, out.as_str()), (3, ""));
    assert!(flat(&message).contains("stopped at t = 0.99999"), "{message}");
}

#[test]
fn compare_shows_every_solver() {
    let (status, out, _) = say("compare --problem quadratic-drag");
    assert_eq!(status, 0, "{out}");
    fits_a_terminal(&out);
    let problem = problem::build("quadratic-drag", &[]).unwrap();
    let names = theory::methods_for(&*problem).into_iter().map(|method| method.name());
    for name in names.chain(reference::all().iter().map(|reference| reference.name().to_owned())) {
        let line = out.lines().find(|line| line.split_whitespace().next() == Some(&name));
        assert!(line.is_some_and(|line| line.contains("agrees") || line.contains("not ")), "{name}: {out}");
    }
    assert!(out.lines().last().is_some_and(|line| line.contains(" 0 do not")), "{out}");
    // A row a line, on a flow with the longest names too; two equations are told apart.
    let (status, out, _) = say("compare --problem cavity --set cells=6");
    assert_eq!(status, 0, "{out}");
    fits_a_terminal(&out);
    assert!(out.lines().any(|line| line.starts_with("rk4 ") && line.ends_with("agrees")), "{out}");
    let (_, out, _) = say("compare --problem poiseuille-ansatz");
    assert!(out.lines().any(|line| line.starts_with("equation ")), "{out}");
}

/// f is no number beyond t = 1/2.
#[test]
fn a_comparison_of_solvers_that_all_fail_is_inconclusive() {
    let path = written(&directory("all-fail"), "end.ds", "u_i { x = 1 }\nF_i { sqrt(0.5 - t) }\n");
    let (status, out, error) = say(&format!("compare --model {path} --t-end 1"));
    assert!(status == 3 && out.contains("\n0 agree, 0 do not, "), "{status} {out}{error}");
}

#[test]
fn goldens_are_checked_shown_and_refreshed() {
    // Whether they hold is for another test; here the directory must be found.
    let (status, out, message) = say("golden check --only poiseuille-series");
    assert!(status < 2 && out.contains("poiseuille-series: ok"), "{out}{message}");
    let directory = directory("golden");
    let at = |action: &str| say(&format!("golden {action} --only poiseuille-series --dir {}", directory.display()));
    let (status, out, _) = at("diff");
    assert!(status == 1 && out.contains("poiseuille-series: no file"), "{out}");
    assert_eq!(at("refresh").0, 0);
    assert!(directory.join("poiseuille-series.snap.csv").is_file());
    fs::write(directory.join("orphan.txt"), "").expect("writable");
    let (status, out, _) = at("check");
    assert!(status == 0 && out.contains("poiseuille-series: ok") && !out.contains("orphan.txt"), "{out}");
    assert_eq!(at("refresh").0, 0, "of the one that is named, nothing else matters");
    let (status, out, message) = say("golden check --only nonsense");
    assert!(status == 2 && flat(&message).contains("`verify list` shows every golden"), "{out}{message}");
    assert!(say("list goldens").1.lines().any(|line| line == "poiseuille-series"));
    let output =
        command(&["golden", "check", "--only", "poiseuille-series"]).current_dir("/").output().expect("starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--dir"), "{}", stderr(&output));
}

/// Two reports are the same to the byte, and complete.
#[test]
fn a_report_is_written_and_reproducible() {
    let directory = directory("report");
    let report = |name: &str| {
        let out = directory.join(name);
        let (status, text, message) = say(&format!("report --only symplecticity --out {}", out.display()));
        assert_eq!((status, message.as_str()), (0, ""), "{text}");
        fits_a_terminal(&text);
        assert!(text.contains("Symplecticity"));
        let names = ["index.html", "report.md", "results.json", "junit.xml", "data/symplecticity.csv"];
        names.map(|name| fs::read_to_string(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}")))
    };
    let first = report("first");
    assert_eq!(first, report("second"));
    // Beside an earlier one in which something failed that passes.
    let earlier = directory.join("earlier.json");
    fs::write(&earlier, first[2].replacen(r#""outcome": "pass""#, r#""outcome": "fail""#, 1)).expect("writable");
    let line = format!(
        "report --only symplecticity --compare {} --out {}",
        earlier.display(),
        directory.join("third").display()
    );
    let (status, text, message) = say(&line);
    assert!(status == 0 && text.contains("1 change since"), "{text}{message}");
    // The earlier one may be the very file that is replaced.
    let own = directory.join("third");
    let line =
        format!("report --only symplecticity --compare {} --out {}", own.join("results.json").display(), own.display());
    let (status, text, message) = say(&line);
    assert!(status == 0 && text.contains("nothing changed since"), "{text}{message}");
    for (_, version) in [("rustc", "rustc 1."), ("diffsol", "diffsol 0.")] {
        assert!(first[0].contains(version) && first[2].contains(version), "{version}");
    }
}

/// An order that is asked for is the one that is judged by, whatever the problem limits, and steps are kept where a finer reference is taken.
#[test]
fn orders_are_judged_by_what_is_asked_for() {
    // By its remainder Method I has order 1 there.
    let order = "order --problem poiseuille-ansatz --method method-i";
    for (expect, code) in [("1", 0), ("2", 1)] {
        let (status, out, _) = say(&format!("{order} --expect {expect}"));
        assert!(status == code && out.contains("PASS") == (code == 0), "{expect}: {status} {out}");
    }
    // All errors are below what is known of the reference.
    let line = "order --problem van-der-pol --method rk4 --reference diffsol --coarsest 0.004 --points 6";
    let (status, out, _) = say(line);
    assert!(status == 3 && out.contains("0.00400000"), "{status} {out}");
    assert_eq!(out.matches("no: at the floor").count(), 6, "{out}");
}

/// The published examples from files, and answers to what decides nothing.
#[test]
fn order_judges_a_table_of_values() {
    let dir = directory("order-data");
    let write = |name: &str, text: &str| written(&dir, name, text);
    let nparc = write("nparc.csv", "h,recovery\n1,0.97050\n2,0.96854\n4,0.96178\n");
    let (code, out, _) = say(&format!("order --data {nparc} --step h --expect 2 --format json"));
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((code, json["verdict"].as_str(), json["convergence"].as_str()), (0, Some("pass"), Some("monotonic")));
    let near = |key: &str, value: f64, unit: f64| {
        let found = json[key].as_f64().expect("a number");
        assert!((found - value).abs() <= 0.500_001 * unit, "{key}: {found}");
    };
    near("order", 1.786170, 1e-6);
    near("extrapolated", 0.97130, 1e-5);
    near("gci_fine", 0.00103083, 1e-8);

    let cells = "cells,cd,cl\n259350,.23507,1.01\n115200,.23490,1.02\n48600,.23459,\n14400,.23374,1.09\n";
    let cells = write("cells.csv", cells);
    let of_cells = format!("order --data {cells} --cells cells --dimension 3 --expect 2");
    let (code, out, _) = say(&format!("{of_cells} --quantity cd"));
    fits_a_terminal(&out);
    assert!(code == 0 && out.contains("3.200e-4") && out.contains("PASS"), "{out}");
    // Every quantity must settle.
    let (code, out, _) = say(&of_cells);
    assert!(code == 3 && out.contains("is missing"), "{out}");
    let (code, out, _) = say(&format!("{of_cells} --format markdown"));
    assert!(code == 3 && out.lines().count() == 4, "{out}");

    let refused = [
        (format!("order --data {cells} --cells cells"), "--dimension"),
        (format!("order --data {cells} --step h"), "the columns are"),
        (format!("order --data {cells} --cells cells --dimension 4"), "4"),
        (format!("order --data {cells} --cells cells --dimension 3 --exact 1"), "--quantity"),
        (format!("order --data {cells} --cells cells --dimension 3 --expect NaN"), "positive"),
        ("order --data nothing.csv --step h".to_owned(), "cannot read nothing.csv"),
        (format!("order --data {} --step h", write("junk.csv", "h,u\n1,x\n")), "line 2, column `u`"),
        ("order --method method-i".to_owned(), "--problem"),
    ];
    for (line, part) in refused {
        let (code, out, err) = say(&line);
        assert!(code == 2 && out.is_empty() && flat(&err).contains(part), "{line}: {code} {out} {err}");
    }
}

#[test]
fn a_report_that_cannot_be_written_costs_no_study() {
    let directory = directory("unwritable-report");
    let file = directory.join("file");
    fs::write(&file, "in the way").expect("writable");
    let (status, out, message) = say(&format!("report --out {}", file.display()));
    assert!(status == 2 && out.is_empty() && flat(&message).contains("cannot write into"), "{message}");
}

#[test]
fn a_model_can_have_a_report_of_its_own() {
    let out = directory("model-alone");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/van-der-pol.ds");
    let line = format!("report --only model --model {} --t-end 0.5 --out {}", model.display(), out.display());
    let (status, text, message) = say(&line);
    assert!([0, 1, 3].contains(&status), "{text}{message}");
    let results = fs::read_to_string(out.join("results.json")).expect("results");
    let results: serde_json::Value = serde_json::from_str(&results).expect("JSON");
    let ids: Vec<_> = results["chapters"].as_array().expect("chapters").iter().map(|chapter| &chapter["id"]).collect();
    assert_eq!(ids, ["model", "report"]);
    let inconclusive = results["counts"]["inconclusive"].as_u64().expect("a count");
    let failed = results["counts"]["fail"].as_u64().expect("a count");
    assert_eq!(
        status,
        if failed > 0 {
            1
        } else if inconclusive > 0 {
            3
        } else {
            0
        },
        "{text}"
    );
}

/// A program that is what it says, one with a slip of the pen, and this one as a program of its own.
#[test]
fn order_judges_a_program() {
    let dir = directory("order-program");
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let compile = |name: &str, options: &[&str]| {
        let out = dir.join(name);
        let cc = Command::new("cc").args(options).arg("-o").arg(&out).arg(programs.join("rk4.c")).arg("-lm").status();
        assert!(cc.expect("a C compiler links this test, too").success());
        out.display().to_string()
    };
    let order = |arguments: &[&str]| {
        let output = verify(&[&["order", "--problem", "van-der-pol"], arguments].concat());
        (output.status.code().expect("no signal"), stdout(&output).to_owned(), stderr(&output).to_owned())
    };
    let right = compile("right", &[]);
    let (code, out, err) = order(&["--program", &right, "--expect", "4"]);
    assert_eq!(code, 0, "{out}{err}");
    // The command is as long as its path.
    fits_a_terminal(out.split_once("\n\n").expect("a table below the title").1);
    let (code, out, _) = order(&["--program", &compile("wrong", &["-DWRONG"]), "--expect", "4"]);
    assert!(code == 1 && out.contains("FAIL"), "{out}");
    // A program that knows another problem, or none, gives no points.
    let (code, out, _) = order(&["--program", "false", "--expect", "4"]);
    assert!(code == 3 && out.contains("it failed"), "{out}");

    // Its own values, without a reference: order 4 of the difference quotients of three runs and more.
    let (code, out, err) = order(&[
        "--program",
        &right,
        "--quantity",
        "x",
        "--h",
        "0.1,0.05,0.025,0.0125",
        "--t-end",
        "2",
        "--expect",
        "4",
    ]);
    assert!(code == 0 && out.contains("settled on 4 grids"), "{out}{err}");

    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let (code, out, err) = order(&["--program", &own, "--expect", "4", "--format", "json"]);
    assert_eq!(code, 0, "{out}{err}");
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let notes = json["notes"].as_array().expect("a list");
    assert!(
        notes.len() == 1 && notes[0].as_str().is_some_and(|note| note.contains("the last step is cut")),
        "{notes:?}"
    );

    let (code, _, err) = order(&["--program", &right, "--h", "0.1,0.05,0.025"]);
    assert!(code == 2 && flat(&err).contains("--quantity"), "{err}");
    let (code, _, err) = order(&["--program", "'open", "--expect", "4"]);
    assert!(code == 2 && flat(&err).contains("no command"), "{err}");

    let scipy = Command::new("python3").args(["-c", "import scipy.integrate"]).output();
    if scipy.is_ok_and(|output| output.status.success()) {
        let program = format!("python3 {}", programs.join("rk45.py").display());
        // The coefficient of h⁶ is large: it leaves slopes of 5.15 to 5.08. Python takes half a second to begin each run.
        let ladder = ["--coarsest", "0.1", "--points", "4"];
        let judged = ["order", "--problem", "logistic", "--program", &program, "--expect", "5", "--band", "0.2"];
        let output = verify(&[judged.as_slice(), &ladder].concat());
        assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
    }
}

/// The same programs beside the methods, and judged on several problems at once.
#[test]
fn compare_and_judge_take_programs() {
    let own = format!("{} solve --method rk4 --no-estimate --csv -", env!("CARGO_BIN_EXE_verify"));
    let (code, out, err) = {
        let output = verify(&["compare", "--problem", "logistic", "--program", &own, "--expect", "4"]);
        (output.status.code(), stdout(&output).to_owned(), stderr(&output).to_owned())
    };
    assert!(code == Some(0) && out.contains("solve --method rk4"), "{out}{err}");
    // One of a wrong equation is not within its bound; one that fails says so.
    let wrong = format!("{own} --set lambda=1.01");
    for (program, status, reason) in
        [(wrong.as_str(), 1, "differs by more"), ("false", 3, "failed: it failed (exit status: 1)")]
    {
        let output = verify(&["compare", "--problem", "logistic", "--program", program, "--expect", "4"]);
        let text = stdout(&output).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(output.status.code() == Some(status) && text.contains(reason), "{text}");
    }

    let problems = ["--problem", "logistic", "--problem", "damped-pendulum"];
    let judge = |order: &str, format: &str| {
        let output =
            verify(&[&["judge", "--program", &own, "--expect", order, "--format", format], &problems[..]].concat());
        (output.status.code(), stdout(&output).to_owned())
    };
    let (code, text) = judge("4", "text");
    assert!(code == Some(0) && text.matches("confirmed").count() == 2, "{text}");
    let (code, text) = judge("3", "json");
    let verdicts: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((code, verdicts[0]["outcome"].as_str()), (Some(1), Some("fail")));
    let output = verify(&["judge", "--program", &own]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("--expect"));
}

/// A report in parts is the report: each file is the same to the byte, but for the times that were measured.
#[test]
fn the_parts_of_a_report_join_to_the_undivided_one() {
    let dir = directory("report-parts");
    let path = |name: &str| dir.join(name).display().to_string();
    let report = |arguments: &[&str]| {
        let output = verify(&[&["report"], arguments].concat());
        (output.status.code().expect("no signal"), format!("{}{}", stdout(&output), stderr(&output)))
    };
    let only = ["--only", "poiseuille-series", "--only", "metrics"];
    let (whole, text) = report(&[&only[..], &["--out", &path("whole")]].concat());
    assert!(whole == 0 || whole == 3, "{text}");
    for shard in ["1/2", "2/2"] {
        let out = path(if shard == "1/2" { "first" } else { "second" });
        let (code, text) = report(&[&only[..], &["--shard", shard, "--out", &out]].concat());
        assert!(code == 0 && text.contains("1 of 2 studies"), "{text}");
    }
    let (code, text) = report(&["--merge", &path("first")]);
    assert!(code == 2 && text.contains("missing: 2"), "{text}");
    let (code, text) = report(&["--merge", &path("second"), &path("first"), &path("second")]);
    assert!(code == 2 && text.contains("twice"), "{text}");
    let (code, text) = report(&["--merge", &path("second"), &path("first"), "--out", &path("joined")]);
    assert_eq!(code, whole, "{text}");
    for file in ["results.json", "report.md", "junit.xml", "index.html"] {
        let read = |name: &str| fs::read(dir.join(name).join(file)).expect(file);
        assert!(read("whole") == read("joined"), "{file}");
    }
    // And is compared as that is.
    let earlier = dir.join("whole/results.json").display().to_string();
    let parts = ["--merge", &path("second"), &path("first"), "--out", &path("compared"), "--compare", &earlier];
    let (code, text) = report(&parts);
    assert!(code == whole && text.contains("nothing changed since"), "{text}");
    // A part of other studies, and what is no part.
    let (code, text) = report(&["--only", "metrics", "--shard", "2/2", "--out", &path("other")]);
    assert_eq!(code, 0, "{text}");
    let (code, text) = report(&["--merge", &path("first"), &path("other")]);
    assert!(code == 2 && text.contains("the studies asked for"), "{text}");
    fs::write(dir.join("other/2-of-2.part"), "no part").expect("writable");
    let (code, text) = report(&["--merge", &path("other")]);
    assert!(code == 2 && text.contains("is no part"), "{text}");
    let (code, text) = report(&["--shard", "3/2"]);
    assert!(code == 2 && text.contains("K/N"), "{text}");
}

/// Start-ups, overshoots and clipped steps are named.
#[test]
fn order_names_what_is_wrong_with_a_program() {
    let dir = directory("order-slips");
    // BDF2 on v' = v (1 - v) by fixed-point iteration, started by a step of explicit Euler; or a loop that runs over the end.
    let script = dir.join("slips.awk");
    let text = r#"
        function f(v) { return v * (1 - v) }
        BEGIN {
            for (i = 1; i < ARGC; i++) { if (ARGV[i] == "--h") h = ARGV[i + 1]; if (ARGV[i] == "--t-end") T = ARGV[i + 1] }
            v = 0.1; t = 0; n = 0; print "t,v"; printf "%.17g,%.17g\n", t, v
            if (kind == "late") {
                # The end is missed by half a step.
                while (t < T - 0.5 * h - 1e-9) { v = v / (v + (1 - v) * exp(-h)); t += h; if (t > T - 0.6 * h) t = T }
                printf "%.17g,%.17g\n", t + 0.25 * h, v
                exit
            }
            # An error of order four whose growth ends with the run, but for a last step of order four, or of order three.
            if (kind == "four" || kind == "three") {
                N = int(T / h + 0.5)
                for (n = 1; n <= N; n++) {
                    t = n * T / N; last = t > T - h / 2 ? h ^ (kind == "four" ? 5 : 4) : 0
                    printf "%.17g,%.17g\n", t, 0.1 * exp(t) / (0.9 + 0.1 * exp(t)) + 0.1 * (h ^ 4 * (1 - (T - t) ^ 2 / T ^ 2) + last)
                }
                exit
            }
            if (kind == "cut") {
                while (t < T - 1e-9) {
                    d = h < T - t ? h : T - t
                    v += d * f(v); t += d; printf "%.17g,%.17g\n", t, v
                }
                exit
            }
            a = v; v = v + h * f(v); t = h; printf "%.17g,%.17g\n", t, v
            # Two steps of Adams and Bashforth, whose order such a start keeps.
            while (kind == "kept" && t < T - 1e-9) {
                w = v + h / 2 * (3 * f(v) - f(a)); a = v; v = w; t += h; printf "%.17g,%.17g\n", t, v
            }
            # An implicit step of order three from a start of order one.
            while (t < T - 1e-9) {
                w = v
                for (k = 0; k < 200; k++) w = v + h / 12 * (5 * f(w) + 8 * f(v) - f(a))
                a = v; v = w; t += h; printf "%.17g,%.17g\n", t, v
            }
        }"#;
    fs::write(&script, text).expect("writable");
    if !Command::new("awk").args(["BEGIN { exit 0 }"]).status().is_ok_and(|status| status.success()) {
        return;
    }
    let order = |kind: &str| {
        let program = format!("awk -v kind={kind} -f {} --", script.display());
        let expected = match kind {
            "kept" => "2",
            "three" | "four" => "4",
            _ => "3",
        };
        let output = verify(&["order", "--problem", "logistic", "--program", &program, "--expect", expected]);
        (output.status.code().expect("no signal"), stdout(&output).replace("\n      ", " "))
    };
    let refined = |kind: &str, format: &str| {
        let program = format!("awk -v kind={kind} -f {} --", script.display());
        let ladder = if kind == "start" { "0.2,0.1,0.05,0.025" } else { "0.3,0.15,0.075,0.0375" };
        let steps = ["--h", ladder, "--t-end", "2", "--format", format];
        let output = verify(&[&["order", "--program", &program, "--quantity", "v"][..], &steps].concat());
        stdout(&output).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for format in ["table", "json", "markdown"] {
        assert!(refined("cut", format).contains("with h = 0.3 the last step was cut to 0.667 h"), "{format}");
        assert!(!refined("cut", format).contains("different times"), "{format}");
        assert!(refined("late", format).contains("their values belong to different times"), "{format}");
    }
    // Without a reference the same.
    for format in ["table", "json", "markdown"] {
        let named = refined("start", format).contains("a starting procedure limits the order");
        assert!(named, "{format}: {}", refined("start", format));
        assert!(!refined("cut", format).contains("a starting procedure"), "{format}");
    }
    let (code, out) = order("start");
    assert!(code == 1 && out.contains("a starting procedure limits the order"), "{out}");
    let (code, out) = order("kept");
    assert!(code == 0 && !out.contains("starting procedure"), "{out}");
    let (_, out) = order("late");
    assert!(out.contains("it ended at t ="), "{out}");
    // A step of order four lowers no order four.
    for (kind, is_lower) in [("four", false), ("three", true)] {
        let (_, out) = order(kind);
        assert_eq!(out.contains("taken by a method of lower order"), is_lower, "{kind}: {out}");
    }
}

/// 17 · 2^k steps fill the rows of a screen, and the end of the run is the last of them.
#[test]
fn the_end_of_a_run_is_on_the_screen_whatever_the_number_of_its_steps() {
    for steps in [1_u32, 16, 17, 18, 33, 34, 35, 67, 68, 136, 137] {
        let t_end = f64::from(steps) * 0.125;
        let (status, text, _) = say(&format!("solve --problem logistic --method rk4 --h 0.125 --t-end {t_end}"));
        assert_eq!(status, 0);
        let numbers = |line: &str| line.split_whitespace().map(|x| x.parse::<f64>().ok()).collect::<Option<Vec<_>>>();
        let last = text.lines().filter_map(numbers).rfind(|row| row.len() > 1).map(|row| row[0]);
        assert_eq!(last, Some(t_end), "{steps} steps: {text}");
    }
}

#[test]
fn a_number_that_is_too_small_is_named_and_no_option() {
    for option in ["--expect -3", "--coarsest -1", "--band -0.1", "--reference-tolerance -1", "--reference-tolerance 1"]
    {
        let (status, _, error) = say(&format!("order --problem logistic --method rk4 {option}"));
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        let expected = if option.contains("tolerance") {
            "expected a number between 0 and 1"
        } else {
            "expected a positive number"
        };
        assert!(status == 2 && error.contains(expected), "{option}: {error}");
    }
    let (status, _, error) = say("order --problem logistic --method rk4 --coarsest 1e-9");
    let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(status == 2 && error.contains("steps, and 1e8 is the most"), "{error}");
}

/// A program beside may have the name of its method.
#[test]
fn a_shipped_method_is_not_shadowed_by_a_file_of_its_name() {
    let path = directory("shadow");
    fs::write(path.join("rk4"), [0xff, 0xfe]).expect("writable");
    let judge = |name: &str| command(&["judge", name, "--no-runs"]).current_dir(&path).output().expect("starts");
    assert_eq!(judge("rk4").status.code(), Some(0), "{}", stderr(&judge("rk4")));
    assert_eq!(judge("./rk4").status.code(), Some(2));
}

/// What a pulse makes of zero grows by any factor, in steps that resolve it or hold a tolerance.
#[test]
fn a_leap_is_told_where_perturbations_grow_and_the_method_holds_no_tolerance() {
    let dir = directory("leap");
    let warns = |model: &str, rest: &str| {
        let path = dir.join("model.ds");
        fs::write(&path, model).expect("writable");
        say(&format!("solve --model {} {rest}", path.display())).2.contains("resolves nothing")
    };
    let (pole, pulse) = ("u_i { x = 1 } F_i { x*x }", "u_i { x = 0 } F_i { exp(0 - 100*(t-1.5)*(t-1.5)) }");
    assert!(warns(pole, "--method rk4 --h 0.1 --t-end 1.2 --no-estimate"));
    assert!(!warns(pulse, "--method rk4 --h 0.1 --t-end 3"));
    assert!(!warns(pulse, "--method radau-adaptive --rtol 1e-8 --t-end 3"));
    assert!(!warns("u_i { x = 1 } F_i { x }", "--method radau-adaptive --t-end 30"));
}

/// What the sum changed by, with the factors that are shown, and not what a multiple of it did.
#[test]
fn a_broken_invariant_is_told_with_what_the_sum_that_is_shown_changed_by() {
    let path = directory("invariant").join("flow.ds");
    fs::write(&path, "u_i { a = 1, b = 0 }\nF_i { 0 - 4 * a * a, 2 * a * a }\n").expect("writable");
    let model = path.to_str().expect("UTF-8");
    for h in [0.5, 0.1] {
        let (_, text, error) = say(&format!("solve --model {model} --method method-i --h {h} --t-end 5 --csv -"));
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        let told = error
            .split_once("the equation conserves ")
            .and_then(|(_, rest)| rest.split_once(", and the run changed it by "));
        let (sum, rest) = told.unwrap_or_else(|| panic!("{error}"));
        let change: f64 = rest.split(';').next().and_then(|x| x.parse().ok()).unwrap_or_else(|| panic!("{rest}"));
        let words: Vec<&str> = sum.split(' ').collect();
        let factor =
            |name: &str| words.iter().position(|word| *word == name).and_then(|at| words[at - 1].parse::<f64>().ok());
        let (a, b) = (factor("a").expect(sum), factor("b").expect(sum));
        let (_, rows) = table(&text);
        let (first, last) = (&rows[0], rows.last().expect("rows"));
        let expected = a * (last[1] - first[1]) + b * (last[2] - first[2]);
        assert!((change - expected).abs() <= 1e-3 * expected.abs(), "{h}: {change} {expected}: {error}");
    }
}

/// Of 66 components the sum is watched, in the CSV's footer too; a Runge–Kutta method keeps it.
#[test]
fn a_broken_sum_of_many_components_is_told() {
    let path = directory("total").join("pairs.ds");
    let all = |of: &dyn Fn(usize) -> String| (0..33).map(of).collect::<Vec<_>>().join(", ");
    let start = all(&|k| format!("x{k} = 1, y{k} = 0"));
    let rates = all(&|k| format!("-x{k} * x{k}, x{k} * x{k}"));
    fs::write(&path, format!("u_i {{ {start} }}\nF_i {{ {rates} }}\n")).expect("writable");
    let model = path.to_str().expect("UTF-8");
    let told = |method: &str| {
        let command = format!("solve --model {model} --method {method} --h 0.5 --t-end 2 --csv -");
        let (_, text, error) = say(&command);
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        let is_told =
            |text: &str| text.contains("the equation conserves the sum of all components, and the run changed it by");
        assert!(error.contains("but for the sum of all components, are not told"), "{error}");
        [is_told(&error), is_told(&text)]
    };
    assert_eq!([told("method-i"), told("sdirk2")], [[true; 2], [false; 2]]);
}

#[test]
fn what_stability_costs_an_explicit_method_is_told() {
    let (_, text, _) = say("advise --problem linear-drag --set lambda=1000");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let after = |words: &str| {
        let word = text.split_once(words)?.1.split_whitespace().next()?;
        word.trim_end_matches(',').parse::<f64>().ok()
    };
    assert_eq!(after("its fastest rate is "), Some(1000.0), "{text}");
    let steps = after("rk4 is stable with ").expect("told");
    // The interval of stability of RK4 on the negative axis ends at 2.7853.
    assert_eq!(steps, (1000.0 * 2.0_f64 / 2.785).ceil(), "{text}");
}

/// The compiler of models gives up on some texts; one error of ours says so.
#[test]
fn a_model_that_the_compiler_gives_up_on_is_refused() {
    let path = directory("scalar").join("scalar.ds");
    fs::write(&path, "u { 1 }\nF { -u }\n").expect("writable");
    let (status, _, error) = say(&format!("solve --model {} --method rk4 --h 0.1 --t-end 1", path.display()));
    assert!(status == 2 && !error.contains("panicked"), "{status} {error}");
}

/// Orders of one's own pairs that theory has no word on are not refuted by more than they promise, and what is as large as the
/// solution tells nothing.
#[test]
fn orders_that_nobody_knows_are_left_open() {
    let order = |line: &str| say(&format!("order {line}"));
    // On v̇ = −v² it is known what Gauss collocation gains, and on v̇ = v(1 − v) there is nothing.
    let (status, text, _) = order("--problem quadratic-drag --method ls-galerkin(2,gauss,2)");
    assert!(status == 0 && text.contains("declared super-convergence from 4"), "{text}");
    let path = directory("lorenz").join("lorenz.ds");
    let lorenz = "u_i { x = 1, y = 1, z = 1 }\nF_i { 10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z }\n";
    fs::write(&path, lorenz).expect("writable");
    for (t_end, words) in [(20, "% of the solution"), (40, "the references part")] {
        let (status, text, _) = order(&format!("--model {} --t-end {t_end} --method implicit-euler", path.display()));
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(status == 3 && text.contains(words), "{text}");
    }
    // A method without order converges to nothing, however large its errors are.
    let path = directory("inconsistent").join("euler.toml");
    fs::write(&path, "kind = \"runge-kutta\"\na = [[0]]\nb = [\"4/5\"]\n").expect("writable");
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/models/van-der-pol.ds");
    let (status, text, _) = order(&format!("--model {model} --t-end 5 --method {}", path.display()));
    assert_eq!(status, 1, "{text}");
    let path = directory("stiff").join("stiff.ds");
    fs::write(&path, "u_i { v = 1 }\nF_i { 0 - 1000000 * (v - cos(t)) - sin(t) }\n").expect("writable");
    let (status, text, _) = order(&format!("--model {} --method sdirk2", path.display()));
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(status == 3 && text.contains("where stiff equations may lower an order"), "{text}");
}

/// Where f jumps, has a kink or starts like √t no method has the order that it has elsewhere; a method that is worse than that is refuted.
#[test]
fn an_equation_that_is_not_smooth_refutes_no_order() {
    let dir = directory("rough");
    let order = |name: &str, text: &str, rest: &str| {
        let path = dir.join(name);
        fs::write(&path, text).expect("writable");
        let (status, text, error) = say(&format!("order --model {} {rest}", path.display()));
        (status, flat(&text) + &error)
    };
    let jump = "u_i { x = 1 } F_i { heaviside(t-1) - x }";
    let kink = "u_i { x = 1 } F_i { -pow(abs(x),0.5)*x/(abs(x)+1e-300) }";
    let root = "u_i { x = 1 } F_i { sqrt(t) - x }";
    let saturated = "u_i { x = 2, v = 0 } F_i { v, min(max(-50*x - 10*v, -1), 1) }";
    for (name, text, rest, words) in [
        ("saturated.ds", saturated, "--t-end 2 --method trapezoidal", "leaves an error of order 2.0 whose size"),
        ("saturated.ds", saturated, "--t-end 2 --method rk4", "no order above 2.0"),
        ("jump.ds", jump, "--t-end 2 --method gauss2", "f is not smooth along the solution near t = 1.0,"),
        ("jump.ds", jump, "--t-end 2 --method ls-galerkin(3,gauss,3)", "no order above 1.0"),
        ("kink.ds", kink, "--t-end 3 --method rk4", "no order above 2.0"),
        ("root.ds", root, "--t-end 1 --method rk4", "no order above 1.5"),
        ("root.ds", root, "--t-end 1 --method method-i", "no order above 1.5"),
        ("away.ds", "u_i { x = 1 } F_i { -x + abs(t-0.7391) }", "--t-end 2 --method gauss2", "no order above 2.0"),
    ] {
        let (status, said) = order(name, text, rest);
        assert!(status == 3 && said.contains(words), "{name} {rest}: {status} {said}");
    }
    let genes = "u_i { a = 1, b = 2, c = 3 } F_i { 20/(1+c*c*c)-a, 20/(1+a*a*a)-b, 20/(1+b*b*b)-c }";
    // Fast is not rough: errors fall by more than what is rough would leave.
    let (_, said) = order("genes.ds", genes, "--t-end 30 --method radau-iia3");
    assert!(!said.contains("not smooth"), "{said}");
    for (name, text, rest) in [
        ("kink.ds", kink, "--t-end 1.5 --method rk4 --expect 5"),
        ("kink.ds", kink, "--t-end 3 --method implicit-euler --expect 2"),
        ("fine.ds", "u_i { x = 1 } F_i { sin(9*t) - x }", "--t-end 2 --method heun2 --expect 3"),
    ] {
        let (status, said) = order(name, text, rest);
        assert!(status != 0 && !said.contains("not smooth"), "{name} {rest}: {status} {said}");
    }
}

#[test]
fn an_adaptive_method_is_compared_by_its_tolerance() {
    let (status, text, _) = say("compare --problem damped-pendulum --method radau-adaptive");
    let line = text.lines().find(|line| line.contains("radau-adaptive")).unwrap_or_else(|| panic!("{text}"));
    assert!(status == 0 && line.contains("agrees"), "{line}");
}

#[test]
fn one_tolerance_alone_leaves_the_other_what_the_help_says() {
    let rows =
        |rest: &str| say(&format!("solve --problem logistic --method radau-adaptive --t-end 5 --csv - {rest}")).1;
    let plain = rows("");
    assert_eq!(rows("--rtol 1e-6 --atol 1e-9"), plain);
    assert_eq!(rows("--atol 1e-9"), plain);
    assert_eq!(rows("--rtol 1e-6"), plain);
    assert_ne!(rows("--rtol 1e-7"), plain);
}

/// A mass on two springs of different stiffness is back at its start at 6 π.
#[test]
fn strict_tolerances_are_met_where_f_has_kinks() {
    let path = std::env::temp_dir().join(format!("verify-kinks-{}.ds", std::process::id()));
    std::fs::write(&path, "u_i { x = 0, v = 1 } F_i { v, -max(x, 0) - 4*min(x, 0) }").expect("it is written");
    let end = |rest: &str| {
        let path = path.display();
        let tolerances = format!("--method radau-adaptive --rtol 1e-8 --atol 1e-8 --t-end 18.84955592153876 {rest}");
        let (status, text, error) = say(&format!("solve --model {path} {tolerances} --csv - --no-estimate"));
        assert_eq!(status, 0, "{error}");
        let (header, rows) = table(&text);
        let x = header.iter().position(|name| name == "x").expect("a column");
        rows.last().expect("rows")[x].abs()
    };
    let (plain, strict) = (end(""), end("--strict"));
    std::fs::remove_file(&path).expect("it was there");
    assert!(strict < 5e-7 && plain > 10.0 * strict, "{strict:e}, {plain:e} without");
}

/// With the tolerances that are the default, too.
#[test]
fn strict_needs_no_tolerances_beside_it() {
    let steps = |rest: &str| {
        let (status, text, error) = say(&format!(
            "solve --problem van-der-pol --method radau-adaptive --t-end 20 --no-estimate --csv - {rest}"
        ));
        assert_eq!(status, 0, "{error}");
        table(&text).1.len()
    };
    assert!(steps("--strict") > steps(""));
    assert_eq!(steps("--strict"), steps("--strict --rtol 1e-6"));
}

/// Where theory says that none can be told, none is refuted.
#[test]
fn an_order_that_is_not_told_leaves_status_3() {
    let (status, _, error) = say("order --problem hires --method method-ii");
    assert!(status == 3 && flat(&error).contains("no order is predicted"), "{status} {error}");
}

/// Both runs are looked at at the times of the coarser one, inside of steps of the finer.
#[test]
fn the_estimate_of_an_adaptive_run_is_its_error_at_every_row() {
    let (_, text, _) =
        say("solve --problem logistic --method radau-adaptive --rtol 1e-4 --atol 1e-4 --t-end 10 --csv -");
    let (header, rows) = table(&text);
    let at = |name: &str| header.iter().position(|column| column == name).expect(name);
    let (error, estimate) = (at("error"), at("estimate"));
    let large = rows.iter().filter(|row| row[error] > 1e-8).collect::<Vec<_>>();
    assert!(large.len() > 3, "{text}");
    for row in large {
        let ratio = row[estimate] / row[error];
        // Inside of a step the dense output adds errors of its own.
        assert!((0.2..20.0).contains(&ratio), "{row:?}");
    }
}

/// A step that no solution takes: through a zero that the equation does not let be crossed, or along a branch that solutions leave at once.
#[test]
fn a_run_where_no_solution_is_is_told_so() {
    let dir = directory("no-solution");
    let model = |name: &str, text: &str| written(&dir, name, text);
    let robertson = model(
        "robertson.ds",
        "u_i { a = 1, b = 0, c = 0 } F_i { -0.04*a + 1e4*b*c, 0.04*a - 1e4*b*c - 3e7*b*b, 3e7*b*b }",
    );
    let prey = model("prey.ds", "u_i { x = 40, y = 9 } F_i { x*(5-0.4*y), y*(0.5*x-0.8) }");
    let oregonator = model(
        "oregonator.ds",
        "u_i { x = 1, y = 2, z = 3 } F_i { 77.27*(y+x*(1-8.375e-6*x-y)), (z-(1+x)*y)/77.27, 0.161*(x-z) }",
    );
    let pole = model("pole.ds", "u_i { x = 0.1 } F_i { exp(x) }");
    let saddle = model("saddle.ds", "u_i { x = 1, y = 0 } F_i { -x, y }");
    let waves = model("waves.ds", "u_i { x = 1, y = 0 } F_i { y, -x }");
    // Perturbations grow for a while, and no longer at the end.
    let window = model("window.ds", "u_i { x = 1e-9, p = 0 } F_i { 1000*(sin(t+3.5)*x - x*x) + 1e-12, x }");
    let relaxation = model("relaxation.ds", "u_i { x = 2, y = 0 } F_i { y, 10*((1-x*x)*y) - x }");
    // Beside a solution on the way of which they grow, in steps from which the run returns to it.
    let wave =
        model("wave.ds", "u_i { x = 1.001 } rate { 16*exp(-(t-4)*(t-4)) - 2 } F_i { rate*(x - cos(t)) - sin(t) }");
    let epidemic = model(
        "epidemic.ds",
        "u_i { s = 1e6, e = 0, i = 10, r = 0 } beta { 0.05 + 1.6*exp(-(t-60)*(t-60)/200) } \
         F_i { -beta*s*i/1e6, beta*s*i/1e6 - 0.5*e, 0.5*e - 0.25*i, 0.25*i }",
    );
    let said = |line: &str| {
        let (status, _, error) = say(line);
        assert_eq!(status, 0, "{error}");
        flat(&error)
    };
    let crosses = |line: &str| said(line).contains("changes its sign, to");
    assert!(crosses(&format!("solve --model {robertson} --method trapezoidal --h 100 --t-end 1e4")));
    assert!(crosses(&format!("solve --model {prey} --method radau-adaptive --t-end 8 --rtol 1e-7 --atol 1e-7")));
    assert!(!crosses(&format!("solve --model {robertson} --method radau-adaptive --t-end 1e4")));
    assert!(!crosses(&format!("solve --model {prey} --method radau-adaptive --t-end 8 --atol 1e-13")));
    assert!(!crosses(&format!("solve --model {waves} --method rk4 --h 0.3 --t-end 20")));
    // A reference may cross zero as well, by what it is allowed to be off.
    let decay = model("decay.ds", "u_i { x = 1, y = 1 } F_i { -1000*x, -y }");
    for h in [0.3, 1.0, 2.0] {
        assert!(crosses(&format!("solve --model {decay} --method trapezoidal --h {h} --t-end 6")), "{h}");
    }
    let stays = |line: &str| said(line).contains("stays where solutions of the equation do not");
    assert!(stays(&format!("solve --model {oregonator} --method method-i --h 0.1 --t-end 40")));
    assert!(stays(&format!("solve --model {pole} --method method-i --h 0.1 --t-end 2")));
    assert!(!stays(&format!("solve --model {oregonator} --method radau-adaptive --t-end 20")));
    assert!(!stays(&format!("solve --model {saddle} --method rk4 --h 0.5 --t-end 3")));
    for method in ["implicit-euler --h 0.05", "method-i --h 0.05", "radau-iia3 --h 0.1"] {
        assert!(stays(&format!("solve --model {window} --method {method} --t-end 7")), "{method}");
    }
    assert!(!stays(&format!("solve --model {window} --method radau-adaptive --t-end 7 --atol 1e-18")));
    for method in ["radau-iia3 --h 0.3", "trapezoidal --h 0.05", "implicit-euler --h 0.05"] {
        assert!(!stays(&format!("solve --model {relaxation} --method {method} --t-end 40")), "{method}");
    }
    for (model, method, t_end) in [
        (&wave, "method-i --h 0.45", 9),
        (&wave, "window(4) --h 0.2", 9),
        (&epidemic, "method-i --h 3", 150),
        (&epidemic, "window(4) --h 2.5", 150),
    ] {
        assert!(stays(&format!("solve --model {model} --method {method} --t-end {t_end}")), "{method}");
    }
    for method in ["rk4 --h 0.5", "trapezoidal --h 1", "method-i --h 0.1"] {
        assert!(!stays(&format!("solve --model {epidemic} --method {method} --t-end 150")), "{method}");
    }
    // Of e² it shows 5.
    let growth = model("growth.ds", "u_i { x = 1 } F_i { x }");
    assert!(!stays(&format!("solve --model {growth} --method heun2 --h 2 --t-end 20")));
    let lags = |line: &str| said(line).contains("hardly moves it, and the equation does");
    assert!(lags(&format!("solve --model {pole} --method fitted-pade(4.0) --h 0.1 --t-end 3")));
    for method in ["rk4", "method-i", "implicit-euler"] {
        assert!(!lags(&format!("solve --model {waves} --method {method} --h 1.5 --t-end 30")), "{method}");
    }
    // A last step across the crest, from a height to the same.
    let crest = model("crest.ds", "u_i { x = 0.4, y = 2.2 } F_i { y, -x }");
    assert!(!lags(&format!("solve --model {crest} --method implicit-midpoint --h 1 --t-end 2")));
    // Adaptive steps that follow the growth away from a rest which they came by.
    let fox = model(
        "fox.ds",
        "u_i { prey = 1, fox = 1 } F_i { prey*(1 - prey/15) - prey*fox/(0.4 + prey), 4*prey*fox/(0.4 + prey) - fox }",
    );
    assert!(
        !said(&format!("solve --model {fox} --method radau-adaptive --rtol 1e-8 --atol 0 --t-end 100"))
            .contains("came to rest")
    );
    // What a pulse makes of zero grows by any factor.
    let warmed = model("warmed.ds", "u_i { a = 0, b = 0 } F_i { -3*a + exp(-(t-5)*(t-5)*50), 2*a - 4*b }");
    assert_eq!(said(&format!("solve --model {warmed} --method rk4 --h 0.02 --t-end 10")), "");
    // The method lets grow what the solution has none of.
    let rests = |line: &str| said(line).contains("came to rest where the equation is unstable");
    assert!(!rests(&format!("solve --model {saddle} --method rk4 --h 0.5 --t-end 40")));
    assert!(rests(&format!("solve --model {saddle} --method method-i --h 3 --t-end 60")));
    // A last step that is cut short is none to judge by.
    assert!(rests(&format!("solve --model {saddle} --method method-i --h 3 --t-end 60.001")));
}

/// A load that is switched within a step is no fold, and a square root has no derivative at 0.
#[test]
fn a_step_that_fails_at_a_jump_or_a_root_is_told_what_helps() {
    let dir = directory("jumps");
    let model = |name: &str, text: &str| written(&dir, name, text);
    let switched =
        model("switched.ds", "u_i { v = 1, m = 0 } F_i { -m*m*v*1e3 + 50*heaviside(t - 1), exp(v) - m*exp(2*v) }");
    let fails = |line: String| {
        let (status, _, error) = say(&line);
        assert_eq!(status, 1, "{error}");
        flat(&error)
    };
    let error = fails(format!("solve --model {switched} --method method-i --h 0.05 --t-end 2"));
    assert!(error.contains("f jumps in time there"), "{error}");
    let tank = model("tank.ds", "u_i { level = 1 } F_i { -0.5*sqrt(max(level, 0)) }");
    let error = fails(format!("solve --model {tank} --method radau-adaptive --t-end 6"));
    assert!(error.contains("an explicit method, as rk4, asks for none"), "{error}");
    // Beyond its end it is next to nothing.
    let error = fails(format!("solve --model {tank} --method implicit-euler --h 0.1 --t-end 6"));
    assert!(error.contains("hint: the state has come to ") && error.contains(" beside the 1.00000 that"), "{error}");
}

/// What helps is what was tried, from the state at which the step failed.
#[test]
fn a_shorter_step_is_called_for_where_it_leads_on() {
    let dir = directory("shorter");
    let fails = |name: &str, text: &str, line: &str| {
        let (status, _, error) = say(&format!("solve --model {} {line}", written(&dir, name, text)));
        assert_eq!(status, 1, "{error}");
        flat(&error)
    };
    let relay = "u_i { x = 1, y = 0 } F_i { y, -x - 0.3*y + 0.5 - heaviside(x) }";
    for method in ["implicit-euler", "trapezoidal", "bdf2"] {
        let error = fails("relay.ds", relay, &format!("--method {method} --h 0.01 --t-end 10"));
        assert!(error.contains("hint: the rate of y jumps near there, at t = "), "{error}");
        assert!(!error.contains("shorter than"), "{error}");
    }
    let bounce = "u_i { y = 1, v = 0 } F_i { v, -9.81 - heaviside(-y)*(1e5*y + 20*v) }";
    let error = fails("bounce.ds", bounce, "--method trapezoidal --h 0.1 --t-end 3");
    assert!(error.contains("hint: the rate of v jumps near there, at t = 0.45"), "{error}");
    // Its damping jumps by −20 v at the ground, and beyond that each step has one solution.
    let contact = "u_i { x = 1, v = 0 } F_i { v, -9.81 + 1e3*max(-x,0) - 20*v*heaviside(-x) }";
    let error = fails("contact.ds", contact, "--method trapezoidal --h 0.01 --t-end 2");
    let tried = "one beyond it, if the step has one, is not looked for: of its halves, quarters and so on down to 1.56250e-4, none leads across";
    assert!(error.contains(tried) && error.contains("none leads across; `radau-adaptive` leads across"), "{error}");
    let error = fails("contact.ds", contact, "--method implicit-midpoint --h 0.01 --t-end 2");
    assert!(
        error.contains("is not looked for: steps of 0.00250000 lead across; `radau-adaptive` leads across"),
        "{error}"
    );
    let block = "u_i { x = 0, v = 1 } F_i { v, -copysign(0.5, v) - 0.1*x }";
    let error = fails("block.ds", block, "--method implicit-euler --h 0.1 --t-end 10");
    assert!(error.contains("hint: the rate of v jumps near there"), "{error}");
    let blow = "u_i { x = 1 } F_i { x*x }";
    let error = fails("blow.ds", blow, "--method implicit-euler --h 0.1 --t-end 2");
    assert!(error.contains("hint: steps of 0.0500000 lead on from there, to t = 0.6: take a smaller"), "{error}");
    let error = fails("blow.ds", blow, "--method implicit-euler --h 10 --t-end 20");
    assert!(error.contains("hint: no steps down to 0.156250 lead from there to t = 10"), "{error}");
    // Its end is no other step than the one that is asked for.
    let canard = "u_i { x = 1 } F_i { (t - 10)*x + 1e-12 }";
    let error = fails("canard.ds", canard, "--method implicit-euler --h 0.1 --t-end 20");
    assert!(error.contains("ends just before the end of the step") && !error.contains("a step of"), "{error}");
}

/// Runs with h and h/2 agree on what both miss: a fast oscillation that both damp, a transient that both keep, a component in units of its
/// own that both hold.
#[test]
fn a_step_that_is_off_with_half_of_it_as_well_is_told_so() {
    let dir = directory("off");
    let model = |name: &str, text: &str| written(&dir, name, text);
    let ring = model("ring.ds", "u_i { x = 1, y = 0, z = 0 } F_i { 1000*y, -1000*x, x*x - z }");
    let transient = model("transient.ds", "u_i { v = 2 } F_i { -1e6*(v - cos(t)) - sin(t) }");
    let reactor = model("reactor.ds", "u_i { c = 1e-6, T = 300 } F_i { -2*c, 1e7*c - 0.1*(T-300) }");
    let waves = model("calm.ds", "u_i { x = 1, y = 0 } F_i { y, -x }");
    let said = |line: String| {
        let (status, _, error) = say(&line);
        assert_eq!(status, 0, "{error}");
        flat(&error)
    };
    // Of the transient R(z) is left, 1 + z/(1 − z/2 + z²/12) with z = −10⁵, and e^z should be.
    for (model, method, what) in [
        (&ring, "tr-bdf2", "in x, of which the largest value is 1.00000"),
        (&ring, "radau-iia3", "in x, of which the largest value is 1.00000"),
        (&transient, "gauss2", "is off by 0.999880 in v"),
        (&transient, "lobatto-iiia3", "is off by 0.999880 in v"),
        (&reactor, "method-i", "in c, of which"),
    ] {
        let error = said(format!("solve --model {model} --method {method} --h 0.1 --t-end 2"));
        assert!(error.contains("of the equation linearised at t = 0 a step of h = 0.1 is off by"), "{method}: {error}");
        assert!(error.contains(what), "{method}: {error}");
    }
    for (model, method, h) in [
        (&transient, "radau-iia2", 0.1),
        (&transient, "implicit-euler", 0.1),
        (&ring, "gauss2", 1e-4),
        (&reactor, "gauss2", 0.1),
        (&reactor, "method-i", 1e-7),
        (&waves, "rk4", 0.3),
        (&waves, "method-i", 0.1),
    ] {
        let error = said(format!("solve --model {model} --method {method} --h {h} --t-end {}", 10.0 * h));
        assert!(!error.contains("is off by"), "{method}, h = {h}: {error}");
    }
    // Steep at the start alone, and followed.
    let friction = model("friction.ds", "u_i { x = 1, v = 0 } F_i { v, -x - 0.3*(2*sigmoid(200*v) - 1) }");
    let error = said(format!("solve --model {friction} --method rk4 --h 0.2 --t-end 10"));
    assert!(!error.contains("is off by"), "{error}");
    // A pulse between the nodes of a long step.
    let pulse = model(
        "pulse.ds",
        "u_i { x = 1 } F_i { -x + 3*exp(-((t-37.123)/1e-3)*((t-37.123)/1e-3))/(1e-3*1.7724538509055159) }",
    );
    let error = said(format!("solve --model {pulse} --method radau-adaptive --t-end 40"));
    assert!(error.contains("f changes in time faster than the steps"), "{error}");
}

/// v̇ = v² from 1 has a pole at t = 1, over which RK4 steps.
#[test]
fn what_is_said_after_the_rows_is_in_a_file_too() {
    let dir = directory("comments");
    let [model, rows] = ["pole.ds", "rows.csv"].map(|name| dir.join(name).display().to_string());
    fs::write(&model, "u_i { v = 1 }\nF_i { v * v }\n").expect("writable");
    let solve = |csv: &str| {
        let run = ["solve", "--model", &model, "--method", "rk4", "--h", "0.13", "--t-end", "1.1", "--csv", csv];
        let output = verify(&run);
        assert!(output.status.success(), "{}", stderr(&output));
        stdout(&output).to_owned()
    };
    let comments =
        |text: &str| text.lines().filter(|line| line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>();
    let shown = comments(&solve("-"));
    solve(&rows);
    assert!(!shown.is_empty());
    assert_eq!(comments(&fs::read_to_string(&rows).expect("written")), shown);
}
