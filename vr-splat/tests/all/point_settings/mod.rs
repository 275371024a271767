//! Settings in which scattered points are drawn: tests of points go through all of them.

use vr_core::Classification;
use vr_splat::{Buffers, Splatter};

pub fn renderers() -> Vec<Splatter> {
    let base = Splatter { termination: 1.0, ..Splatter::default() };
    vec![
        base.clone(),
        Splatter { slice_spacing: 0.3, ..base.clone() },
        Splatter { classification: Classification::Pre, ..base.clone() },
        Splatter { buffers: Buffers::Samples, ..base.clone() },
        Splatter { low_pass: 1.0, ..base },
    ]
}
