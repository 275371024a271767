//! The settings as named options, both ways.

use std::sync::LazyLock;

use vr_core::{OptionError, OptionKind, OptionSpec, OptionValue, Options, meaning_of, word_of};

use crate::tex_slice::{Blend, Format, Order, Proxy, TexSlice};

const PROXIES: &[(&str, Proxy)] = &[("planes", Proxy::Planes), ("shells", Proxy::Shells), ("stacks", Proxy::Stacks)];
const FORMATS: &[(&str, Format)] = &[
    ("scalar", Format::Scalar),
    ("pre-integrated", Format::PreIntegrated),
    ("compressed", Format::Compressed),
    ("rgba", Format::Rgba),
    ("luminance-alpha", Format::LuminanceAlpha),
    ("paletted", Format::Paletted),
];
const BLENDS: &[(&str, Blend)] = &[("front-to-back", Blend::FrontToBack), ("back-to-front", Blend::BackToFront)];
const ORDERS: &[(&str, Order)] = &[("tiles", Order::Tiles), ("slices", Order::Slices)];
/// Every option, with the default renderer's values.
pub(crate) static SPECS: LazyLock<Vec<OptionSpec>> = LazyLock::new(|| {
    let defaults = to_options(&TexSlice::default());
    let spec = |key, kind, help| OptionSpec { key, kind, default: defaults.0[key].clone(), help };
    vec![
        spec(
            "proxy",
            OptionKind::Choice(&["planes", "shells", "stacks"]),
            "what slices are: planes parallel to the image, shells about the eye, or the volume's own layers (2D textures)",
        ),
        spec(
            "slice-distance",
            OptionKind::Number { above: 0.0, most: 64.0 },
            "from slice to slice, in smallest voxel edges, at least 0.01; of stacks in layers, one or a whole part of one",
        ),
        spec(
            "format",
            OptionKind::Choice(&["scalar", "pre-integrated", "compressed", "rgba", "luminance-alpha", "paletted"]),
            "what textures hold: values (classified one by one or as segments, or compressed), or light classified before",
        ),
        spec(
            "blend",
            OptionKind::Choice(&["front-to-back", "back-to-front"]),
            "the order in which fragments are blended under over; nothing else can be back to front",
        ),
        spec(
            "order",
            OptionKind::Choice(&["tiles", "slices"]),
            "all slices of a few pixels after the other, or a whole slice after the other, as graphics cards do",
        ),
        spec("skip", OptionKind::Switch, "blocks in which nothing can be visible are left out"),
        spec(
            "termination",
            OptionKind::Number { above: 0.0, most: 1.0 },
            "opacity at which a pixel takes no more fragments, front to back; changes none by more than 1 - termination; 1: never",
        ),
        spec(
            "correction",
            OptionKind::Switch,
            "opacities corrected for how far apart slices are along a ray; off shows why",
        ),
        spec(
            "brick",
            OptionKind::Number { above: -f64::MIN_POSITIVE, most: 1024.0 },
            "cells along the edge of a brick, each a texture of its own, at least 8; 0: the volume is one",
        ),
        spec(
            "budget",
            OptionKind::Number { above: 0.0, most: TexSlice::MOST_BUDGET },
            "mebibytes that textures may take: bricks come and go within it",
        ),
    ]
});

/// All options that say what this renderer is.
pub(crate) fn to_options(renderer: &TexSlice) -> Options {
    Options::new()
        .with("proxy", word_of(PROXIES, renderer.proxy))
        .with("slice-distance", renderer.slice_distance)
        .with("format", word_of(FORMATS, renderer.format))
        .with("blend", word_of(BLENDS, renderer.blend))
        .with("order", word_of(ORDERS, renderer.order))
        .with("skip", renderer.skip)
        .with("termination", renderer.termination)
        .with("correction", renderer.correction)
        .with("brick", renderer.brick.map_or(0.0, f64::from))
        .with("budget", renderer.budget)
}

/// A renderer with options set.
pub(crate) fn configure(renderer: &TexSlice, options: &Options) -> Result<TexSlice, OptionError> {
    let refuse = |key: &str, found: f64, allowed: &str| OptionError::Value {
        renderer: TexSlice::NAME,
        key: key.to_owned(),
        found: found.to_string(),
        allowed: allowed.to_owned(),
    };
    let mut new = renderer.clone();
    for (key, value) in options.check(TexSlice::NAME, &SPECS)? {
        match (key, value) {
            ("proxy", OptionValue::Word(w)) => new.proxy = meaning_of(PROXIES, w),
            ("slice-distance", &OptionValue::Number(distance)) => {
                if distance < 0.01 {
                    return Err(refuse(key, distance, "must be 0.01 to 64"));
                }
                new.slice_distance = distance;
            }
            ("format", OptionValue::Word(w)) => new.format = meaning_of(FORMATS, w),
            ("blend", OptionValue::Word(w)) => new.blend = meaning_of(BLENDS, w),
            ("order", OptionValue::Word(w)) => new.order = meaning_of(ORDERS, w),
            ("skip", &OptionValue::Switch(on)) => new.skip = on,
            ("termination", &OptionValue::Number(x)) => new.termination = x,
            ("correction", &OptionValue::Switch(on)) => new.correction = on,
            ("brick", &OptionValue::Number(edge)) => {
                if edge != 0.0 && (edge < 8.0 || edge.fract() != 0.0) {
                    return Err(refuse(key, edge, "must be 0, or a whole number from 8 to 1024"));
                }
                new.brick = (edge != 0.0).then_some(edge as u32);
            }
            ("budget", &OptionValue::Number(x)) => new.budget = x,
            _ => unreachable!("checked against the list"),
        }
    }
    if let Some((key, found, allowed)) = new.idle_option() {
        return Err(refuse(key, found, allowed));
    }
    Ok(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_renderer_survives_the_way_through_options() {
        let all = [
            TexSlice::default(),
            TexSlice::brute_force(),
            TexSlice { proxy: Proxy::Shells, slice_distance: 0.3, ..TexSlice::default() },
            TexSlice { proxy: Proxy::Stacks, format: Format::PreIntegrated, correction: false, ..TexSlice::default() },
            TexSlice { blend: Blend::BackToFront, order: Order::Slices, ..TexSlice::default() },
            TexSlice { brick: Some(32), budget: 4.0, format: Format::Paletted, ..TexSlice::default() },
        ];
        for from in &all {
            for to in &all {
                assert_eq!(configure(from, &to_options(to)).unwrap(), *to);
                assert!(to.validate().is_ok());
            }
            assert_eq!(configure(from, &Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (key, value) in
            [("slice-distance", 0.005), ("termination", 0.0), ("budget", 0.0), ("brick", 7.0), ("brick", 9.5)]
        {
            let error = configure(&TexSlice::default(), &Options::new().with(key, value)).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
    }

    #[test]
    fn an_early_end_back_to_front_is_refused_where_it_is_set() {
        let ending = |at: f64| Options::new().with("blend", "back-to-front").with("termination", at);
        let error = configure(&TexSlice::default(), &ending(0.9)).unwrap_err().to_string();
        assert!(error.contains("termination") && error.contains("back to front"), "{error}");
        assert!(TexSlice { blend: Blend::BackToFront, termination: 0.9, ..TexSlice::default() }.validate().is_err());
        for fine in [0.9999, 1.0] {
            assert!(configure(&TexSlice::default(), &ending(fine)).is_ok());
        }
    }
}
