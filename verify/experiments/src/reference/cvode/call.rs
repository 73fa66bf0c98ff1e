//! What a call into SUNDIALS answers.

use std::ffi::c_int;

use super::ffi::name;

/// Who answered, and so what its codes mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Speaker {
    /// CVODE itself: `CV_…`.
    Solver,
    /// Its interface to linear solvers: `CVLS_…`.
    LinearSolver,
    /// What SUNDIALS' solvers share.
    Library,
}

/// A call that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum CallError {
    /// It returned a null pointer.
    #[error("{0} failed")]
    Null(&'static str),
    /// It returned a negative code, of the library any but zero.
    #[error("{call} returned {}", name(*.speaker, *.code))]
    Code {
        /// The call.
        call: &'static str,
        /// Whose code it is.
        speaker: Speaker,
        /// The code.
        code: c_int,
    },
}

impl Speaker {
    /// Turns a code into an error. Positive ones of CVODE, such as "stop time reached", are no failures.
    pub(super) fn check(self, call: &'static str, code: c_int) -> Result<(), CallError> {
        let failed = if self == Self::Solver { code < 0 } else { code != 0 };
        if failed { Err(CallError::Code { call, speaker: self, code }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_the_names_of_those_who_return_them() {
        let text = |speaker: Speaker, code| speaker.check("F", code).map_err(|error| error.to_string());
        assert_eq!(text(Speaker::Solver, -3), Err("F returned CV_ERR_FAILURE".into()));
        assert_eq!(text(Speaker::LinearSolver, -3), Err("F returned CVLS_ILL_INPUT".into()));
        assert_eq!(text(Speaker::Library, -3), Err("F returned -3".into()));
        assert_eq!(text(Speaker::Library, 1), Err("F returned 1".into()));
        assert_eq!([text(Speaker::Solver, 1), text(Speaker::LinearSolver, 0)], [Ok(()), Ok(())]);
        assert_eq!(CallError::Null("F").to_string(), "F failed");
    }
}
