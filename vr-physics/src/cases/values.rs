//! Cases whose difficulty lies in the transfer function.

use vr_core::{Scene, View};

use super::{bump, float_volume, oblique, transfer};

/// A ramp seen obliquely: clear, then translucent up to α = 0.9, then opaque from 0.6 on, its colour changing with depth inside
/// the wall, so that only the colour at the entry is right.
pub(super) fn opaque_wall() -> (Scene, View) {
    let volume = float_volume([9; 3], [1.0; 3], |x, y, z| (x + y + z) as f32 / 24.0);
    let points = [
        (0.1, [0.0; 3], 0.0),
        (0.4, [0.2, 0.4, 1.0], 0.3),
        (0.6, [0.9, 0.5, 0.1], 0.9),
        (0.6, [1.0, 0.2, 0.1], 1.0),
        (1.0, [0.0, 1.0, 0.5], 1.0),
    ];
    let view = oblique(&volume, 24);
    (Scene::new(volume, transfer(&points, 1.0)), view)
}

/// A smooth bump under a spike 0.004 wide, where neighbouring voxels differ by up to 0.2.
pub(super) fn thin_shell() -> (Scene, View) {
    let volume = bump(17);
    let points = [(0.498, [1.0, 0.7, 0.3], 0.0), (0.5, [1.0, 0.7, 0.3], 0.999), (0.502, [1.0, 0.7, 0.3], 0.0)];
    let view = oblique(&volume, 32);
    (Scene::new(volume, transfer(&points, 1.0)), view)
}
