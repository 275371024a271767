//! The order of axes in which slices have a texture's texels, and where samples lie among these.

/// Axes of texture coordinates, and the slices on which samples lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Texture coordinate c is the index along axis `axes[c]` of the volume.
    pub(crate) axes: [usize; 3],
    /// Slices to a layer along the last axis, of a stack: samples are moved to the nearest. `None`: they stay where they are.
    pub(crate) per_layer: Option<u32>,
}

impl Layout {
    /// The volume's own axes, and samples anywhere.
    pub(crate) const VOLUME: Self = Self { axes: [0, 1, 2], per_layer: None };

    /// The layout of slices along an axis of the volume: that one last, so that a slice is contiguous.
    pub(crate) fn of_stack(axis: usize, per_layer: Option<u32>) -> Self {
        Self { axes: [[1, 2, 0], [0, 2, 1], [0, 1, 2]][axis], per_layer }
    }

    /// The layout of texels that lie along texture coordinates already.
    pub(crate) fn of_turned_texels(&self) -> Self {
        Self { axes: Self::VOLUME.axes, ..*self }
    }

    /// What is given along the volume's axes, along the texels'.
    pub(crate) fn turned<T: Copy>(&self, by_axis: [T; 3]) -> [T; 3] {
        self.axes.map(|a| by_axis[a])
    }

    /// What is given along the texels' axes, along the volume's.
    pub(crate) fn turned_back<T: Copy>(&self, by_coordinate: [T; 3]) -> [T; 3] {
        let mut by_axis = by_coordinate;
        self.axes.iter().zip(by_coordinate).for_each(|(&a, value)| by_axis[a] = value);
        by_axis
    }

    /// Largest distance by which a sample is moved along the last axis.
    pub(crate) fn largest_move(&self) -> f64 {
        self.per_layer.map_or(0.0, |n| 0.5 / f64::from(n))
    }

    /// A position along the last axis, moved as samples are.
    pub(crate) fn moved(&self, at: f64) -> f64 {
        self.per_layer.map_or(at, |n| (at * f64::from(n) + 0.5).floor() / f64::from(n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_turned_is_turned_back() {
        for axis in 0..3 {
            let layout = Layout::of_stack(axis, Some(2));
            assert_eq!(layout.turned([10, 11, 12]), layout.axes.map(|a| 10 + a));
            assert_eq!(layout.axes[2], axis);
            assert_eq!(layout.of_turned_texels().turned([10, 11, 12]), [10, 11, 12]);
            assert_eq!(layout.turned_back(layout.turned([10, 11, 12])), [10, 11, 12]);
            assert_eq!([layout.moved(3.2), layout.moved(3.3), layout.moved(-0.3)], [3.0, 3.5, -0.5]);
        }
        assert_eq!(Layout::VOLUME.moved(3.2), 3.2);
    }
}
