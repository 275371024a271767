use glam::{DMat3, DVec2, DVec3};
use vr_core::{Camera, Clip, Placement, Plane, Rays, View};
use vr_kernels::vector::{Chords, LANES};

use super::ProxyGeometry;
use crate::fragments::Setup;
use crate::geometry::polygon_spans;
use crate::slices::Slices;
use crate::texture_slicer::{Proxy, TextureSlicer};

const SIZE: [u32; 2] = [48, 32];

/// Comparison of the rasterised pixels with the fragments that rays have, over all slabs of a view.
#[derive(Debug, Default)]
struct Fit {
    fragments: u32,
    /// Rasterised, and discarded.
    discarded: u32,
    /// Rasterised more than once.
    twice: u32,
    /// Fragments that have less than half of their slab: the slice in its middle meets few of these rays.
    beside: u32,
    quads: u32,
}

fn fit(proxy: Proxy, view: &View) -> Fit {
    let axes = DMat3::from_cols(DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.0, 0.9, 0.2), DVec3::new(-0.2, 0.0, 1.2));
    let placement = Placement::new(DVec3::new(-5.0, -4.0, -6.0), axes).expect("no singular matrix");
    let dims = [12, 10, 11];
    let renderer = TextureSlicer { proxy, slice_spacing: 1.0, ..TextureSlicer::default() };
    let slices = Slices::new(&renderer, view, &placement, dims, false).expect("a camera");
    let rays = Rays::new(view).expect("a camera");
    let setup = Setup {
        rays: &rays,
        placement: &placement,
        dims,
        clip: &view.clip,
        slices: &slices,
        axes: [0, 1, 2],
        on_faces: false,
    };
    let geometry = ProxyGeometry::new(view, &setup).expect("a camera");
    let mut fit = Fit::default();
    for slab in geometry.slabs() {
        let polygons = geometry.polygons(slab, DVec2::ZERO);
        fit.quads += polygons.iter().filter(|p| p.corners.len() == 4).count() as u32;
        let mut covered = vec![0; (SIZE[0] * SIZE[1]) as usize];
        for span in polygons.iter().flat_map(|p| polygon_spans(p, SIZE)) {
            (span.begin..span.end).for_each(|x| covered[(span.y * SIZE[0] + x) as usize] += 1);
        }
        for (i, times) in covered.into_iter().enumerate() {
            let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|c| [f64::from(c) + 0.5; LANES]);
            let chords = Chords::new(&rays, [&x, &y], &placement, dims, &view.clip, &[f64::INFINITY; LANES]);
            let slabs = setup.slabs(&chords, 0);
            let falling = slices.fall_along(chords.direction.map(|a| a[0]));
            let has = chords.start[0] < chords.end[0] && falling == slab.falling;
            let is_fragment = has && (slabs.first..=slabs.last).contains(&slab.number);
            assert!(!is_fragment || times > 0, "{proxy:?}: {slab:?} at {x:?}, {y:?} is left out");
            fit.fragments += u32::from(is_fragment);
            fit.discarded += u32::from(!is_fragment && times > 0);
            fit.twice += u32::from(times > 1);
            let [begin, end] = if is_fragment { slabs.part(slab.number) } else { [0.0; 2] };
            fit.beside += u32::from(is_fragment && (end - begin) * slabs.slope < 0.5);
        }
    }
    fit
}

#[test]
fn fragments_are_rasterised_and_little_else() {
    let bounds = (DVec3::new(-8.0, -4.0, -6.0), DVec3::new(6.0, 6.0, 8.0));
    let cut = Plane { normal: DVec3::new(2.0, 1.0, -0.7), offset: -3.0 };
    let clip = Clip { planes: vec![cut], crop: Some((DVec3::splat(-5.0), DVec3::new(4.0, 7.0, 4.5))) };
    for (azimuth, elevation, fov) in [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(40.0))] {
        for clip in [Clip::default(), clip.clone()] {
            let whole = clip == Clip::default();
            let view = View { clip, ..View::new(Camera::framing(bounds, azimuth, elevation, fov), SIZE) };
            for proxy in [Proxy::Planes, Proxy::Stacks] {
                let fit = fit(proxy, &view);
                println!("{proxy:?} {azimuth} {fov:?}, clipped: {}: {fit:?}", !whole);
                assert!(fit.fragments > 500, "{fit:?}");
                // A sixty-fourth of a pixel along outlines.
                assert!(fit.discarded < fit.fragments / 40, "{fit:?}");
                assert!(fit.twice < fit.fragments / 100, "{fit:?}");
                // At least a twentieth of the fragments would be missing if the slices alone were rasterised.
                assert!(fit.beside > fit.fragments / 20, "{fit:?}");
                // Every layer of a stack is a quad.
                assert!(proxy == Proxy::Planes || !whole || fit.quads >= 10, "{fit:?}");
            }
        }
    }
}
