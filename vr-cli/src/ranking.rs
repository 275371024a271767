//! Order of use of renderers and settings that were compared.

use std::cmp::Ordering;

use vr_core::{OptionError, Options, StudiedRenderer};
use vr_study::candidate::{self, Candidate};

/// RMSE up to which a picture is right for the eye: a quarter of a step of 8 bits.
pub const RMSE: f64 = 1e-3;

/// Key of the order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// True if the setting is the renderer's own default.
    pub is_default: bool,
    /// Error of its picture.
    pub rmse: f64,
    /// Seconds that a frame takes.
    pub seconds: f64,
}

impl Rank {
    /// True if the picture is right for the eye.
    pub fn is_within(&self) -> bool {
        self.rmse <= RMSE
    }

    /// Compares places: defaults before variants, pictures that are right before others; of the right ones the fastest first, of the others the least wrong.
    pub fn order(&self, other: &Self) -> Ordering {
        let class = |rank: &Self| (!rank.is_default, !rank.is_within());
        class(self).cmp(&class(other)).then_with(|| match self.is_within() {
            true => self.seconds.total_cmp(&other.seconds),
            false => self.rmse.total_cmp(&other.rmse),
        })
    }
}

/// Returns every renderer under every setting that it names, and under its default where that is none of them.
///
/// # Errors
/// A setting that the renderer itself does not take.
pub fn candidates(renderers: &[Box<dyn StudiedRenderer>]) -> Result<Vec<Candidate>, OptionError> {
    let mut all = candidate::candidates(renderers)?;
    for default in renderers {
        let name = default.name();
        if !all.iter().any(|c| c.renderer == name && is_default(c)) {
            let (renderer, setting, options) = (name.to_owned(), "default".to_owned(), Options::new());
            let configured = default.with_options(&options)?;
            all.push(Candidate { renderer, setting, options, order: None, error_floor: 0.0, configured });
        }
    }
    Ok(all)
}

/// True if a candidate is its renderer as it is without options.
pub fn is_default(candidate: &Candidate) -> bool {
    let specs = candidate.configured.option_specs();
    specs.iter().all(|spec| candidate.options.0.get(spec.key).is_none_or(|value| *value == spec.default))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::renderers;

    #[test]
    fn defaults_come_first_then_what_is_right_and_fast() {
        let rank = |is_default, rmse, seconds| Rank { is_default, rmse, seconds };
        let right = [
            rank(true, 1e-4, 1.0),
            rank(true, 1e-5, 2.0),
            rank(true, 1e-2, 0.1),
            rank(false, 1e-3, 0.2),
            rank(false, 1e-9, 0.3),
            rank(false, 2e-3, 0.2),
            rank(false, f64::NAN, 0.2),
        ];
        let mut found = right;
        found.reverse();
        found.sort_by(Rank::order);
        assert_eq!(format!("{found:?}"), format!("{right:?}"));
    }

    #[test]
    fn every_renderer_has_its_default_among_its_settings() {
        let all = candidates(&renderers::all()).unwrap();
        for renderer in renderers::all() {
            let defaults = all.iter().filter(|c| c.renderer == renderer.name() && is_default(c));
            assert_eq!(defaults.count(), 1, "{}", renderer.name());
        }
    }
}
