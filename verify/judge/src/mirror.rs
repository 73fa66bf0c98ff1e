//! The search for the order of stages in which a method is its own adjoint.

/// Whether n stages have images, each another, that single ones `may` have and that `fits` for all pairs.
pub(super) fn has_mirror(
    n: usize,
    may: &dyn Fn(usize, usize) -> bool,
    fits: &dyn Fn([usize; 2], [usize; 2]) -> bool,
) -> bool {
    fn search(
        images: &mut Vec<usize>,
        n: usize,
        may: &dyn Fn(usize, usize) -> bool,
        fits: &dyn Fn([usize; 2], [usize; 2]) -> bool,
    ) -> bool {
        let i = images.len();
        i == n
            || (0..n).any(|image| {
                if images.contains(&image) || !may(i, image) {
                    return false;
                }
                images.push(image);
                let is_fit = (0..=i).all(|j| fits([i, j], [image, images[j]]) && fits([j, i], [images[j], image]));
                let found = is_fit && search(images, n, may, fits);
                images.pop();
                found
            })
    }
    search(&mut Vec::with_capacity(n), n, may, fits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_fit_all_pairs_both_ways() {
        let any = |_: usize, _: usize| true;
        let swapped = |[i, j]: [usize; 2], [m, n]: [usize; 2]| m == 1 - i && n == 1 - j;
        assert!(has_mirror(2, &any, &swapped));
        assert!(!has_mirror(2, &|i, m| i == m, &swapped));
        assert!(!has_mirror(2, &any, &|[i, j], _| i <= j) && !has_mirror(2, &any, &|[i, j], _| i >= j));
    }
}
