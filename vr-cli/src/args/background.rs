//! Background on the command line.

use std::str::FromStr;

use vr_core::transfer::srgb_to_linear;

use super::value;

/// Background of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// Nothing: the picture keeps its opacity.
    Transparent,
    /// Linear RGB.
    Color([f32; 3]),
}

impl Background {
    /// Returns the colour; `None` where the picture is transparent.
    pub fn color(self) -> Option<[f32; 3]> {
        match self {
            Self::Transparent => None,
            Self::Color(color) => Some(color),
        }
    }
}

impl FromStr for Background {
    type Err = String;

    /// Parses `transparent`, `black`, `white`, `grey` (the middle of a screen's scale), `#RRGGBB` as web pages have it, or linear `R,G,B`.
    fn from_str(text: &str) -> Result<Self, String> {
        let shown = |bytes: [u8; 3]| Self::Color(bytes.map(|c| srgb_to_linear(f64::from(c) / 255.0) as f32));
        match text {
            "transparent" => return Ok(Self::Transparent),
            "black" => return Ok(shown([0; 3])),
            "white" => return Ok(shown([255; 3])),
            "grey" | "gray" => return Ok(shown([128; 3])),
            _ => {}
        }
        let expected = "expected transparent, black, white, grey, #RRGGBB, or three linear numbers, as in 0.1,0.1,0.1";
        if let Some(digits) = text.strip_prefix('#') {
            let is_hex = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
            let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_hex).ok_or(expected)?;
            let [_, r, g, b] = number.to_be_bytes();
            return Ok(shown([r, g, b]));
        }
        value::triple(text).map(Self::Color).map_err(|_| expected.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backgrounds_by_name_code_and_number() {
        let color = |text: &str| text.parse::<Background>().unwrap().color();
        assert_eq!(color("transparent"), None);
        assert_eq!(
            (color("white"), color("#FFffFF"), color("0.5,0,1")),
            (Some([1.0; 3]), Some([1.0; 3]), Some([0.5, 0.0, 1.0]))
        );
        assert_eq!(color("grey"), color("#808080"));
        for wrong in ["blue", "#12345", "#+12345", "#é1234", "1,2", ""] {
            assert!(wrong.parse::<Background>().unwrap_err().contains("#RRGGBB"), "{wrong}");
        }
    }
}
