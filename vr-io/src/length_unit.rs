//! Units of length, as files name them.

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LengthUnit {
    /// The usual symbol: `mm`, `µm`, …
    pub symbol: &'static str,
    pub metres: f64,
}

pub(crate) const MILLIMETRE: LengthUnit = LengthUnit { symbol: "mm", metres: 1e-3 };
/// The unit that OME-XML means where it names none.
pub(crate) const MICROMETRE: LengthUnit = LengthUnit { symbol: "µm", metres: 1e-6 };

/// Symbol, metres, and the other names: those of OME-XML, OME-Zarr (UDUNITS-2) and ImageJ.
const UNITS: [(&str, f64, &[&str]); 9] = [
    ("pm", 1e-12, &["picometer", "picometre"]),
    ("Å", 1e-10, &["angstrom", "\u{212b}"]),
    ("nm", 1e-9, &["nanometer", "nanometre"]),
    // Micro sign, and the Greek letter.
    ("µm", 1e-6, &["micrometer", "micrometre", "micron", "microns", "um", "\u{3bc}m"]),
    ("mm", 1e-3, &["millimeter", "millimetre"]),
    ("cm", 1e-2, &["centimeter", "centimetre"]),
    ("m", 1.0, &["meter", "metre"]),
    ("km", 1e3, &["kilometer", "kilometre"]),
    ("in", 2.54e-2, &["inch", "inches"]),
];

impl LengthUnit {
    /// The unit of a symbol or a name; `None` where it is no length (`pixel`) or not known here.
    pub fn from_name(name: &str) -> Option<Self> {
        let name = name.trim();
        UNITS
            .iter()
            .find(|(symbol, _, names)| *symbol == name || names.iter().any(|n| n.eq_ignore_ascii_case(name)))
            .map(|&(symbol, metres, _)| Self { symbol, metres })
    }
}

/// Unit of three lengths, each in a unit of its own, and the factors that bring them to it: the first one's. `None` where they have none in common.
pub(crate) fn common(names: [Option<&str>; 3]) -> Option<(String, [f64; 3])> {
    if let [Some(a), Some(b), Some(c)] = names {
        if a == b && b == c {
            return Some((LengthUnit::from_name(a).map_or_else(|| a.to_owned(), |u| u.symbol.to_owned()), [1.0; 3]));
        }
        let units = [LengthUnit::from_name(a)?, LengthUnit::from_name(b)?, LengthUnit::from_name(c)?];
        // A quotient of two powers of ten, without the digits that a product with 1e-6 leaves.
        return Some((units[0].symbol.to_owned(), units.map(|u| (u.metres / units[0].metres * 1e12).round() / 1e12)));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_three_formats_mean_one_unit() {
        for name in ["µm", "um", "micron", "micrometer", "\u{3bc}m"] {
            assert_eq!(LengthUnit::from_name(name), Some(MICROMETRE), "{name}");
        }
        assert_eq!(LengthUnit::from_name("pixel"), None);
        assert_eq!(LengthUnit::from_name("mm"), Some(MILLIMETRE));
    }

    #[test]
    fn different_units_are_brought_to_the_first() {
        assert_eq!(common([Some("mm"), Some("mm"), Some("µm")]), Some(("mm".into(), [1.0, 1.0, 0.001])));
        assert_eq!(common([Some("nm"), Some("nm"), Some("µm")]), Some(("nm".into(), [1.0, 1.0, 1000.0])));
        assert_eq!(common([Some("furlong"); 3]), Some(("furlong".into(), [1.0; 3])));
        assert_eq!(common([Some("mm"), None, Some("mm")]), None);
        assert_eq!(common([Some("mm"), Some("pixel"), Some("mm")]), None);
    }
}
