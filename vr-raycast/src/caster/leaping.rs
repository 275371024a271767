//! How empty space is leapt over.

/// How rays find out where nothing is visible. On steps of one length, no choice changes a picture by a bit: those are dropped in which
/// nothing is visible.
///
/// It applies to `over`, `accumulate` and `first`. An average, a maximum or a minimum depends on what is transparent, too: these
/// sample everything, whatever is chosen.
///
/// Visible is a block of 8³ cells whose range of values holds anything that the transfer function, and the table made of it, do not
/// make perfectly clear (under `first`: that reaches the threshold). Each structure is made anew when the transfer function changes.
///
/// [`Step::Local`](super::Step::Local) leaps by its own map of smaller blocks: to it, all choices but `None` are the same, and
/// without leaping its steps lie elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leaping {
    /// All steps are sampled.
    None,
    /// An octree of minima and maxima, from the root down.
    Octree,
    /// The same nodes, each block storing the level of the largest one around it that is all clear, or all visible.
    Pyramid,
    /// Balls: each block stores its exact Euclidean distance to the nearest block of the other kind.
    ///
    /// The default: the fastest of all on sparse blobs, thin shells and a real scan; a fog loses nothing by it (`benches/leaping.rs`).
    #[default]
    ExactCloud,
    /// Cubes: each block stores its distance to the nearest block of the other kind as a king moves on a chessboard.
    ChessboardCloud,
    /// Up to eight boxes around the visible blocks.
    Boxes,
    /// One convex polyhedron of 26 faces around the visible blocks.
    Polyhedron,
}
