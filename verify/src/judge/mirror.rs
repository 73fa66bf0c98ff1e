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
