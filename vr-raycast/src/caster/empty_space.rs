//! Structures by which rays leap over empty space.

/// Structure by which rays find out where nothing is visible. On steps of one length, no choice changes a picture by a bit: those are
/// dropped in which nothing is visible.
///
/// It applies to `over`, `accumulate` and `first`. An average, a maximum or a minimum depends on what is transparent, too: these
/// sample everything, whatever is chosen.
///
/// Visible is a block of 8³ cells whose range of values holds anything that the transfer function, and the table made of it, do not
/// make perfectly clear (under `first`: that reaches the threshold). Each structure is made anew when the transfer function changes.
///
/// Steps that follow the medium ([`Step::Local`](super::Step::Local), [`Step::ErrorBound`](super::Step::ErrorBound)) leap by maps
/// of their own, and packets of rays by distances between small blocks: to them belongs `Auto`. A structure that is asked for by name goes with uniform steps alone, and is the plain engine's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EmptySpace {
    /// Structure that suits the engine that draws the scene; the plain engine uses [`EmptySpace::ExactCloud`].
    #[default]
    Auto,
    /// No structure: all steps are sampled.
    None,
    /// An octree of minima and maxima, from the root down.
    #[cfg(feature = "classics")]
    Octree,
    /// Nodes of the octree, folded into the blocks: each stores the level of the largest one around it that is all clear, or all visible.
    #[cfg(feature = "classics")]
    Pyramid,
    /// Balls: each block stores its exact Euclidean distance to the nearest block of the other kind.
    ///
    /// The fastest of all on sparse blobs, thin shells and a real scan; a fog loses nothing by it (`benches/leaping.rs`).
    ExactCloud,
    /// Cubes: each block stores its distance to the nearest block of the other kind as a king moves on a chessboard.
    #[cfg(feature = "classics")]
    ChessboardCloud,
    /// Up to eight boxes around the visible blocks.
    #[cfg(feature = "classics")]
    Boxes,
    /// One convex polyhedron of 26 faces around the visible blocks.
    #[cfg(feature = "classics")]
    Polyhedron,
}

impl EmptySpace {
    /// True if a structure is asked for by name.
    pub(crate) fn is_named(self) -> bool {
        !matches!(self, Self::Auto | Self::None)
    }
}
