//! Loops over few components, unrolled by the compiler.

/// Evaluates an expression with the constant N = n for a small n, so that loops of this length are unrolled, and with N = 0, or
/// the one after `else`, for any other; [`size`] turns N back into n.
macro_rules! by_size {
    ($n:expr, $N:ident => $call:expr) => {
        by_size!($n, $N => $call, else {
            const $N: usize = 0;
            $call
        })
    };
    ($n:expr, $N:ident => $call:expr, else $other:expr) => {
        match $n {
            1 => {
                const $N: usize = 1;
                $call
            }
            2 => {
                const $N: usize = 2;
                $call
            }
            3 => {
                const $N: usize = 3;
                $call
            }
            4 => {
                const $N: usize = 4;
                $call
            }
            _ => $other,
        }
    };
}

/// The same up to 8, of what is short to compile.
macro_rules! by_size_up_to_eight {
    ($n:expr, $N:ident => $call:expr) => {
        match $n {
            5 => {
                const $N: usize = 5;
                $call
            }
            6 => {
                const $N: usize = 6;
                $call
            }
            7 => {
                const $N: usize = 7;
                $call
            }
            8 => {
                const $N: usize = 8;
                $call
            }
            n => by_size!(n, $N => $call),
        }
    };
}

pub(crate) use {by_size, by_size_up_to_eight};

/// N, or `n` where that is 0.
#[inline(always)]
pub(crate) const fn size<const N: usize>(n: usize) -> usize {
    if N == 0 { n } else { N }
}

/// Cuts the K vectors of `n` components each that are stored one after the other; with one check for all of them, and in loops of
/// constant length the compiler knows that they are apart.
#[inline(always)]
pub(crate) fn vectors<const K: usize>(stored: &mut [f64], n: usize) -> [&mut [f64]; K] {
    let mut rest = &mut stored[..K * n];
    std::array::from_fn(|_| {
        let (vector, others) = std::mem::take(&mut rest).split_at_mut(n);
        rest = others;
        vector
    })
}
