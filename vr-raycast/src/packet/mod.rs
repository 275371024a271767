//! The vector engine: packets of sixteen rays, one a lane, on whatever vectors the machine has.
//!
//! A packet is set up in f64 ([`setup`]) and marched in f32, each ray at its own pace: in steps of one length, over what is clear by whole
//! steps of its lattice ([`march`]), or in steps of the length that each place asks for ([`local`]). A ray does not see its company: no bit
//! of it depends on which others are in the packet. Nor does any on the instructions ([`level`]): nothing is fused, and logarithm and
//! exponential are our own ([`elementary`]).
//!
//! # What it took
//! * What is not inlined loses its instructions in silence. `array::map` with a closure over vectors was not, and with it AVX-512 ran at
//!   3.4 times the plain engine's speed; with plain lines in its place, at 4.9 times (fog 256³, u8; each ratio from one run).
//! * Each x-pair of samples is one load, staged through memory ([`field`]). A wide load from narrow stores has to wait until those have
//!   left the store buffer. So two steps are taken at once: while the first waits, the samples of the second are fetched. A frame
//!   of fog256 (30.7 million samples) went from 221 to 169 ms of CPU time by this and by table look-ups without a branch a lane.
//! * Table rows go from their load into registers, and are transposed there ([`table`]): staged as voxels are, they were slower than with
//!   SSE2 alone.
//! * Each instance of a kernel costs seconds to compile. There are three levels, not the library's five, and what is done once a packet
//!   (set-up, the depth of a half) or only in some scenes (shading) are functions of their own.
//!
//! # What it comes to
//! CPU milliseconds a frame, 512×512, one thread, on a machine that others used (`vr bench --set vector=..`, Xeon with AVX-512; each line in
//! one run), at a step of one voxel:
//!
//! | scene | samples (M) | plain | packets | |
//! |---|--:|--:|--:|--:|
//! | fog256 translucent | 30.7 | 865 | 188 | 4.6 times |
//! | blobs256 translucent | 3.8 | 229 | 46.9 | 4.9 times |
//! | mni opaque | 1.4 | 153 | 26.5 | 5.8 times |
//! | mni opaque, shaded | 1.4 | 475 | 39.8 | 11.9 times |
//!
//! # What was not tried
//! Runs of samples along one ray instead of packets; bricked volumes; a table without interpolation; blocks of 4³ and 16³ cells for
//! whole steps (8³ was taken for what others report). Rules that pre-integrate, gradients of the filter itself, and opacity that follows
//! the gradient are left to the plain engine.

mod elementary;
mod engine;
mod field;
mod lanes;
mod leap;
mod level;
mod local;
mod march;
mod setup;
mod shade;
mod sums;
mod table;

pub(crate) use engine::{PacketEngine, PacketFrame};
pub(crate) use shade::PacketShading;
