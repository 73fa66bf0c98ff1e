//! Arguments, subcommands, exit statuses.

mod advise;
mod args;
mod bench;
mod compare;
mod error;
mod golden;
mod judge;
mod layout;
mod list;
mod order;
mod output;
mod report;
mod solve;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use error::Failure;
use output::Output;

/// Integrate, measure and verify: the methods of lsvi on the papers' problems
/// against exact solutions, CVODE and diffsol.
#[derive(Debug, Parser)]
#[command(version, verbatim_doc_comment, arg_required_else_help = true, max_term_width = 80, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  verify list problems
  verify solve --problem logistic --method method-i --h 0.1 --t-end 10
  verify order --problem van-der-pol --method bdf2
  verify judge rk4
  verify report

Exit status: 0 all is well, 1 a check or a computation failed, 2 bad usage, or
output that cannot be written.
For `order`, `compare`, `judge` and `report` that is: 0 what is claimed holds, 1
it is refuted, 2 bad input, 3 inconclusive. A program that does not start, or
writes another header, is bad input; one that fails in its runs leaves them
inconclusive. `advise` has 3 where no method is recommended.";

#[derive(Debug, Subcommand)]
enum Command {
    Report(report::Args),
    List(list::Args),
    Solve(solve::Args),
    Order(Box<order::Args>),
    Compare(compare::Args),
    Golden(golden::Args),
    Judge(judge::Args),
    Advise(advise::Args),
    Bench(bench::Args),
}

/// What became of a command that ran to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Status {
    /// All is well.
    Ok,
    /// A check failed.
    Failed,
    /// The data do not decide.
    Inconclusive,
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(match status {
            Status::Ok => 0,
            Status::Failed => 1,
            Status::Inconclusive => 3,
        })
    }
}

pub(crate) fn main() -> ExitCode {
    let cli = Cli::try_parse().unwrap_or_else(|error| misused(&error));
    // It takes a thread, whose instructions `bench` would count.
    if !matches!(cli.command, Command::Bench(_)) {
        args::clean_up_when_interrupted();
    }
    let mut out = Output::stdout();
    let result = match cli.command {
        Command::Report(args) => report::run(&args, &mut out),
        Command::List(args) => list::run(&args, &mut out),
        Command::Solve(args) => solve::run(&args, &mut out),
        Command::Order(args) => order::run(&args, &mut out),
        Command::Compare(args) => compare::run(&args, &mut out),
        Command::Golden(args) => golden::run(&args, &mut out),
        Command::Judge(args) => judge::run(&args, &mut out),
        Command::Advise(args) => advise::run(&args, &mut out),
        Command::Bench(args) => bench::run(&args, &mut out),
    };
    // What was printed until an error stands, and comes before the message.
    match out.flush().map_err(Failure::Output).and(result) {
        Ok(status) => status.into(),
        Err(failure) => {
            // Nobody can be told where standard error is closed too.
            let _ = layout::message(&mut io::stderr(), "error: ", &failure.to_string());
            if let Some(hint) = failure.hint() {
                let _ = layout::message(&mut io::stderr(), "hint: ", &hint);
            }
            ExitCode::from(failure.status())
        }
    }
}

/// Prints help, or what is wrong with the arguments, and ends.
fn misused(error: &clap::Error) -> ! {
    if is_broken(error) {
        let _ = layout::message(&mut io::stderr(), "", &error.render().to_string());
        std::process::exit(error.exit_code());
    }
    error.exit()
}

/// Whether a message is to be broken into lines of the terminal; help comes in such lines.
fn is_broken(error: &clap::Error) -> bool {
    let is_long = |line: &str| layout::width(line) > layout::columns();
    error.use_stderr() && error.render().to_string().lines().any(is_long)
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, is_broken, layout};

    /// A command that does not exist is named in a line of the message.
    #[test]
    fn messages_that_are_wider_than_the_terminal_are_broken_and_help_is_not() {
        let refused = |argument: &str| Cli::try_parse_from(["verify", argument]).expect_err("it is no command");
        let words = layout::width(refused("x").render().to_string().lines().next().expect("a line")) - 1;
        let of = |width: usize| is_broken(&refused(&"x".repeat(width - words)));
        assert_eq!([layout::columns(), layout::columns() + 1].map(of), [false, true]);
        let help =
            Cli::command().after_help("x".repeat(layout::columns() + 1)).try_get_matches_from(["verify", "--help"]);
        assert!(!is_broken(&help.expect_err("help ends")));
    }

    /// A longer line would be broken after 80 columns, and leave a word alone on the next.
    #[test]
    fn what_stands_below_the_options_is_in_lines_of_a_terminal() {
        let cli = Cli::command();
        for command in cli.get_subcommands().chain([&cli]) {
            let below = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in below.lines() {
                assert!(line.chars().count() <= 80, "{}: {line}", command.get_name());
            }
        }
    }
}
