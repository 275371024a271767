//! Sixel: pictures in bands of six rows, in a palette of their own.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use color_quant::NeuQuant;

/// Largest number of colours that terminals agree on.
const COLORS: usize = 255;
/// Share of the pixels from which the palette is found: a tenth is as good, and quick.
const SAMPLING: i32 = 10;
/// Opacity from which on a pixel is drawn.
const MIN_ALPHA: u8 = 128;

/// Returns what a terminal is sent; pixels that are transparent are left as they are on the screen.
pub fn text([width, height]: [u32; 2], pixels: &[[u8; 4]]) -> String {
    let (palette, indices) = quantized(pixels);
    // Square pixels; what is not drawn keeps its colour.
    let mut text = format!("\u{1b}P0;1q\"1;1;{width};{height}");
    for (k, color) in palette.iter().enumerate() {
        let [r, g, b] = color.map(|c| (u32::from(c) * 100 + 127) / 255);
        let _ = write!(text, "#{k};2;{r};{g};{b}");
    }
    for band in indices.chunks(6 * width as usize) {
        // Each colour that there is in the band is drawn over the whole of it: six dots to a character, the topmost the lowest bit.
        let mut columns: BTreeMap<u8, Vec<u8>> = BTreeMap::new();
        for (i, index) in band.iter().enumerate() {
            if let Some(index) = index {
                let (x, row) = (i % width as usize, i / width as usize);
                columns.entry(*index).or_insert_with(|| vec![0; width as usize])[x] |= 1 << row;
            }
        }
        for (index, columns) in columns {
            let _ = write!(text, "#{index}");
            let used = columns.iter().rposition(|&dots| dots != 0).map_or(0, |last| last + 1);
            for run in columns[..used].chunk_by(|a, b| a == b) {
                let sign = char::from(b'?' + run[0]);
                match run.len() {
                    n @ 0..=3 => text.extend(std::iter::repeat_n(sign, n)),
                    n => write!(text, "!{n}{sign}").unwrap_or_default(),
                }
            }
            text.push('$');
        }
        text.push('-');
    }
    text + "\u{1b}\\\n"
}

/// Returns a palette and the place in it of each pixel that is drawn.
fn quantized(pixels: &[[u8; 4]]) -> (Vec<[u8; 3]>, Vec<Option<u8>>) {
    let drawn = |p: &[u8; 4]| p[3] >= MIN_ALPHA;
    let solid = || pixels.iter().filter(|p| drawn(p)).map(|&[r, g, b, _]| [r, g, b]);
    // Few colours are kept as they are.
    let exact: BTreeSet<[u8; 3]> = solid().collect();
    if exact.len() <= COLORS {
        let palette: Vec<[u8; 3]> = exact.into_iter().collect();
        let index = |p: &[u8; 4]| palette.binary_search(&[p[0], p[1], p[2]]).ok().map(|k| k as u8);
        let indices = pixels.iter().map(|p| index(p).filter(|_| drawn(p))).collect();
        return (palette, indices);
    }
    let network = NeuQuant::new(SAMPLING, COLORS, &solid().flat_map(|[r, g, b]| [r, g, b, 255]).collect::<Vec<_>>());
    let palette = network.color_map_rgb().chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    let index = |&[r, g, b, _]: &[u8; 4]| network.index_of(&[r, g, b, 255]) as u8;
    (palette, pixels.iter().map(|p| drawn(p).then(|| index(p))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_letter_by_letter() {
        let (red, none) = ([255, 0, 0, 255], [0; 4]);
        let pixels: Vec<[u8; 4]> = (0..7 * 5).map(|i| if i / 5 == 6 || i % 5 == 4 { red } else { none }).collect();
        let found = text([5, 7], &pixels);
        assert_eq!(found, "\u{1b}P0;1q\"1;1;5;7#0;2;100;0;0#0!4?~$-#0!5@$-\u{1b}\\\n");
    }

    #[test]
    fn many_colours_become_near_ones() {
        let pixels: Vec<[u8; 4]> = (0..64 * 64).map(|i| [(i % 64 * 4) as u8, (i / 64 * 4) as u8, 40, 255]).collect();
        let (palette, indices) = quantized(&pixels);
        assert!(palette.len() <= COLORS);
        let far = |(p, k): (&[u8; 4], &Option<u8>)| {
            let q = palette[k.unwrap() as usize];
            (0..3).map(|c| u32::from(p[c].abs_diff(q[c]))).max().unwrap()
        };
        let mean = pixels.iter().zip(&indices).map(far).sum::<u32>() as f64 / pixels.len() as f64;
        // 256 colours over 256 x 256 are 16 apart.
        assert!(mean < 16.0, "{mean}");
    }
}
