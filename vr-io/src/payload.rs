//! Reading of voxels from the place that a header names.
//!
//! Nothing is allocated on a header's word: the size that it claims is held against the length of the file first, or, where
//! the data are compressed, memory grows with what really comes out, up to that size.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use bytemuck::Zeroable;
use vr_core::cancel::CancelToken;
use vr_core::{GridError, memory, parallel};

use crate::decode::with_scalar;
use crate::encoding::{Encoding, invalid};
use crate::error::{FieldError, FileError, FileErrorKind, shown};
use crate::layout::Layout;
use crate::mapped::MappedVoxels;
use crate::read::ReadOptions;
use crate::regular_file::{self, RegularFile};
use crate::scalar::{Endian, ScalarType};
use crate::voxels::{Remember, Stored, Voxels};

/// Bytes between the beginning of the (decoded) data and the voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Skip {
    Bytes(u64),
    /// Bytes of a file that goes on after the voxels: what follows them is no excess.
    Part(u64),
    /// All bytes but those of the voxels, which are the last.
    AllButVoxels,
}

/// A file with voxels in it.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    pub path: PathBuf,
    /// Offset of the data, in bytes of the file.
    pub start: u64,
    /// Lines to skip from there, in the file as it is.
    pub lines: u64,
    /// Bytes to skip then, after decoding.
    pub skip: Skip,
}

/// All voxels of a file, or of the files that a header names, one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Payload {
    pub segments: Vec<Segment>,
    pub encoding: Encoding,
    pub scalar: ScalarType,
    pub endian: Endian,
    /// True if bytes after the voxels are an error, rather than a note: nothing else shows then that the header describes
    /// its data.
    pub excess_is_error: bool,
    /// Likely cause of a wrong length, for the message; empty, or starting with a bracket.
    pub hint: &'static str,
}

impl Payload {
    /// Numbers as they are, from an offset on in a file that holds other things, too.
    pub fn part(path: &Path, start: u64, scalar: ScalarType, endian: Endian) -> Self {
        Self {
            segments: vec![Segment { path: path.into(), start: 0, lines: 0, skip: Skip::Part(start) }],
            encoding: Encoding::Raw,
            scalar,
            endian,
            excess_is_error: false,
            hint: " (is the file whole?)",
        }
    }

    /// Reads the voxels that `layout` picks; `header` is the file that errors about the whole belong to.
    pub fn load(
        &self,
        header: &Path,
        layout: &Layout,
        options: &ReadOptions,
        notes: &mut Vec<String>,
    ) -> Result<Voxels, FileError> {
        let files = self.segments.len();
        if files == 0 || !layout.total.is_multiple_of(files) {
            let allowed = format!("must divide the {} numbers of the header", layout.total);
            return Err(FieldError::new("data file", format_args!("{files} files"), allowed).in_file(header));
        }
        // Numbers and bytes of each file.
        let samples = layout.total / files;
        let size = self.scalar.bytes();
        let bytes = (samples as u64)
            .checked_mul(size as u64)
            .ok_or_else(|| FileError::new(header, GridError::Dims { dims: layout.dims }))?;

        // Map the file where its bytes are the voxels as memory holds them.
        let as_stored = self.endian == Endian::NATIVE || size == 1;
        if let [segment] = self.segments.as_slice()
            && options.map
            && as_stored
            && with_scalar!(self.scalar, S => S::IS_MEMORY_TYPE)
            && self.encoding == Encoding::Raw
            && layout.is_contiguous()
        {
            let (file, offset) = self.locate(header, segment, bytes, notes)?;
            let first = offset + (layout.offset * size) as u64;
            let io = |e| FileError::new(&segment.path, e);
            with_scalar!(self.scalar, S => {
                if let Some(file) = file.get_ref().on_disk()
                    && let Some(mapped) = MappedVoxels::<S>::new(file, first, layout.count()).map_err(io)?
                {
                    return Ok(S::remember(Stored::Mapped(mapped), notes));
                }
            });
        }

        // What is read needs memory: scattered voxels are picked out of all.
        let all = if layout.is_contiguous() { 0 } else { layout.total as u64 };
        memory::check("the volume", all.saturating_add(layout.count() as u64).saturating_mul(size as u64))
            .map_err(|e| FileError::new(header, e))?;

        // Slices in files of their own are read side by side.
        if self.segments.len() > 1 && self.encoding == Encoding::Raw && layout.is_contiguous() {
            let places = self.slice_places(header, layout, samples, bytes, notes)?;
            return with_scalar!(self.scalar, S => {
                let mut out = vec![S::zeroed(); layout.count()];
                self.load_slices(&places, bytemuck::cast_slice_mut(&mut out))?;
                Ok(S::remember(Stored::Owned(out), notes))
            });
        }

        // One run is taken out of the stream as it goes by; scattered voxels are picked out of all at the end.
        let contiguous = layout.is_contiguous();
        let (skip, take) = if contiguous { (layout.offset, layout.count()) } else { (0, layout.total) };
        with_scalar!(self.scalar, S => {
            let mut run = Run::<S> { skip, take, out: Vec::new() };
            self.load_run(header, samples, bytes, &mut run, notes)?;
            let out = if contiguous { run.out } else { layout.pick(&run.out) };
            Ok(S::remember(Stored::Owned(out), notes))
        })
    }

    /// Reads all segments, one after the other, and keeps a run of their numbers.
    fn load_run(
        &self,
        header: &Path,
        samples: usize,
        bytes: u64,
        kept: &mut dyn Kept,
        notes: &mut Vec<String>,
    ) -> Result<(), FileError> {
        for segment in &self.segments {
            match self.encoding {
                Encoding::Text => self.load_text(header, segment, samples, kept, notes)?,
                _ => self.load_bytes(header, segment, bytes, kept, notes)?,
            }
        }
        Ok(())
    }

    /// Finds the part of each raw segment that the run of a layout covers. All lengths are checked before there is room for the voxels.
    fn slice_places(
        &self,
        header: &Path,
        layout: &Layout,
        samples: usize,
        bytes: u64,
        notes: &mut Vec<String>,
    ) -> Result<Vec<SlicePlace<'_>>, FileError> {
        let checked = parallel::try_collect(self.segments.len(), |i| {
            let mut notes = Vec::new();
            let (_, offset) = self.locate(header, &self.segments[i], bytes, &mut notes)?;
            Ok((offset, notes))
        })?;
        let run = layout.offset..layout.offset + layout.count();
        let size = self.scalar.bytes();
        let mut places = Vec::new();
        for (i, (segment, (offset, found))) in self.segments.iter().zip(checked).enumerate() {
            notes.extend(found);
            let (first, end) = ((i * samples).max(run.start), ((i + 1) * samples).min(run.end));
            if first < end {
                let start = offset + ((first - i * samples) * size) as u64;
                places.push(SlicePlace { path: &segment.path, start, bytes: (end - first) * size });
            }
        }
        Ok(places)
    }

    /// Reads parts of raw segments in parallel, each straight to its place in memory.
    fn load_slices(&self, places: &[SlicePlace<'_>], mut out: &mut [u8]) -> Result<(), FileError> {
        let mut parts: Vec<(&mut [u8], io::Result<usize>)> = Vec::new();
        for place in places {
            let (part, rest) = out.split_at_mut(place.bytes);
            out = rest;
            parts.push((part, Ok(0)));
        }
        let size = self.scalar.bytes();
        parallel::each_part(&mut parts, |i, (part, found)| {
            *found = read_at(places[i].path, places[i].start, part);
            if self.endian != Endian::NATIVE && size > 1 {
                part.chunks_exact_mut(size).for_each(<[u8]>::reverse);
            }
        });
        for (place, (_, found)) in places.iter().zip(parts) {
            let found = found.map_err(|e| FileError::new(place.path, e))?;
            if found < place.bytes {
                let (claimed, found) = (place.bytes as u64, found as u64);
                return Err(FileError::new(place.path, FileErrorKind::Length { claimed, found, hint: self.hint }));
            }
        }
        Ok(())
    }

    /// The file, standing where the encoded data begin.
    fn open(&self, header: &Path, segment: &Segment) -> Result<BufReader<RegularFile>, FileError> {
        let file = regular_file::open(&segment.path).map_err(|source| {
            if segment.path == header {
                FileError::new(header, source)
            } else {
                FileError::new(header, FileErrorKind::DataFile { data: segment.path.clone(), source })
            }
        })?;
        let io = |e| FileError::new(&segment.path, e);
        let mut file = BufReader::with_capacity(1 << 16, file);
        file.seek(SeekFrom::Start(segment.start)).map_err(io)?;
        for line in 0..segment.lines {
            if skip_line(&mut file).map_err(io)? == 0 {
                return Err(FieldError::new("line skip", segment.lines, format!("the file has {line} lines there"))
                    .in_file(&segment.path));
            }
        }
        Ok(file)
    }

    /// The file, and where in it the raw voxels begin; their length is checked.
    fn locate(
        &self,
        header: &Path,
        segment: &Segment,
        claimed: u64,
        notes: &mut Vec<String>,
    ) -> Result<(BufReader<RegularFile>, u64), FileError> {
        let io = |e| FileError::new(&segment.path, e);
        let mut file = self.open(header, segment)?;
        let start = file.stream_position().map_err(io)?;
        let rest = file.get_ref().length().map_err(io)?.saturating_sub(start);
        let skip = match segment.skip {
            Skip::Bytes(n) | Skip::Part(n) => n,
            Skip::AllButVoxels => rest.saturating_sub(claimed),
        };
        let mut found = rest.saturating_sub(skip);
        if matches!(segment.skip, Skip::Part(_)) {
            found = found.min(claimed);
        }
        self.check_length(segment, claimed, found, notes)?;
        file.seek(SeekFrom::Start(start + skip)).map_err(io)?;
        Ok((file, start + skip))
    }

    fn check_length(
        &self,
        segment: &Segment,
        claimed: u64,
        found: u64,
        notes: &mut Vec<String>,
    ) -> Result<(), FileError> {
        if found < claimed || (found > claimed && self.excess_is_error) {
            return Err(FileError::new(&segment.path, FileErrorKind::Length { claimed, found, hint: self.hint }));
        }
        if found > claimed {
            notes.push(format!("{} bytes after the voxels are left unread", found - claimed));
        }
        Ok(())
    }

    fn load_bytes(
        &self,
        header: &Path,
        segment: &Segment,
        claimed: u64,
        kept: &mut dyn Kept,
        notes: &mut Vec<String>,
    ) -> Result<(), FileError> {
        let damaged = |source: io::Error| self.damaged(segment, source);
        let length = |found| FileError::new(&segment.path, FileErrorKind::Length { claimed, found, hint: self.hint });
        let raw = self.encoding == Encoding::Raw;

        let mut data: Box<dyn Read> = if raw {
            let (file, _) = self.locate(header, segment, claimed, notes)?;
            // The voxels are there, so there may be room for them.
            kept.reserve(claimed).map_err(|e| FileError::new(&segment.path, e))?;
            Box::new(file)
        } else {
            let skip = match segment.skip {
                Skip::Bytes(n) | Skip::Part(n) => n,
                // Where the end is, only the decoder knows: it runs twice.
                Skip::AllButVoxels => {
                    let all = io::copy(&mut self.encoding.reader(self.open(header, segment)?), &mut io::sink())
                        .map_err(damaged)?;
                    all.checked_sub(claimed).ok_or_else(|| length(all))?
                }
            };
            let mut data = self.encoding.reader(self.open(header, segment)?);
            if io::copy(&mut data.by_ref().take(skip), &mut io::sink()).map_err(damaged)? < skip {
                return Err(length(0));
            }
            data
        };

        let mut buffer = [0u8; 1 << 16];
        let mut left = claimed;
        while left > 0 {
            let n = left.min(buffer.len() as u64) as usize;
            let got = read_full(&mut data, &mut buffer[..n]).map_err(damaged)?;
            if got < n {
                return Err(length(claimed - left + got as u64));
            }
            kept.bytes(&buffer[..n], self.endian).map_err(|e| FileError::new(&segment.path, e))?;
            left -= n as u64;
        }
        if !raw {
            // Counted only so far: a bomb shall not keep us busy.
            const ENOUGH: u64 = 1 << 20;
            let excess = io::copy(&mut data.take(ENOUGH), &mut io::sink()).map_err(damaged)?;
            self.check_length(segment, claimed, claimed + excess, notes)?;
        }
        Ok(())
    }

    fn load_text(
        &self,
        header: &Path,
        segment: &Segment,
        samples: usize,
        kept: &mut dyn Kept,
        notes: &mut Vec<String>,
    ) -> Result<(), FileError> {
        let mut text = Vec::new();
        self.open(header, segment)?.read_to_end(&mut text).map_err(|e| FileError::new(&segment.path, e))?;
        // Words between two looks at the cancel flag.
        const WORDS: usize = 1 << 16;
        let (token, mut found) = (CancelToken::current(), 0_usize);
        for word in text.split(|c| c.is_ascii_whitespace() || *c == b',').filter(|w| !w.is_empty()) {
            if found.is_multiple_of(WORDS) {
                token.check().map_err(|e| FileError::new(&segment.path, io::Error::from(e)))?;
            }
            if found < samples && !str::from_utf8(word).is_ok_and(|word| kept.word(word)) {
                let word = shown(&String::from_utf8_lossy(word));
                let message = format!("sample {found} is {word}, no {}", self.scalar);
                return Err(self.damaged(segment, invalid(message)));
            }
            found += 1;
        }
        let size = self.scalar.bytes() as u64;
        self.check_length(segment, samples as u64 * size, found as u64 * size, notes)
    }

    fn damaged(&self, segment: &Segment, source: io::Error) -> FileError {
        FileError::new(&segment.path, FileErrorKind::Damaged { encoding: self.encoding.name(), source })
    }
}

/// The part of a raw file that is kept: slices in files of their own.
struct SlicePlace<'a> {
    path: &'a Path,
    start: u64,
    bytes: usize,
}

/// The part of a stream of numbers that is kept, whatever their type: the readers are compiled once, and not for each of ten types.
trait Kept {
    /// Makes room for numbers that are there.
    fn reserve(&mut self, bytes: u64) -> io::Result<()>;
    /// Takes the next numbers, as the file has them.
    fn bytes(&mut self, bytes: &[u8], endian: Endian) -> io::Result<()>;
    /// Takes the next number; false if the word is none of the type.
    fn word(&mut self, word: &str) -> bool;
}

/// A run of numbers of one type.
struct Run<S> {
    /// Numbers yet to be left out.
    skip: usize,
    /// Numbers yet to be kept.
    take: usize,
    out: Vec<S>,
}

impl<S: Remember> Kept for Run<S> {
    fn reserve(&mut self, bytes: u64) -> io::Result<()> {
        let samples = (bytes / size_of::<S>() as u64).saturating_sub(self.skip as u64);
        Ok(self.out.try_reserve_exact(samples.min(self.take as u64) as usize)?)
    }

    fn bytes(&mut self, bytes: &[u8], endian: Endian) -> io::Result<()> {
        let most = self.out.len() + self.take;
        let (skip, take) = self.advance(bytes.len() / size_of::<S>());
        // Room doubles with what comes out of a decoder, and is never more than all of the run.
        if self.out.len() + take > self.out.capacity() {
            let room = (2 * self.out.capacity()).max(self.out.len() + take).min(most);
            self.out.try_reserve_exact(room - self.out.len())?;
        }
        let at = |i: usize| i * size_of::<S>();
        S::append(&bytes[at(skip)..at(skip + take)], endian, &mut self.out);
        Ok(())
    }

    fn word(&mut self, word: &str) -> bool {
        let Some(sample) = S::parse(word) else { return false };
        if self.advance(1).1 == 1 {
            self.out.push(sample);
        }
        true
    }
}

impl<S> Run<S> {
    /// Counts of the next `n` numbers to leave out and to keep.
    fn advance(&mut self, n: usize) -> (usize, usize) {
        let skip = self.skip.min(n);
        let take = self.take.min(n - skip);
        self.skip -= skip;
        self.take -= take;
        (skip, take)
    }
}

/// Moves behind the next line feed; the bytes passed.
fn skip_line(file: &mut impl BufRead) -> io::Result<usize> {
    let mut passed = 0;
    loop {
        let available = file.fill_buf()?;
        if available.is_empty() {
            return Ok(passed);
        }
        let end = available.iter().position(|&c| c == b'\n');
        let used = end.map_or(available.len(), |i| i + 1);
        file.consume(used);
        passed += used;
        if end.is_some() {
            return Ok(passed);
        }
    }
}

/// Reads from an offset of a file until the buffer is full or the file ends.
fn read_at(path: &Path, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
    let mut file = regular_file::open(path)?;
    file.seek(SeekFrom::Start(offset))?;
    read_full(&mut file, buffer)
}

/// Reads until the buffer is full or the data end.
fn read_full(data: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match data.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            // A stream that was cut off is too short, not damaged.
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => break,
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}
