//! The command line of the verification.
fn main() {}
