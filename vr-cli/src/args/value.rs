//! Parsers of values on the command line.

use std::str::FromStr;

use serde::de::value::{Error, StrDeserializer};
use serde::de::{DeserializeOwned, IntoDeserializer};

/// Parses a word that scene files know, too: its spelling, and the error message for a wrong one, come from there.
pub fn word<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let deserializer: StrDeserializer<'_, Error> = text.into_deserializer();
    T::deserialize(deserializer).map_err(|e| e.to_string())
}

/// Parses one number for red, green and blue, or three.
pub fn grey_or_rgb(text: &str) -> Result<[f64; 3], String> {
    match text.parse() {
        Ok(grey) => Ok([grey; 3]),
        Err(_) => triple(text).map_err(|_| "expected a number, or R,G,B".to_owned()),
    }
}

/// Parses a size: `512x256`; `512` is `512x512`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let expected = "expected WIDTHxHEIGHT or one number, as in 512x256";
    let side = |side: &str| side.parse().map_err(|_| expected.to_owned());
    match text.split_once('x') {
        Some((w, h)) => Ok([side(w)?, side(h)?]),
        None => side(text).map(|n| [n, n]),
    }
}

/// Parses three numbers of voxels: `256x256x128`.
pub fn dims(text: &str) -> Result<[usize; 3], String> {
    list(text, 'x').map_err(|_| "expected NXxNYxNZ, as in 256x256x128".to_owned())
}

/// Parses three numbers: `1,0.5,-2`.
pub fn triple<T: FromStr>(text: &str) -> Result<[T; 3], String> {
    list(text, ',').map_err(|_| "expected three numbers, as in 1,0.5,2".to_owned())
}

/// Parses two numbers: `0,255`.
pub fn pair(text: &str) -> Result<[f64; 2], String> {
    list(text, ',').map_err(|_| "expected two numbers, as in 0,255".to_owned())
}

/// Parses two corners of a box: `0,0,0,10,10,10`.
pub fn corners(text: &str) -> Result<[[f64; 3]; 2], String> {
    let n: [f64; 6] = list(text, ',').map_err(|_| "expected the lower and the upper corner: six numbers".to_owned())?;
    Ok([[n[0], n[1], n[2]], [n[3], n[4], n[5]]])
}

/// Parses normal and offset of a plane: `0,0,1,64`.
pub fn plane(text: &str) -> Result<([f64; 3], f64), String> {
    let n: [f64; 4] = list(text, ',').map_err(|_| "expected normal and offset: four numbers".to_owned())?;
    Ok(([n[0], n[1], n[2]], n[3]))
}

/// Parses a control point: `120,1,0.9,0.8,0.4`.
pub fn point(text: &str) -> Result<[f64; 5], String> {
    list(text, ',').map_err(|_| "expected value, red, green, blue and opacity: five numbers".to_owned())
}

/// Parses a vector towards a light and its colour, white if there is none: `1,0,2` or `1,0,2,1,0.9,0.8`.
pub fn light(text: &str) -> Result<([f64; 3], [f64; 3]), String> {
    if let Ok(direction) = list(text, ',') {
        return Ok((direction, [1.0; 3]));
    }
    let n: [f64; 6] = list(text, ',').map_err(|_| {
        "expected the vector towards the light, or that and the light's linear RGB: three numbers or six".to_owned()
    })?;
    Ok(([n[0], n[1], n[2]], [n[3], n[4], n[5]]))
}

/// Parses degrees, at most a turn either way.
pub fn angle(text: &str) -> Result<f64, String> {
    let degrees = text.trim().parse().map_err(|_| "expected a number of degrees".to_owned())?;
    if (-360.0..=360.0).contains(&degrees) { Ok(degrees) } else { Err("must be from -360 to 360 degrees".to_owned()) }
}

/// Parses the size of an error: a number that is not below 0.
pub fn tolerance(text: &str) -> Result<f64, String> {
    let tolerance: f64 = text.trim().parse().map_err(|_| "expected a number".to_owned())?;
    if tolerance >= 0.0 { Ok(tolerance) } else { Err("must not be below 0".to_owned()) }
}

/// Parses `key=value`.
pub fn key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    Ok((key.to_owned(), value.to_owned()))
}

/// Parses any number of numbers with a separator between them.
pub fn numbers<T: FromStr>(text: &str, separator: char) -> Result<Vec<T>, T::Err> {
    text.split(separator).map(|n| n.trim().parse()).collect()
}

fn list<T: FromStr, const N: usize>(text: &str, separator: char) -> Result<[T; N], ()> {
    numbers(text, separator).map_err(|_| ())?.try_into().map_err(|_| ())
}

#[cfg(test)]
mod tests {
    use vr_core::Filter;

    use super::*;

    #[test]
    fn reads_what_it_prints_and_says_what_it_expects() {
        assert_eq!(size("512x256"), Ok([512, 256]));
        assert_eq!(size("64"), Ok([64, 64]));
        assert!(size("ax3").is_err() && size("-1x3").is_err());
        assert_eq!(dims("1x2x3"), Ok([1, 2, 3]));
        assert_eq!(triple("-1, 0.5,2"), Ok([-1.0, 0.5, 2.0]));
        assert!(triple::<f64>("1,2").is_err());
        assert_eq!(corners("0,0,0,1,2,3"), Ok([[0.0; 3], [1.0, 2.0, 3.0]]));
        assert_eq!(light("1,2,3"), Ok(([1.0, 2.0, 3.0], [1.0; 3])));
        assert_eq!(light("1,2,3,0.5,0,1"), Ok(([1.0, 2.0, 3.0], [0.5, 0.0, 1.0])));
        assert!(light("1,2,3,4").unwrap_err().contains("three numbers or six"));
        assert_eq!(plane("0,0,1,64"), Ok(([0.0, 0.0, 1.0], 64.0)));
        assert_eq!((angle("-7.5"), angle("360")), (Ok(-7.5), Ok(360.0)));
        assert!(angle("nan").is_err() && angle("360.5").is_err() && angle("-inf").is_err() && angle("x").is_err());
        assert_eq!((tolerance("0"), tolerance("1e-3")), (Ok(0.0), Ok(1e-3)));
        assert!(tolerance("-1").is_err() && tolerance("nan").is_err() && tolerance("x").is_err());
        assert_eq!(word::<Filter>("catmull-rom"), Ok(Filter::CatmullRom));
        assert!(word::<Filter>("linear").unwrap_err().contains("`trilinear`"));
    }
}
