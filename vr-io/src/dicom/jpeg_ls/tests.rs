//! Tests of frames that CharLS wrote.

use super::super::coded_samples::{numbers, picture, shape, survive};
use super::decode;
use crate::scalar::ScalarType::{I16, U8, U16};

macro_rules! sample {
    ($name:literal) => {
        include_bytes!(concat!("../coded_samples/", $name)).as_slice()
    };
}

/// Frames with bits and samples, and the error that they may have.
fn samples() -> [(&'static [u8], u32, usize, u32); 8] {
    [
        (sample!("grey8_near0.jls"), 8, 1, 0),
        (sample!("grey12_near0.jls"), 12, 1, 0),
        (sample!("grey16_near0.jls"), 16, 1, 0),
        (sample!("grey12_near3.jls"), 12, 1, 3),
        (sample!("rgb_planes_near0.jls"), 8, 3, 0),
        (sample!("rgb_lines_near0.jls"), 8, 3, 0),
        (sample!("rgb_pixels_near0.jls"), 8, 3, 0),
        (sample!("rgb_pixels_near2.jls"), 8, 3, 2),
    ]
}

#[test]
fn frames_are_exact_or_as_near_as_they_say() {
    for (i, (coded, bits, samples, near)) in samples().into_iter().enumerate() {
        let scalar = if bits == 8 { U8 } else { U16 };
        let decoded = numbers(&decode(coded, &shape(bits, samples, scalar)).unwrap(), scalar);
        let wanted = picture(bits, samples);
        assert_eq!(decoded.len(), wanted.len());
        let worst = decoded.iter().zip(&wanted).map(|(a, b)| a.abs_diff(*b)).max();
        assert_eq!(worst, Some(near), "{i}");
    }
}

#[test]
fn the_header_says_which_numbers_are_negative() {
    // The code knows none: its 12 bits are those of the numbers.
    let signed = numbers(&decode(sample!("grey12_near0.jls"), &shape(12, 1, I16)).unwrap(), I16);
    let wanted = picture(12, 1).into_iter().map(|x| if x < 2048 { x } else { x - 4096 });
    assert!(signed.into_iter().eq(wanted));
}

/// A frame with a segment before its scan.
fn with_segment(coded: &[u8], marker: u8, content: &[u8]) -> Vec<u8> {
    let scan = coded.windows(2).position(|pair| pair == [0xff, 0xda]).unwrap();
    let length = (content.len() as u16 + 2).to_be_bytes();
    [&coded[..scan], &[0xff, marker], &length, content, &coded[scan..]].concat()
}

#[test]
fn segments_before_a_scan() {
    let (coded, shape) = (sample!("grey12_near0.jls"), shape(12, 1, U16));
    let plain = decode(coded, &shape).unwrap();
    // The defaults of 12 bits in words, or as zeros, and a comment.
    let preset = [4095u16, 18, 67, 276, 64].map(u16::to_be_bytes).concat();
    for content in [[&[1], preset.as_slice()].concat(), [1; 1].into_iter().chain([0; 10]).collect()] {
        assert_eq!(decode(&with_segment(coded, 0xf8, &content), &shape).unwrap(), plain);
    }
    assert_eq!(decode(&with_segment(coded, 0xfe, b"a comment"), &shape).unwrap(), plain);
    let refused =
        |marker, content: &[u8]| decode(&with_segment(coded, marker, content), &shape).unwrap_err().to_string();
    assert!(refused(0xf8, &[2, 1, 1]).contains("mapping tables"));
    assert!(refused(0xdd, &[0, 3]).contains("restart intervals"));
    assert!(refused(0xe8, b"mrfx\x01").contains("transformed (mrfx)"));
    let thresholds = [4095u16, 67, 18, 276, 64].map(u16::to_be_bytes).concat();
    assert!(refused(0xf8, &[&[1], thresholds.as_slice()].concat()).contains("thresholds [67, 18, 276]"));
}

#[test]
fn damage_is_noticed_or_survived() {
    for (coded, bits, samples, _) in samples() {
        survive(coded, &shape(bits, samples, if bits == 8 { U8 } else { U16 }), decode);
    }
    let (coded, shape) = (sample!("grey8_near0.jls"), shape(8, 1, U8));
    // The end of the image and the zeros before it are not missed.
    for cut in 0..coded.len() - 6 {
        assert!(decode(&coded[..cut], &shape).is_err(), "{cut}");
    }
    let mut taller = shape;
    taller.rows += 1;
    assert!(decode(coded, &taller).unwrap_err().to_string().contains("24x17 pixels, not 24x18"));
    // A header of 65,535 lines with hardly a byte for them.
    let mut tall = coded[..40].to_vec();
    tall[7..9].copy_from_slice(&[0xff, 0xff]);
    taller.rows = 0xffff;
    assert!(decode(&tall, &taller).unwrap_err().to_string().contains("40 bytes for 65535 lines"));
}
