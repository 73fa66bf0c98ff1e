//! Variational time integrators.
