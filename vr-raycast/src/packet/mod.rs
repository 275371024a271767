//! The vector engine: packets of sixteen rays, one a lane, on whatever vectors the machine has.
//!
//! A packet is set up in f64 ([`setup`]) and marched in f32, each ray at its own pace: in steps of one length, over what is clear by whole
//! steps of its lattice ([`march`]), or in steps of the length that each place asks for ([`local`]); in [`segments`] of either kind where a rule integrates over
//! all values of a step; or in steps [`listed`] for each ray, where a field jumps. Which of the first two, how long steps are, and whether every
//! pixel has its ray, a [`trial`] chooses for each large picture. A ray does not see its company: no bit of it depends on which others are in the packet. Nor does any on the instructions ([`level`]): nothing is fused, and logarithm and
//! exponential are our own ([`vr_kernels::vector`]).
//!
//! # What it took
//! * What is not inlined loses its instructions in silence. `array::map` with a closure over vectors was not, and with it AVX-512 ran at
//!   3.4 times the plain engine's speed; with plain lines in its place, at 4.9 times (fog 256³, u8; each ratio from one run).
//! * Each x-pair of samples is one load, staged through memory ([`vr_kernels::vector::Stage`]). A wide load from narrow stores has to wait until those have
//!   left the store buffer. So two steps are taken at once: while the first waits, the samples of the second are fetched. A frame
//!   of fog256 (30.7 million samples) went from 221 to 169 ms of CPU time by this and by table look-ups without a branch a lane.
//! * Table rows go from their load into registers, and are transposed there ([`vr_kernels::vector::Rows`]): staged as voxels are, they were slower than with
//!   SSE2 alone.
//! * Each instance of a kernel costs seconds to compile. There are three levels, not the library's five, and what is done once a packet
//!   (set-up, the depth of a half) or only in some scenes (shading) are functions of their own.
//!
//! * Where rays go through nothing, set-up and leaping are what costs. So the outermost visible blocks are projected once a view: packets in
//!   front of none are not set up, and the others begin where the nearest one does. With that, and blocks of 4³ cells in the place of 8³, a
//!   frame of mni, opaque, at a step of one voxel went from 24 to 14 ms.
//! * Half of the samples of opaque scenes lay in clear cells of visible blocks. Such blocks have a bit for each cell
//!   ([`ClearSpace`](crate::leap::ClearSpace)).
//!
//! # What was measured and not taken
//! In a kernel of its own, without what a renderer adds (u8, 256³ and 512³, AVX-512; ratios from one run):
//! * Runs of sixteen samples along one ray: 0.85 and 0.95 times as fast as packets of sixteen rays.
//! * Bricks of 9³ samples, which share a layer: 1.05 and 1.28 times as fast (f32: 1.04 and 1.38), for 42 % more memory. Rows of padded length gain
//!   0 to 9 %.
//!
//! And in the engine: tables of 1024 entries instead of 4096, 1 %; rays that leap until all of a packet, or three quarters, see something,
//! instead of half: 0.95. Lanes that take a ray of the tile as soon as theirs has ended: 0.83 to 1.05, for neighbours that begin together share cache lines.

#[cfg(test)]
mod compared;
mod course;
mod engine;
mod fields;
mod gaps;
mod labels;
pub(crate) mod leap;
pub(crate) mod level;
mod listed;
mod local;
mod march;
#[cfg(feature = "classics")]
mod nodes;
mod patches;
mod picks;
mod points;
#[cfg(test)]
mod random_scenes;
mod ray_end;
mod segments;
mod setup;
mod shading;
mod trace;
mod trial;

pub(crate) use engine::{PacketEngine, PacketFrame};
pub(crate) use labels::{LabelEngine, LabelFrame};
pub(crate) use patches::{PatchEngine, PatchFrame, PatchPickEngine, PatchPickFrame};
pub(crate) use picks::{PickEngine, PickFrame};
pub(crate) use points::{PointEngine, PointFrame, PointPickEngine, PointPickFrame};
pub(crate) use setup::FrameSetup;
pub(crate) use trial::{Choice, Trial};
