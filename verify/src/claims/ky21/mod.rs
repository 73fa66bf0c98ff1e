//! The claims of \[KY21\].

use super::Claim;

/// In the order of the paper.
pub(super) const ALL: &[&[Claim]] = &[];
