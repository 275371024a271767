//! The Differential Data Stream, which packs PVM files: Stefan Röttger's V³ volume renderer, 2000s, formats `v3d` and `v3e`.
//!
//! A stream of bits, the highest of each byte first: 2 bits of `skip` − 1, 16 bits of `strip` − 1, then runs until one of length 0: 7 bits of
//! length, 3 bits that name a width (0, or 2 to 8 bits), and as many numbers of that width, half the range subtracted from each. A byte is
//! the one before it plus that number; from byte `strip` + 1 on, plus the step that the bytes made one strip before. At last the bytes are
//! interleaved: the stream holds every `skip`-th byte from the first one on, then from the second one on, and so forth, over the whole
//! (`v3d`) or over blocks of `skip` · 2²⁴ bytes (`v3e`).

use std::io::{self, Read};

/// Lengths of the two magic words.
const MAGIC: usize = 8;

/// True if a file begins as such a stream does.
pub(super) fn is_dds(head: &[u8]) -> bool {
    head.starts_with(b"DDS v3d\n") || head.starts_with(b"DDS v3e\n")
}

/// The bytes behind a stream.
pub(super) struct Dds<R> {
    bits: Bits<R>,
    /// Bytes of an interleaved group; 1 if the stream has the bytes in their order.
    pub skip: usize,
    strip: usize,
    /// Length of each interleaved plane of a block, if there are blocks.
    block: Option<usize>,
    /// Numbers left in the run, and their width.
    run: (u32, u32),
    /// Bytes so far, as the stream has them.
    bytes: Vec<u8>,
    ended: bool,
}

impl<R: Read> Dds<R> {
    /// Reads the magic word and what tells the coding.
    pub fn new(mut stream: R) -> io::Result<Self> {
        let mut magic = [0; MAGIC];
        stream.read_exact(&mut magic)?;
        let mut bits = Bits::new(stream);
        let cut = || io::Error::from(io::ErrorKind::UnexpectedEof);
        let skip = bits.read(2)?.ok_or_else(cut)? as usize + 1;
        let strip = bits.read(16)?.ok_or_else(cut)? as usize + 1;
        let block = (magic[6] == b'e').then_some(1 << 24);
        Ok(Self { bits, skip, strip, block, run: (0, 0), bytes: Vec::new(), ended: false })
    }

    /// Decodes until there are `count` bytes, or the stream ends: whole, or cut off, which only the header of a volume can tell.
    pub fn decode(&mut self, count: usize) -> io::Result<&[u8]> {
        while self.bytes.len() < count && !self.ended {
            if self.run.0 == 0 {
                self.next_run()?;
                continue;
            }
            let Some(number) = self.bits.read(self.run.1)? else {
                self.ended = true;
                break;
            };
            self.run.0 -= 1;
            // All sums are taken modulo 256, as the coder does.
            let step = (number as u8).wrapping_sub((1u32 << self.run.1 >> 1) as u8);
            let at = self.bytes.len();
            let before = self.bytes.last().copied().unwrap_or(0);
            let expected = if self.strip == 1 || at <= self.strip {
                before
            } else {
                let above = self.bytes[at - self.strip].wrapping_sub(self.bytes[at - self.strip - 1]);
                before.wrapping_add(above)
            };
            self.bytes.push(expected.wrapping_add(step));
        }
        Ok(&self.bytes)
    }

    fn next_run(&mut self) -> io::Result<()> {
        let length = self.bits.read(7)?.unwrap_or(0);
        if length == 0 {
            self.ended = true;
            return Ok(());
        }
        match self.bits.read(3)? {
            Some(0) => self.run = (length, 0),
            Some(code) => self.run = (length, code + 1),
            None => self.ended = true,
        }
        Ok(())
    }

    /// All bytes, in their order.
    pub fn into_bytes(mut self) -> io::Result<Vec<u8>> {
        self.decode(usize::MAX)?;
        Ok(if self.skip == 1 { self.bytes } else { interleaved(&self.bytes, self.skip, self.block) })
    }
}

/// The bytes of which `planes` holds every `skip`-th one from the first one on, then from the second one on, and so forth.
fn interleaved(planes: &[u8], skip: usize, block: Option<usize>) -> Vec<u8> {
    let mut out = vec![0; planes.len()];
    let length = block.map_or(planes.len(), |b| b * skip).max(1);
    for (from, to) in planes.chunks(length).zip(out.chunks_mut(length)) {
        let mut bytes = from.iter();
        for first in 0..skip {
            for (place, &byte) in to.iter_mut().skip(first).step_by(skip).zip(&mut bytes) {
                *place = byte;
            }
        }
    }
    out
}

/// Bits of a stream, the highest of each byte first.
struct Bits<R> {
    stream: R,
    buffer: Vec<u8>,
    next: usize,
    /// Bytes read so far.
    read: u64,
    held: u64,
    count: u32,
}

impl<R: Read> Bits<R> {
    fn new(stream: R) -> Self {
        Self { stream, buffer: Vec::new(), next: 0, read: 0, held: 0, count: 0 }
    }

    /// The next `width` bits, 16 at most; `None` at the end.
    fn read(&mut self, width: u32) -> io::Result<Option<u32>> {
        while self.count < width {
            let Some(byte) = self.byte()? else { return Ok(None) };
            self.held = self.held << 8 | u64::from(byte);
            self.count += 8;
        }
        self.count -= width;
        Ok(Some((self.held >> self.count & ((1 << width) - 1)) as u32))
    }

    fn byte(&mut self) -> io::Result<Option<u8>> {
        if self.next == self.buffer.len() {
            self.buffer.clear();
            self.next = 0;
            match self.stream.by_ref().take(1 << 16).read_to_end(&mut self.buffer) {
                Err(e) if e.kind() != io::ErrorKind::UnexpectedEof => return Err(e),
                _ => {}
            }
            if self.buffer.is_empty() {
                // The coder works in words of 32 bits; what is missing of the last one is zero.
                if self.read.is_multiple_of(4) {
                    return Ok(None);
                }
                self.buffer.push(0);
            }
        }
        let byte = self.buffer[self.next];
        self.next += 1;
        self.read += 1;
        Ok(Some(byte))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A plain coder: runs of at most 100 numbers, each as wide as it must be.
    pub fn encode(bytes: &[u8], magic: &[u8], skip: usize, strip: usize, block: usize) -> Vec<u8> {
        let mut planes: Vec<u8> = Vec::new();
        for chunk in bytes.chunks(block.saturating_mul(skip)) {
            for first in 0..skip {
                planes.extend(chunk.iter().skip(first).step_by(skip));
            }
        }
        let steps: Vec<i32> = (0..planes.len())
            .map(|i| {
                let at = |i: usize| i32::from(planes[i]);
                let before = if i == 0 { 0 } else { at(i - 1) };
                let above = if strip == 1 || i <= strip { 0 } else { at(i - strip) - at(i - strip - 1) };
                i32::from((at(i) - before - above) as i8)
            })
            .collect();
        let mut bits = String::new();
        bits += &format!("{:02b}{:016b}", skip - 1, strip - 1);
        for run in steps.chunks(100) {
            let width = (0..=8)
                .find(|&w| w != 1 && run.iter().all(|&s| s >= -(1 << w >> 1) && (s < 1 << w >> 1 || w == 0 && s == 0)));
            let width: usize = width.unwrap();
            bits += &format!("{:07b}{:03b}", run.len(), if width == 0 { 0 } else { width - 1 });
            for &step in run.iter().filter(|_| width > 0) {
                bits += &format!("{:0width$b}", step + (1 << width >> 1));
            }
        }
        let packed = bits.as_bytes().chunks(8).map(|byte| {
            let byte = str::from_utf8(byte).unwrap();
            u8::from_str_radix(&format!("{byte:0<8}"), 2).unwrap()
        });
        magic.iter().copied().chain(packed).collect()
    }

    fn sample(n: usize) -> Vec<u8> {
        (0..n).map(|i| if i / 50 % 3 == 0 { 7 } else { (i * i / 3 + i * 77) as u8 }).collect()
    }

    #[test]
    fn what_was_coded_comes_back() {
        for n in [1, 2, 3, 99, 1000] {
            for skip in 1..=4 {
                for strip in [1, 2, 17, 500] {
                    let bytes = sample(n);
                    for (magic, block) in [(b"DDS v3d\n", usize::MAX / 8), (b"DDS v3e\n", 1 << 24)] {
                        let stream = encode(&bytes, magic, skip, strip, block);
                        let found = Dds::new(stream.as_slice()).unwrap().into_bytes().unwrap();
                        assert_eq!(found, bytes, "{n} {skip} {strip}");
                    }
                }
            }
        }
    }

    #[test]
    fn blocks_are_interleaved_each() {
        let planes = [0, 2, 4, 1, 3, 5, 6, 8, 7];
        assert_eq!(interleaved(&planes, 2, Some(3)), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(interleaved(&[0, 3, 6, 1, 4, 2, 5], 3, None), [0, 1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn a_stream_by_hand() {
        // skip 1, strip 1; a run of 3 numbers of 2 bits: +1, +1, −2; then a run of 2 numbers of 0 bits; then nothing.
        let bits = "00".to_owned()
            + "0000000000000000"
            + "0000011"
            + "001"
            + "11"
            + "11"
            + "00"
            + "0000010"
            + "000"
            + "0000000";
        let bytes: Vec<u8> = bits
            .as_bytes()
            .chunks(8)
            .map(|b| u8::from_str_radix(&format!("{:0<8}", str::from_utf8(b).unwrap()), 2).unwrap())
            .collect();
        let stream = [b"DDS v3d\n".as_slice(), &bytes].concat();
        assert_eq!(Dds::new(stream.as_slice()).unwrap().into_bytes().unwrap(), [1, 2, 0, 0, 0]);
    }

    #[test]
    fn a_stream_that_is_cut_off_ends() {
        let stream = encode(&sample(1000), b"DDS v3d\n", 1, 17, usize::MAX / 8);
        for length in 0..stream.len() {
            if let Ok(dds) = Dds::new(&stream[..length]) {
                // Zeros that fill the last word may stand for one more run.
                let found = dds.into_bytes().unwrap();
                assert!(sample(1000).starts_with(&found[..found.len().saturating_sub(140)]), "{length}");
            }
        }
    }
}
