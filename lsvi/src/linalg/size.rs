//! Loops over few components, unrolled by the compiler.

/// Evaluates an expression with the constant N = n for an n of a list, 1 to 4 unless another is given, so that loops of this length are
/// unrolled, and with N = 0, or the one after `else`, for any other; [`size`] turns N back into n.
macro_rules! by_size {
    ([$($size:literal)*] $n:expr, $N:ident => $call:expr, else $other:expr) => {
        match $n {
            $($size => {
                const $N: usize = $size;
                $call
            })*
            _ => $other,
        }
    };
    ([$($size:literal)*] $n:expr, $N:ident => $call:expr) => {
        by_size!([$($size)*] $n, $N => $call, else {
            const $N: usize = 0;
            $call
        })
    };
    ($n:expr, $N:ident => $call:expr $(, else $other:expr)?) => {
        by_size!([1 2 3 4] $n, $N => $call $(, else $other)?)
    };
}

pub(crate) use by_size;

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
