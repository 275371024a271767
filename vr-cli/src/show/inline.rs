//! PNGs within the text of a terminal.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Largest number of characters of a piece that kitty takes.
const PIECE: usize = 4096;

/// Returns what kitty is sent (its graphics protocol): the PNG in pieces, scaled to so many columns if any are given.
pub fn kitty(png: &[u8], columns: Option<u32>) -> String {
    let coded = STANDARD.encode(png);
    let columns = columns.map(|n| format!(",c={n}")).unwrap_or_default();
    let pieces: Vec<&[u8]> = coded.as_bytes().chunks(PIECE).collect();
    let mut text = String::new();
    for (k, piece) in pieces.iter().enumerate() {
        // Transmit and display a PNG; the answers of the terminal would be typed at the prompt.
        let first = if k == 0 { format!("a=T,f=100,q=2{columns},") } else { String::new() };
        let more = u8::from(k + 1 < pieces.len());
        text += &format!("\u{1b}_G{first}m={more};{}\u{1b}\\", String::from_utf8_lossy(piece));
    }
    text + "\n"
}

/// Returns what iTerm2 is sent (its inline images): the PNG, scaled to so many columns if any are given.
pub fn iterm(png: &[u8], columns: Option<u32>) -> String {
    let width = columns.map_or_else(|| "auto".to_owned(), |n| n.to_string());
    let options = format!("inline=1;size={};width={width};preserveAspectRatio=1", png.len());
    format!("\u{1b}]1337;File={options}:{}\u{7}\n", STANDARD.encode(png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_make_up_the_file() {
        let png: Vec<u8> = (0..10_000u32).map(|i| (i * 7) as u8).collect();
        let text = kitty(&png, Some(80));
        assert!(text.starts_with("\u{1b}_Ga=T,f=100,q=2,c=80,m=1;"));
        let pieces: Vec<(&str, &str)> = text.split("\u{1b}_G").skip(1).map(|p| p.split_once(';').unwrap()).collect();
        assert!(pieces.iter().all(|p| p.1.trim_end().trim_end_matches("\u{1b}\\").len() <= PIECE));
        assert!(pieces.last().unwrap().0 == "m=0");
        let coded: String = pieces.iter().map(|p| p.1.trim_end().trim_end_matches("\u{1b}\\")).collect();
        assert_eq!(STANDARD.decode(coded).unwrap(), png);
        assert!(iterm(&png, None).contains("size=10000;width=auto;"));
    }
}
