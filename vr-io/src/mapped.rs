//! Voxels that stay in their file: pages are loaded when they are first read.
//!
//! The only unsafe line of the crate is here.

use std::fs::File;
use std::io;
use std::marker::PhantomData;

use bytemuck::Pod;
use memmap2::{Mmap, MmapOptions};

/// A run of voxels inside a mapped file, in the machine's byte order.
pub(crate) struct MappedVoxels<T> {
    map: Mmap,
    sample: PhantomData<T>,
}

impl<T: Pod> MappedVoxels<T> {
    /// Maps `count` voxels from a byte offset on; `None` where they do not lie on a multiple of their type's alignment.
    ///
    /// # Errors
    /// Errors of the system, and `UnexpectedEof` where the file is too short.
    #[allow(unsafe_code)]
    pub fn new(file: &File, offset: u64, count: usize) -> io::Result<Option<Self>> {
        let length = count.checked_mul(size_of::<T>()).ok_or(io::ErrorKind::InvalidInput)?;
        if offset.checked_add(length as u64).is_none_or(|end| end > file.metadata().map_or(0, |m| m.len())) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        // SAFETY: the map is private and read-only, lies within the file (checked above), and is reached only through `&self`
        // as plain numbers of which every bit pattern is valid (`Pod`), so nothing that is read can break an invariant. What
        // no program can rule out is that another one shortens or rewrites the file meanwhile; a shortened file ends the
        // process with SIGBUS. That is the bargain of every memory-mapped reader; `ReadOptions::map = false` declines it, and
        // our own writers replace files by renaming, which leaves a mapped one whole.
        let map = unsafe { MmapOptions::new().offset(offset).len(length).map_copy_read_only(file)? };
        let aligned = bytemuck::try_cast_slice::<u8, T>(&map).is_ok();
        Ok(aligned.then_some(Self { map, sample: PhantomData }))
    }
}

impl<T: Pod> AsRef<[T]> for MappedVoxels<T> {
    fn as_ref(&self) -> &[T] {
        bytemuck::cast_slice(&self.map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn file_of(bytes: &[u8]) -> File {
        let mut f = tempfile::tempfile().unwrap();
        f.write_all(bytes).unwrap();
        f
    }

    #[test]
    fn gives_what_copying_gives() {
        let bytes: Vec<u8> = (0..4000u32).map(|i| (i * 7 % 251) as u8).collect();
        let file = file_of(&bytes);
        for offset in [0usize, 2, 348, 352] {
            let mapped = MappedVoxels::<u16>::new(&file, offset as u64, 1000).unwrap().unwrap();
            let copied: Vec<u16> =
                bytes[offset..offset + 2000].as_chunks().0.iter().map(|c| u16::from_ne_bytes(*c)).collect();
            assert_eq!(mapped.as_ref(), copied);
        }
    }

    #[test]
    fn declines_what_is_not_aligned_and_refuses_what_is_not_there() {
        let file = file_of(&[0; 100]);
        assert!(MappedVoxels::<f32>::new(&file, 2, 10).unwrap().is_none());
        assert!(MappedVoxels::<u8>::new(&file, 3, 97).unwrap().is_some());
        assert!(MappedVoxels::<u8>::new(&file, 3, 98).is_err());
        assert!(MappedVoxels::<u16>::new(&file, u64::MAX, 1).is_err());
        assert!(MappedVoxels::<f32>::new(&file, 0, usize::MAX).is_err());
    }
}
