//! Runs of cells of about one width along an axis.

/// Cells of an axis that follow each other and are of about one width: all of one, or none more than twice as wide as another.
///
/// Cuts between segments do not depend on the direction in which an axis is read.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Number of the first cell.
    pub first: usize,
    /// Number of the cell behind the last one.
    pub end: usize,
    /// Mean width, in world units, of these cells and of those like them beside them.
    pub width: f64,
}

/// Largest number of cells in a segment: f32 tells places in it to 10⁻⁵ of a cell.
const MAX_CELLS: usize = 128;

/// Number of cells of one width from which on they are a segment by themselves: what reads it need look no width up.
const EVEN: usize = 8;

/// Largest difference of widths that are one, as a part of them: places may have been rounded.
const ONE_WIDTH: f64 = 1e-4;

impl Segment {
    /// Cuts the cells of an axis, between places that rise, into segments.
    pub(super) fn cut(places: &[f64]) -> Vec<Self> {
        let cells = places.len() - 1;
        let mean = (places[cells] - places[0]) / cells as f64;
        let widths: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // Number of cells of one width around each.
        let is_one = |a: &f64, b: &f64| (a - b).abs() <= ONE_WIDTH * a.max(*b);
        let runs: Vec<usize> =
            widths.chunk_by(is_one).flat_map(|run| std::iter::repeat_n(run.len(), run.len())).collect();
        let octave = |width: f64| libm::log2(width / mean).round();
        let mut segments = Vec::new();
        let mut first = 0;
        for end in 1..=cells {
            let is_cut = end == cells || {
                let [a, b] = [end - 1, end];
                let is_even = runs[a].max(runs[b]) >= EVEN && !is_one(&widths[a], &widths[b]);
                is_even || octave(widths[a]) != octave(widths[b])
            };
            if is_cut {
                let width = (places[end] - places[first]) / (end - first) as f64;
                let parts = (first..end).step_by(MAX_CELLS);
                segments.extend(parts.map(|first| Self { first, end: end.min(first + MAX_CELLS), width }));
                first = end;
            }
        }
        segments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends of segments of cells of these widths, which are the same from the other side.
    fn cut(widths: &[f64]) -> Vec<[usize; 2]> {
        let of = |widths: &mut dyn Iterator<Item = &f64>| {
            let mut places = vec![1.0];
            widths.for_each(|w| places.push(places[places.len() - 1] + w));
            Segment::cut(&places)
        };
        let (there, back) = (of(&mut widths.iter()), of(&mut widths.iter().rev()));
        let width_at = |segments: &[Segment], cell: usize| {
            segments.iter().find(|s| s.first <= cell && cell < s.end).map(|s| s.width).unwrap()
        };
        for cell in 0..widths.len() {
            let [a, b] = [width_at(&there, cell), width_at(&back, widths.len() - 1 - cell)];
            assert!((a - b).abs() < 1e-9 * a, "{cell}: {a} and {b}");
        }
        there.iter().map(|s| [s.first, s.end]).collect()
    }

    #[test]
    fn cells_of_one_width_stay_together() {
        let mut widths = vec![1.0; 10];
        widths.extend([0.9, 0.8, 0.6]);
        widths.extend(vec![0.5; 9]);
        assert_eq!(cut(&widths), [[0, 10], [10, 13], [13, 22]]);
        assert_eq!(cut(&[1.0; 300]), [[0, 128], [128, 256], [256, 300]]);
        // Rounded to f32.
        let rounded: Vec<f64> = (0..40).map(|k| f64::from(0.1 * k as f32)).collect();
        assert_eq!(Segment::cut(&rounded).len(), 1);
    }

    #[test]
    fn graded_cells_are_cut_where_they_have_doubled() {
        let graded: Vec<f64> = (0..12).map(|k| 1.3f64.powi(k)).collect();
        let segments = cut(&graded);
        assert!((4..=6).contains(&segments.len()), "{segments:?}");
        assert!(segments.iter().all(|[first, end]| graded[end - 1] <= 2.0 * graded[*first]));
        assert_eq!(cut(&[1.0, 1e6, 1.0]), [[0, 1], [1, 2], [2, 3]]);
    }
}
