//! The command line of the verification.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
