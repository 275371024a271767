//! The settings as named options.

use vr_core::{Configurable, DeclaredOption, NumberRange, OptionTable};

use crate::texture_slicer::{Blend, DrawOrder, Format, Proxy, TextureSlicer};

/// The option that is refined.
pub(crate) const SLICE_DISTANCE: &str = "slice-distance";

impl Configurable for TextureSlicer {
    fn options() -> OptionTable<Self> {
        OptionTable::new(
            Self::NAME,
            [
                DeclaredOption::choice(
                    "proxy",
                    "slices: planes parallel to the image, shells about the eye, or stacks of the volume's own layers (2D textures)",
                    [("planes", Proxy::Planes), ("shells", Proxy::Shells), ("stacks", Proxy::Stacks)],
                    |r: &Self| r.proxy,
                    |r, proxy| r.proxy = proxy,
                ),
                DeclaredOption::number(
                    SLICE_DISTANCE,
                    "distance of slices in smallest voxel edges; of stacks in layers: one, or a whole part of one",
                    NumberRange::at_least(0.01).up_to(64.0),
                    |r| r.slice_spacing,
                    |r, x| r.slice_spacing = x,
                ),
                DeclaredOption::choice(
                    "format",
                    "content of textures: values, classified one by one (scalar, compressed) or as segments (pre-integrated), or light that was classified before",
                    [
                        ("scalar", Format::Scalar),
                        ("pre-integrated", Format::PreIntegrated),
                        ("compressed", Format::Compressed),
                        ("rgba", Format::Rgba),
                        ("luminance-alpha", Format::LuminanceAlpha),
                        ("paletted", Format::Paletted),
                    ],
                    |r: &Self| r.format,
                    |r, format| r.format = format,
                ),
                DeclaredOption::choice(
                    "blend",
                    "order in which fragments are blended under over; other operators are front-to-back alone",
                    [("front-to-back", Blend::FrontToBack), ("back-to-front", Blend::BackToFront)],
                    |r: &Self| r.blend,
                    |r, blend| r.blend = blend,
                ),
                DeclaredOption::choice(
                    "order",
                    "drawing order: all slices of a few pixels after the other, or a whole slice after the other, in triangles, as graphics cards do; same picture",
                    [("tiles", DrawOrder::Tiles), ("slices", DrawOrder::Slices)],
                    |r: &Self| r.order,
                    |r, order| r.order = order,
                ),
                DeclaredOption::switch(
                    "skip",
                    "leave out blocks in which nothing can be visible, or picked; same picture",
                    |r| r.skip_empty_space,
                    |r, on| r.skip_empty_space = on,
                ),
                DeclaredOption::<Self>::number(
                    "termination",
                    "opacity at which a pixel takes no more fragments, front to back; changes none by more than 1 - termination; 1: never",
                    NumberRange::above(0.0).up_to(1.0),
                    |r| r.termination,
                    |r, x| r.termination = x,
                )
                .refuse("back to front, no pixel can end early: must be absent", |r| {
                    r.sets_termination() && r.blend == Blend::BackToFront
                }),
                DeclaredOption::<Self>::switch(
                    "correction",
                    "correct opacities for how far apart slices are along a ray; off shows why",
                    |r| r.correction,
                    |r, on| r.correction = on,
                )
                .refuse("shells are equally far apart along every ray, and there is nothing to correct: must be absent", |r| {
                    !r.correction && r.proxy == Proxy::Shells
                }),
                DeclaredOption::number(
                    "brick",
                    "cells along the edge of a brick, each a texture of its own, made when first met; 0: the volume is one; same picture",
                    NumberRange::at_least(8.0).up_to(1024.0).whole().or_zero(),
                    |r| r.brick.map_or(0.0, f64::from),
                    |r, edge| r.brick = (edge != 0.0).then_some(edge as u32),
                ),
                DeclaredOption::number(
                    "budget",
                    "mebibytes that textures may take: bricks come and go within it, the least recently used first",
                    NumberRange::above(0.0).up_to(Self::MAX_BUDGET),
                    |r| r.budget,
                    |r, x| r.budget = x,
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
            TextureSlicer::default(),
            TextureSlicer::brute_force(),
            TextureSlicer { proxy: Proxy::Shells, slice_spacing: 0.3, ..TextureSlicer::default() },
            TextureSlicer {
                proxy: Proxy::Stacks,
                format: Format::PreIntegrated,
                correction: false,
                ..TextureSlicer::default()
            },
            TextureSlicer { blend: Blend::BackToFront, order: DrawOrder::Slices, ..TextureSlicer::default() },
            TextureSlicer { brick: Some(32), budget: 4.0, format: Format::Paletted, ..TextureSlicer::default() },
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
        for (key, value) in
            [("slice-distance", 0.005), ("termination", 0.0), ("budget", 0.0), ("brick", 7.0), ("brick", 9.5)]
        {
            let error = TextureSlicer::default().configure(&Options::new().with(key, value)).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
    }

    #[test]
    fn shells_without_correction_are_refused() {
        let shells = Options::new().with("proxy", "shells");
        assert!(TextureSlicer::default().configure(&shells).is_ok());
        let error = TextureSlicer::default().configure(&shells.with("correction", false)).unwrap_err().to_string();
        assert!(error.contains("correction") && error.contains("shells"), "{error}");
    }

    #[test]
    fn an_early_end_back_to_front_is_refused_where_it_is_set() {
        let ending = |at: f64| Options::new().with("blend", "back-to-front").with("termination", at);
        let error = TextureSlicer::default().configure(&ending(0.9)).unwrap_err().to_string();
        assert!(error.contains("termination") && error.contains("back to front"), "{error}");
        assert!(
            TextureSlicer { blend: Blend::BackToFront, termination: 0.9, ..TextureSlicer::default() }
                .validate()
                .is_err()
        );
        for fine in [0.9999, 1.0] {
            assert!(TextureSlicer::default().configure(&ending(fine)).is_ok());
        }
    }
}
