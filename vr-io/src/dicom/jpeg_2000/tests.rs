//! Tests of frames that OpenJPEG wrote.

use super::super::coded_samples::{COLUMNS, ROWS, numbers, picture, shape, survive};
use super::decode;
use super::header::Header;
use crate::scalar::ScalarType::{I16, U8, U16};

macro_rules! sample {
    ($name:literal) => {
        include_bytes!(concat!("../coded_samples/", $name)).as_slice()
    };
}

/// Frames without loss, with bits and samples: plain, signed, with and without a transform of colours, in tiles of 11 by 7.
fn samples() -> [(&'static [u8], u32, usize); 6] {
    [
        (sample!("grey8.j2k"), 8, 1),
        (sample!("grey12.j2k"), 12, 1),
        (sample!("grey16.j2k"), 16, 1),
        (sample!("rgb.j2k"), 8, 3),
        (sample!("rgb_rct.j2k"), 8, 3),
        (sample!("rgb_tiles.j2k"), 8, 3),
    ]
}

#[test]
fn frames_without_loss_are_exact() {
    for (i, (coded, bits, samples)) in samples().into_iter().enumerate() {
        let scalar = if bits == 8 { U8 } else { U16 };
        let decoded = decode(coded, &shape(bits, samples, scalar)).unwrap();
        assert_eq!(numbers(&decoded, scalar), picture(bits, samples), "{i}");
    }
    for (coded, bits) in [(sample!("signed12.j2k"), 12), (sample!("signed16.j2k"), 16)] {
        let decoded = numbers(&decode(coded, &shape(bits, 1, I16)).unwrap(), I16);
        assert!(decoded.into_iter().eq(picture(bits, 1).into_iter().map(|x| x - (1 << (bits - 1)))));
    }
}

#[test]
fn loss_is_that_of_openjpeg() {
    let decoded = numbers(&decode(sample!("grey12_loss.j2k"), &shape(12, 1, U16)).unwrap(), U16);
    let theirs = numbers(sample!("grey12_loss.u16"), U16);
    assert_eq!(decoded.len(), theirs.len());
    // Both round sums in f32 of other order: by one where they lie near a half.
    let worst = decoded.iter().zip(&theirs).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(1), "{worst:?}");
    assert_ne!(decoded, picture(12, 1));
}

#[test]
fn a_code_stream_lies_in_a_file_too() {
    let (coded, shape) = (sample!("grey8.j2k"), shape(8, 1, U8));
    let length = (coded.len() as u32 + 8).to_be_bytes();
    let signature = b"\0\0\0\x0cjP  \r\n\x87\n\0\0\0\x0aftypxx";
    let file = [signature, length.as_slice(), b"jp2c", coded].concat();
    assert_eq!(decode(&file, &shape).unwrap(), decode(coded, &shape).unwrap());
    assert!(decode(&file[..60], &shape).unwrap_err().to_string().contains("no code stream"));
}

#[test]
fn damage_is_noticed_or_survived() {
    for (coded, bits, samples) in samples() {
        survive(coded, &shape(bits, samples, if bits == 8 { U8 } else { U16 }), decode);
    }
    let (coded, shape) = (sample!("grey8.j2k"), shape(8, 1, U8));
    for cut in 0..coded.len() {
        assert!(decode(&coded[..cut], &shape).is_err(), "{cut}");
    }
}

#[test]
fn claims_beyond_the_bytes_are_refused() {
    let coded = sample!("grey8.j2k");
    let refused = |at: usize, bytes: &[u8]| {
        let mut code = coded.to_vec();
        code[at..at + bytes.len()].copy_from_slice(bytes);
        Header::read(&code).unwrap_err().to_string()
    };
    assert_eq!((Header::read(coded).unwrap().frame.columns, Header::read(coded).unwrap().frame.rows), (COLUMNS, ROWS));
    // Columns and rows of 65,535, tiles of one pixel, other sizes for components.
    assert!(refused(8, &[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]).contains("for 65535x65535 pixels"));
    assert!(refused(8, &[0xff; 8]).contains("for 4294967295x4294967295 pixels"));
    assert!(refused(24, &[0, 0, 0, 1, 0, 0, 0, 1]).contains("in 408 tiles"));
    assert!(refused(43, &[2]).contains("sizes (SIZ)"));
    // Blocks of 4 by 4 in 65,535 layers: of a picture of 2048², whose room is granted.
    let style = coded.windows(2).position(|pair| pair == [0xff, 0x52]).unwrap();
    let mut code = coded.to_vec();
    code[8..16].copy_from_slice(&[0, 0, 8, 0, 0, 0, 8, 0]);
    code[24..32].copy_from_slice(&[0, 0, 8, 0, 0, 0, 8, 0]);
    assert!(Header::read(&code).is_ok());
    code[style + 6..style + 8].copy_from_slice(&[0xff, 0xff]);
    code[style + 10..style + 12].copy_from_slice(&[0, 0]);
    assert!(Header::read(&code).unwrap_err().to_string().contains("blocks in 65535 layers"));
}
