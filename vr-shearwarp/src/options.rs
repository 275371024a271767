//! The settings as named options.

use vr_core::{Classification, Configurable, DeclaredOption, NumberRange, OptionTable};

use crate::shear_warp::{EmptySpace, ShearWarp};
use crate::warp::WarpFilter;

/// The option that is refined.
pub(crate) const TEXEL: &str = "texel";

impl Configurable for ShearWarp {
    fn options() -> OptionTable<Self> {
        OptionTable::new(
            Self::NAME,
            [
                DeclaredOption::choice(
                    "classification",
                    "classify interpolated values, or voxels, whose colours are then interpolated (the classic way)",
                    [("values", Classification::Post), ("voxels", Classification::Pre)],
                    |r: &Self| r.classification,
                    |r, classification| r.classification = classification,
                ),
                DeclaredOption::<Self>::number(
                    "slice-distance",
                    "texels from slice to slice along the principal axis; slices one voxel apart are the layers of voxels",
                    NumberRange::above(0.0),
                    |r| r.slice_distance,
                    |r, x| r.slice_distance = x,
                )
                .refuse("must put slices 0.01 to 1 voxel apart: it is in texels", |r| {
                    !(0.01..=1.0).contains(&r.slice_spacing())
                }),
                DeclaredOption::number(
                    TEXEL,
                    "voxels to a texel of the intermediate image along either side",
                    NumberRange::at_least(0.03).up_to(1.0),
                    |r| r.texel,
                    |r, x| r.texel = x,
                ),
                DeclaredOption::choice(
                    "warp",
                    "how the intermediate image is resampled onto the screen",
                    [("bilinear", WarpFilter::Bilinear), ("cubic", WarpFilter::Cubic)],
                    |r: &Self| r.warp,
                    |r, warp| r.warp = warp,
                ),
                DeclaredOption::choice(
                    "encoding",
                    "how visible parts are found: run-length encoded voxels, or blocks of an octree, which a new transfer function needs no time for",
                    [("runs", EmptySpace::Runs), ("octree", EmptySpace::Octree)],
                    |r: &Self| r.empty_space,
                    |r, empty_space| r.empty_space = empty_space,
                ),
                DeclaredOption::number(
                    "termination",
                    "opacity from which on a texel takes no more; changes none by more than 1 - termination",
                    NumberRange::above(0.0).up_to(1.0),
                    |r| r.termination,
                    |r, x| r.termination = x,
                ),
                DeclaredOption::number(
                    "opacity-threshold",
                    "opacity of a voxel's thickness up to which values are left out, where nothing around is more opaque",
                    NumberRange::at_least(0.0).below(1.0),
                    |r| r.opacity_threshold,
                    |r, x| r.opacity_threshold = x,
                ),
                DeclaredOption::switch(
                    "correction",
                    "correct opacities for how far apart slices are along a ray; off shows why",
                    |r| r.correction,
                    |r, on| r.correction = on,
                ),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use vr_core::Options;

    use super::*;

    #[test]
    fn every_renderer_survives_the_way_through_options() {
        let all = [
            ShearWarp::default(),
            ShearWarp::classic(),
            ShearWarp { slice_distance: 0.3, texel: 0.4, warp: WarpFilter::Cubic, ..ShearWarp::default() },
            ShearWarp { empty_space: EmptySpace::Octree, opacity_threshold: 0.05, ..ShearWarp::default() },
            ShearWarp { correction: false, termination: 1.0, slice_distance: 1.0 / 64.0, ..ShearWarp::default() },
        ];
        for from in &all {
            for to in &all {
                assert_eq!(from.configure(&to.to_options()).unwrap(), *to);
                assert!(to.validate().is_ok());
            }
            assert_eq!(from.configure(&Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (key, value) in [("texel", 0.02), ("termination", 0.0), ("slice-distance", 16.0)] {
            let error = ShearWarp::default().configure(&Options::new().with(key, value)).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
    }
}
