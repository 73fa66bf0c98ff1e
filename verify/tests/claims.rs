//! The claims are complete, and their verdicts are the recorded ones.

use verify::claims;

#[test]
fn show() {
    for (claim, finding) in claims::judge(&|| {}) {
        match finding {
            Ok(f) => {
                println!(
                    "{} {} — {}\n   {}\n   W: {:?}\n   M: {:?}",
                    claim.id,
                    f.verdict().word(),
                    claim.statement,
                    f.evidence,
                    f.where_it_holds,
                    f.mechanism
                );
                for c in f.cases() {
                    if !c.holds() {
                        println!("      FAILS {c:?}");
                    }
                }
            }
            Err(e) => println!("{} ERROR {e}", claim.id),
        }
    }
}
