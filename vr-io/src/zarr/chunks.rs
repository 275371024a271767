//! The chosen chunks: where they are, and how their numbers come to their places.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use vr_core::{cancel, memory, parallel};

use crate::error::{FieldError, FileError, FileErrorKind};
use crate::layout::Layout;
use crate::regular_file;

use super::listing::Listing;
use super::metadata::Array;

/// Most chunks of one volume: more would be files of a few voxels each.
const MAX_CHUNKS: usize = 1 << 22;
/// Bytes that an array may have of which few chunks are stored.
const MAX_SPARSE_BYTES: u64 = 1 << 32;
/// Bytes that a byte of a stored chunk may stand for beyond that.
const MAX_RATIO: u64 = 4096;

/// One frame and component of an array.
pub(super) struct Selection {
    array: Array,
    dims: [usize; 3],
    /// The array's axes that x, y and z of the volume run along.
    space: [usize; 3],
    /// Index along each of the other axes; 0 along those of space.
    fixed: Vec<usize>,
    /// Numbers from one index to the next in a stored chunk, for each axis of the array.
    strides: Vec<usize>,
    /// Chunks along x, y and z.
    counts: [usize; 3],
}

/// The chunks that are stored.
pub(super) struct Stored {
    /// Indices along x, y and z.
    places: Vec<[usize; 3]>,
    /// Files of them, once each.
    pub files: Vec<PathBuf>,
    missing: usize,
}

impl Selection {
    pub fn new(array: Array, space: [usize; 3], layout: &Layout) -> Self {
        let n = array.shape.len();
        let fixed = layout.first_index(&array.shape);
        let mut strides = vec![0; n];
        let mut stride = 1;
        for &axis in array.order.iter().rev() {
            strides[axis] = stride;
            stride *= array.chunk[axis];
        }
        let counts = space.map(|axis| array.shape[axis].div_ceil(array.chunk[axis]));
        Self { array, dims: layout.dims, space, fixed, strides, counts }
    }

    /// Looks which chunks are there, and holds the size of the volume against them.
    pub fn stored(&self) -> Result<Stored, FileError> {
        let in_file = |e: FieldError| e.in_file(&self.array.file);
        let count = self.counts.iter().try_fold(1usize, |n, &c| n.checked_mul(c)).filter(|&n| n <= MAX_CHUNKS);
        if count.is_none() {
            let found = format_args!("{:?} of them in a volume", self.counts).to_string();
            return Err(in_file(FieldError::new("chunks", found, format!("must be at most {MAX_CHUNKS}"))));
        }
        // Before a look at any of them.
        let claimed = self.count() as u64 * self.array.scalar.bytes() as u64;
        memory::check("the volume", claimed).map_err(|e| FileError::new(&self.array.file, e))?;
        let [nx, ny, nz] = self.counts;
        let mut stored = Stored { places: Vec::new(), files: Vec::new(), missing: 0 };
        // Those that are there, and their lengths.
        let mut files: Vec<(PathBuf, u64)> = Vec::new();
        // The file looked at last, and whether it is there: chunks of a shard share one.
        let mut last: Option<(PathBuf, bool)> = None;
        let mut listing = Listing::new(&self.array.folder);
        for z in 0..nz {
            for y in 0..ny {
                cancel::poll();
                for x in 0..nx {
                    let file = self.file([x, y, z]);
                    let known = last.as_ref().filter(|(path, _)| *path == file).map(|(_, there)| *there);
                    let there = known.unwrap_or_else(|| {
                        let listed = listing.may_have(&file).then(|| std::fs::metadata(&file).ok()).flatten();
                        let found = listed.filter(std::fs::Metadata::is_file);
                        if let Some(found) = &found {
                            files.push((file.clone(), found.len()));
                        }
                        found.is_some()
                    });
                    last = Some((file, there));
                    if there {
                        stored.places.push([x, y, z]);
                    } else {
                        stored.missing += 1;
                    }
                }
            }
        }
        // A shard's chunks come in several rows.
        files.sort_unstable();
        files.dedup_by(|a, b| a.0 == b.0);
        let bytes = files.iter().fold(0u64, |n, (_, length)| n.saturating_add(*length));
        if claimed > bytes.saturating_mul(MAX_RATIO).max(MAX_SPARSE_BYTES) {
            let found = format_args!("{claimed} bytes behind {bytes} bytes of chunks").to_string();
            return Err(in_file(FieldError::new("shape", found, format!("must be at most {MAX_RATIO} to one"))));
        }
        stored.files = files.into_iter().map(|(path, _)| path).collect();
        Ok(stored)
    }

    /// Voxels of the volume.
    fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Indices of a chunk along the array's axes.
    fn indices(&self, place: [usize; 3]) -> Vec<usize> {
        let mut indices: Vec<usize> = self.fixed.iter().zip(&self.array.chunk).map(|(i, c)| i / c).collect();
        for i in 0..3 {
            indices[self.space[i]] = place[i];
        }
        indices
    }

    /// The file of a chunk, or of the shard that it is in.
    fn file(&self, place: [usize; 3]) -> PathBuf {
        let mut indices = self.indices(place);
        if let Some(shard) = &self.array.shard {
            indices.iter_mut().zip(&shard.chunks).for_each(|(i, n)| *i /= n);
        }
        self.array.chunk_file(&indices)
    }

    /// Bytes of all voxels, x fastest.
    pub fn decode(&self, stored: &Stored, notes: &mut Vec<String>) -> Result<Vec<u8>, FileError> {
        let number = self.array.scalar.bytes();
        let mut out = Vec::new();
        let bytes = self.count() * number;
        let no_room = |_| FileError::new(&self.array.file, io::Error::from(io::ErrorKind::OutOfMemory));
        out.try_reserve_exact(bytes).map_err(no_room)?;
        if self.array.fill.iter().all(|&b| b == 0) {
            out.resize(bytes, 0);
        } else {
            (0..self.count()).for_each(|_| out.extend_from_slice(&self.array.fill));
        }
        let mut missing = stored.missing;
        for batch in stored.places.chunks(2 * rayon::current_num_threads().max(1)) {
            let decoded = parallel::try_collect(batch.len(), |i| self.decode_chunk(batch[i]))?;
            for (&place, chunk) in batch.iter().zip(decoded) {
                match chunk {
                    Some(chunk) => self.put(place, &chunk, &mut out),
                    None => missing += 1,
                }
            }
        }
        if missing > 0 {
            let all = self.counts.iter().product::<usize>();
            notes.push(format!("{missing} of {all} chunks are not stored: their voxels have the fill value"));
        }
        Ok(out)
    }

    /// The numbers of a chunk as bytes; `None` if its shard leaves it out.
    fn decode_chunk(&self, place: [usize; 3]) -> Result<Option<Vec<u8>>, FileError> {
        let path = self.file(place);
        let io = |e| FileError::new(&path, e);
        let damaged = |e| FileError::new(&path, FileErrorKind::Damaged { encoding: self.array.encoding(), source: e });
        let claimed = self.array.chunk_count() * self.array.scalar.bytes();
        // A coding may lengthen what it cannot pack.
        let max_bytes = claimed + claimed / 8 + (1 << 16);
        let coded = match &self.array.shard {
            None => read_part(&path, 0, u64::MAX, max_bytes).map_err(io)?,
            Some(_) => match self.shard_entry(&path, place).map_err(damaged)? {
                Some((start, length)) => read_part(&path, start, length, max_bytes).map_err(io)?,
                None => return Ok(None),
            },
        };
        let mut bytes = coded;
        for (i, codec) in self.array.codecs.iter().enumerate().rev() {
            let max_bytes = if i == 0 { claimed } else { max_bytes };
            bytes = codec.decode(&bytes, max_bytes).map_err(damaged)?;
        }
        if bytes.len() != claimed {
            let (claimed, found) = (claimed as u64, bytes.len() as u64);
            let hint = " (of one chunk)";
            return Err(FileError::new(&path, FileErrorKind::Length { claimed, found, hint }));
        }
        Ok(Some(bytes))
    }

    /// Offset and length of a chunk in its shard.
    fn shard_entry(&self, path: &Path, place: [usize; 3]) -> io::Result<Option<(u64, u64)>> {
        let Some(shard) = &self.array.shard else { return Ok(None) };
        let inner = self.indices(place).into_iter().zip(&shard.chunks).map(|(i, &n)| (i % n, n));
        let (entry, entries) = inner.fold((0u64, 1u64), |(at, all), (i, n)| {
            (at.saturating_mul(n as u64).saturating_add(i as u64), all.saturating_mul(n as u64))
        });
        let mut file = regular_file::open(path)?;
        let length = file.length()?;
        let checksum = if shard.table_has_checksum { 4 } else { 0 };
        let table = entries.saturating_mul(16).saturating_add(checksum);
        let cut_off = || crate::encoding::invalid("the shard is cut off".into());
        let at_end = length.checked_sub(table).ok_or_else(cut_off)?;
        let start = if shard.table_at_end { at_end } else { 0 };
        file.seek(SeekFrom::Start(start + entry * 16))?;
        let mut bytes = [0; 16];
        file.read_exact(&mut bytes)?;
        let word = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
        let (offset, size) = (word(0), word(8));
        if (offset, size) == (u64::MAX, u64::MAX) {
            return Ok(None);
        }
        if offset.checked_add(size).is_none_or(|end| end > length) {
            return Err(cut_off());
        }
        Ok(Some((offset, size)))
    }

    /// Copies a chunk's voxels to their places; what lies beyond the array's end is padding.
    fn put(&self, place: [usize; 3], chunk: &[u8], out: &mut [u8]) {
        let number = self.array.scalar.bytes();
        let size = self.space.map(|axis| self.array.chunk[axis]);
        let step = self.space.map(|axis| self.strides[axis]);
        let first: [usize; 3] = std::array::from_fn(|i| place[i] * size[i]);
        let count: [usize; 3] = std::array::from_fn(|i| size[i].min(self.dims[i].saturating_sub(first[i])));
        let fixed = self.fixed.iter().zip(&self.array.chunk).zip(&self.strides);
        let offset: usize = fixed.map(|((i, c), s)| i % c * s).sum();
        let [nx, ny, _] = self.dims;
        for z in 0..count[2] {
            for y in 0..count[1] {
                let from = (offset + z * step[2] + y * step[1]) * number;
                let to = ((first[2] + z) * ny + first[1] + y) * nx + first[0];
                let row = &mut out[to * number..][..count[0] * number];
                if step[0] == 1 {
                    row.copy_from_slice(&chunk[from..][..row.len()]);
                } else {
                    for (x, voxel) in row.chunks_exact_mut(number).enumerate() {
                        voxel.copy_from_slice(&chunk[from + x * step[0] * number..][..number]);
                    }
                }
            }
        }
    }
}

/// Part of a file, `max_bytes` of it at most: a chunk that is longer is cut off, which its decoder or its length then tells.
fn read_part(path: &Path, start: u64, length: u64, max_bytes: usize) -> io::Result<Vec<u8>> {
    let mut file = regular_file::open(path)?;
    file.seek(SeekFrom::Start(start))?;
    let mut out = Vec::new();
    file.take(length.min(max_bytes as u64 + 1)).read_to_end(&mut out)?;
    Ok(out)
}
