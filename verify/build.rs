//! Records the compiler, the target, the commit and its date for the report's provenance.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output().ok().filter(|output| output.status.success());
    let version =
        version.map_or_else(|| "unknown".into(), |output| String::from_utf8_lossy(&output.stdout).into_owned());
    println!("cargo::rustc-env=VERIFY_RUSTC={}", version.trim());
    // The commit and its date, so that two builds of it say the same; SOURCE_DATE_EPOCH, in seconds, where it is set.
    println!("cargo::rerun-if-env-changed=SOURCE_DATE_EPOCH");
    println!("cargo::rerun-if-changed=../.git/HEAD");
    println!("cargo::rerun-if-changed=../.git/logs/HEAD");
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned()).filter(|text| !text.is_empty())
    };
    let unknown = || "unknown".to_owned();
    let dirty = git(&["status", "--porcelain", "--untracked-files=no"]).map_or("", |_| ", with changes");
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).map_or_else(unknown, |commit| commit + dirty);
    println!("cargo::rustc-env=VERIFY_COMMIT={commit}");
    let epoch = env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| seconds.trim().parse::<i64>().ok());
    let date = epoch.map(date).or_else(|| git(&["show", "--no-patch", "--format=%cs", "HEAD"])).unwrap_or_else(unknown);
    println!("cargo::rustc-env=VERIFY_DATE={date}");
    for (name, variable) in [("VERIFY_TARGET", "TARGET"), ("VERIFY_PROFILE", "PROFILE")] {
        println!("cargo::rustc-env={name}={}", env::var(variable).unwrap_or_else(|_| "unknown".into()));
    }
}

/// The day of a time in seconds since 1970, in the Gregorian calendar (days counted from 1 March of year 0, in cycles of 400
/// years).
fn date(seconds: i64) -> String {
    let days = seconds.div_euclid(86_400) + 719_468;
    let (cycle, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (day, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    format!("{:04}-{month:02}-{day:02}", cycle * 400 + year + i64::from(month <= 2))
}
