//! A part of the numbers of a box: what is left without ghost cells.

/// Takes the numbers of the box of `dims` from `first` on out of a whole of `whole` places with `components` numbers each.
///
/// Panics if the whole does not hold the box: a bug in the caller.
pub(super) fn crop(
    numbers: &[f64],
    whole: [usize; 3],
    first: [usize; 3],
    dims: [usize; 3],
    components: usize,
) -> Vec<f64> {
    let [nx, ny, _] = whole;
    let rows = (0..dims[2]).flat_map(|z| (0..dims[1]).map(move |y| (y, z)));
    let row = |(y, z): (usize, usize)| {
        let begin = components * (first[0] + nx * (first[1] + y + ny * (first[2] + z)));
        &numbers[begin..begin + components * dims[0]]
    };
    rows.flat_map(row).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_box() {
        let numbers: Vec<f64> = (0..4 * 3 * 3 * 2).map(f64::from).collect();
        let tuple = |x: usize, y: usize, z: usize| 2 * (x + 4 * (y + 3 * z));
        let expected: Vec<f64> = [(1, 1), (2, 1), (1, 2), (2, 2)]
            .iter()
            .flat_map(|&(x, y)| [tuple(x, y, 1), tuple(x, y, 1) + 1])
            .map(|i| i as f64)
            .collect();
        assert_eq!(crop(&numbers, [4, 3, 3], [1, 1, 1], [2, 2, 1], 2), expected);
        assert_eq!(crop(&numbers, [4, 3, 3], [0; 3], [4, 3, 3], 2), numbers);
    }
}
