//! Runs of cells of about one width along an axis.

/// Cells of an axis that follow each other and are of about one width: all of one, or none more than twice as wide as another.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Number of the first cell.
    pub first: usize,
    /// Number of the cell behind the last one.
    pub end: usize,
    /// Mean width of the cells in world units.
    pub width: f64,
}

/// Largest number of cells in a segment: f32 tells places in it to 10⁻⁵ of a cell.
const MAX_CELLS: usize = 128;

/// Number of cells of one width from which on they are a segment by themselves: what reads it need look no width up.
const EVEN: usize = 8;

/// Largest ratio of the widths of two cells of a segment.
const RATIO: f64 = 2.0;

/// Largest difference of widths that are one, as a part of them: places may have been rounded.
const ONE_WIDTH: f64 = 1e-4;

impl Segment {
    /// Cuts the cells of an axis, between places that rise, into segments.
    pub(super) fn cut(places: &[f64]) -> Vec<Self> {
        let cells = places.len() - 1;
        let width = |cell: usize| places[cell + 1] - places[cell];
        let even_from = |first: usize, most: usize| {
            let is_same = |cell: &usize| (width(*cell) - width(first)).abs() <= ONE_WIDTH * width(first);
            (first..cells.min(first + most)).take_while(is_same).count()
        };
        let (mut segments, mut first) = (Vec::new(), 0);
        while first < cells {
            let even = even_from(first, MAX_CELLS);
            let mut end = first + even;
            if even < EVEN {
                let (mut least, mut most) = (width(first), width(first));
                end = first + 1;
                while end < cells.min(first + MAX_CELLS) && even_from(end, EVEN) < EVEN {
                    (least, most) = (least.min(width(end)), most.max(width(end)));
                    if most > RATIO * least {
                        break;
                    }
                    end += 1;
                }
            }
            let width = (places[end] - places[first]) / (end - first) as f64;
            segments.push(Self { first, end, width });
            first = end;
        }
        segments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(widths: &[f64]) -> Vec<[usize; 2]> {
        let mut places = vec![1.0];
        widths.iter().for_each(|w| places.push(places[places.len() - 1] + w));
        Segment::cut(&places).iter().map(|s| [s.first, s.end]).collect()
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
        assert_eq!(cut(&graded), [[0, 3], [3, 6], [6, 9], [9, 12]]);
        assert_eq!(cut(&[1.0, 1e6, 1.0]), [[0, 1], [1, 2], [2, 3]]);
    }
}
