//! Volumes of which each slice is a picture: a folder of TIFF, PNG, JPEG, BMP or PNM files, or a pattern such as `slice_%03d.png`.
//!
//! Slices are in the order of their names, numbers in them by value. All are of one size and type. Where a file of a stack is missing, that
//! is noted and the slices close ranks, as every program that reads such folders does.

mod names;
mod picture;

use std::path::{Path, PathBuf};

use vr_core::{Calibration, Placement, parallel};

use crate::claim::check_claim;
use crate::error::{FieldError, FileError};
use crate::file_pattern;
use crate::layout::{Axis, Layout, Role};
use crate::memory_folder;
use crate::notes::Notes;
use crate::read::{Description, ReadOptions};
use crate::scalar::Endian;
use crate::source::Decoded;
use crate::tiff::spacing_notes;
use crate::world::Space;

use names::{missing, natural_order};
use picture::{Kind, Picture};

/// Most slices of a volume.
const MAX_SLICES: usize = 1 << 20;

/// True if a file with this ending may be a slice.
pub(crate) fn is_slice(path: &Path) -> bool {
    Kind::of(path).is_some()
}

/// True if the path names no file, but is a pattern that stands for several.
pub(crate) fn is_pattern(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains('%')) && !memory_folder::exists(path)
}

/// True if a folder holds pictures.
pub(crate) fn is_folder_of_slices(path: &Path) -> bool {
    memory_folder::entries(path).is_ok_and(|mut entries| entries.any(|e| e.is_ok_and(|path| is_slice(&path))))
}

/// Reads the headers of all slices of a folder or a pattern.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let mut notes = Notes::default();
    let files = if memory_folder::is_folder(path) {
        of_folder(path, &mut notes)?
    } else if is_pattern(path) {
        of_pattern(path)?
    } else {
        return Err(one_picture(path));
    };
    if let Some(note) = missing(&files) {
        notes.push(note);
    }

    // Headers are read side by side, and the first fault in the order of names is told.
    let headers = parallel::collect(files.len(), |i| Some(Picture::describe(&files[i])));
    let mut headers = headers.into_iter().flatten();
    let Some(first) = headers.next() else {
        return Err(FieldError::new("slices", 0, "must be two or more pictures").in_file(path));
    };
    let first = first?;
    let mut stored = first.stored;
    for (header, file) in headers.zip(&files[1..]) {
        let header = header?;
        if !header.is_like(&first) {
            let allowed = format!("must be {first} as in {}", names::shown_name(&files[0]));
            return Err(FieldError::new("slice", header, allowed).in_file(file));
        }
        stored = stored.saturating_add(header.stored);
    }

    let axes = [
        Axis { size: first.samples, role: if first.is_color { Role::Color } else { Role::Component } },
        Axis { size: first.size[0], role: Role::Space },
        Axis { size: first.size[1], role: Role::Space },
        Axis { size: files.len(), role: Role::Space },
    ];
    let layout = Layout::new(path, &axes, options)?;
    check_claim(
        path,
        "size of the slices",
        (layout.count() as u64).saturating_mul(first.scalar.bytes() as u64),
        stored,
    )?;
    let component = layout.offset;
    let (scalar, encoding, format) = (first.scalar, first.kind.encoding(), first.kind.format());
    let (spacing, units, placed_by) = spacing_notes(first.spacing.clone(), format, &mut notes);
    let placement = Placement::from_spacing(spacing).map_err(|e| FileError::new(path, e))?;
    let header = files[0].clone();
    let job = files.clone();
    let decoded = Decoded {
        decode: Box::new(move |_| decode(&job, &first, component)),
        scalar,
        endian: Endian::NATIVE,
        encoding,
        files,
    };
    Ok(Description {
        format,
        header,
        source: decoded.into(),
        layout: layout.dense(),
        placement,
        placed_by,
        calibration: Calibration::default(),
        space: Space::Own,
        units,
        scan: None,
        notes,
    })
}

/// Bytes of one component of all slices. Memory grows with what the pictures really hold.
fn decode(files: &[PathBuf], like: &Picture, component: usize) -> Result<Vec<u8>, FileError> {
    let mut out = Vec::new();
    for batch in files.chunks(4 * rayon::current_num_threads().max(1)) {
        let slices = parallel::try_collect(batch.len(), |i| picture::decode(&batch[i], like, component))?;
        slices.iter().for_each(|slice| out.extend_from_slice(slice));
    }
    Ok(out)
}

/// The pictures of a folder, in the order of their names.
fn of_folder(path: &Path, notes: &mut Vec<String>) -> Result<Vec<PathBuf>, FileError> {
    let names = file_names(path)?;
    let of = |kind| names.iter().filter(move |name| Kind::of(Path::new(name)) == Some(kind));
    // Scanners leave a preview or a log picture beside the slices: the slices are the many.
    let kind = Kind::ALL.into_iter().max_by_key(|&kind| of(kind).count()).filter(|&kind| of(kind).count() > 0);
    let kind = kind.ok_or_else(|| FieldError::new("folder", "no pictures", "must hold slices").in_file(path))?;
    let count = of(kind).count();
    if let Some(rival) = Kind::ALL.into_iter().find(|&other| other != kind && of(other).count() == count) {
        let found = format!("{count} pictures each of {} and {}", rival.name(), kind.name());
        return Err(FieldError::new("folder", found, "must hold one kind, or be named with a pattern").in_file(path));
    }
    if count < names.len() {
        notes.push(format!(
            "files of the folder that are no {} and are left out: {}",
            kind.name(),
            names.len() - count
        ));
    }
    let mut chosen: Vec<&String> = of(kind).collect();
    chosen.sort_by(|a, b| natural_order(a, b));
    Ok(chosen.into_iter().map(|name| path.join(name)).collect())
}

/// The files that a pattern stands for: those of its numbers, or those that are there.
fn of_pattern(path: &Path) -> Result<Vec<PathBuf>, FileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = path.file_name().unwrap_or_default().to_string_lossy();
    let in_file = |e: FieldError| e.in_file(path);
    let with_numbers = text.split_whitespace().last().is_some_and(|w| w.parse::<i64>().is_ok());
    let names = if with_numbers {
        file_pattern::expand("pattern", &text, MAX_SLICES).map_err(in_file)?
    } else {
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        file_pattern::matching("pattern", &text, &file_names(here)?).map_err(in_file)?
    };
    if names.is_empty() {
        return Err(in_file(FieldError::new("pattern", "no file of such a name", "must stand for two or more files")));
    }
    Ok(names.iter().map(|name| folder.join(name)).collect())
}

/// Names of the files of a folder that are not hidden.
fn file_names(folder: &Path) -> Result<Vec<String>, FileError> {
    let io = |e| FileError::new(folder, e);
    let mut names = Vec::new();
    for path in memory_folder::entries(folder).map_err(io)? {
        let path = path.map_err(io)?;
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
        if !name.starts_with('.') && memory_folder::is_file(&path) {
            names.push(name.to_owned());
        }
        if names.len() > MAX_SLICES {
            return Err(
                FieldError::new("folder", "more files", format!("must be at most {MAX_SLICES}")).in_file(folder)
            );
        }
    }
    Ok(names)
}

/// One picture is no volume; its neighbours may make one.
fn one_picture(path: &Path) -> FileError {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let pattern = names::pattern_of(&name).unwrap_or_else(|| "slice_%03d.png".into());
    let allowed = format!("a volume has two slices or more: name their folder, or a pattern such as {pattern}");
    FieldError::new("slices", 1, allowed).in_file(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageBuffer, Luma, LumaA, Rgb};

    fn read(path: &Path, options: &ReadOptions) -> Result<crate::Loaded, FileError> {
        crate::read(path, options)
    }

    fn grey(z: u8) -> GrayImage {
        GrayImage::from_fn(3, 2, |x, y| Luma([z * 10 + y as u8 * 3 + x as u8]))
    }

    fn numbers(loaded: &crate::Loaded) -> Vec<f32> {
        use vr_core::{Voxel, with_grid};
        with_grid!(loaded.volume.grid().unwrap().values(), g => g.samples().iter().map(|s| s.to_f32()).collect())
    }

    fn expected(slices: &[u8]) -> Vec<f32> {
        slices.iter().flat_map(|z| (0..6).map(move |i| f32::from(z * 10 + i))).collect()
    }

    #[test]
    fn numbers_in_names_count_by_value_and_gaps_are_noted() {
        let folder = tempfile::tempdir().unwrap();
        for z in [10, 9, 2, 1] {
            grey(z).save(folder.path().join(format!("s{z}.png"))).unwrap();
        }
        std::fs::write(folder.path().join("log.txt"), "x").unwrap();
        let loaded = read(folder.path(), &ReadOptions::default()).unwrap();
        assert_eq!(loaded.volume.grid().unwrap().dims(), [3, 2, 4]);
        assert_eq!(numbers(&loaded), expected(&[1, 2, 9, 10]));
        assert_eq!(loaded.info.format, "PNG slices");
        assert_eq!(loaded.info.files.len(), 4);
        let notes = loaded.notes.join("; ");
        assert!(notes.contains("left out: 1") && notes.contains("6 of the numbers"), "{notes}");
        assert!(notes.contains("states no spacing: 1, 1, 1"), "{notes}");
        let loaded = read(&folder.path().join("s%d.png"), &ReadOptions::default()).unwrap();
        assert_eq!(numbers(&loaded), expected(&[1, 2, 9, 10]));
        let loaded = read(&folder.path().join("s%d.png 10 9 -1"), &ReadOptions::default()).unwrap();
        assert_eq!(numbers(&loaded), expected(&[10, 9]));
        let of = |name: &str| read(&folder.path().join(name), &ReadOptions::default()).unwrap_err().to_string();
        assert!(of("s9.png").contains("a pattern such as s%d.png"), "{}", of("s9.png"));
        assert!(of("s%03d.png").contains("no file of such a name"), "{}", of("s%03d.png"));
        assert!(of("s%d.png 1 3 1").contains("s3.png"), "{}", of("s%d.png 1 3 1"));
    }

    #[test]
    fn every_kind_of_picture() {
        for ending in ["png", "bmp", "pgm", "tif"] {
            let folder = tempfile::tempdir().unwrap();
            for z in 0..3 {
                grey(z).save(folder.path().join(format!("{z}.{ending}"))).unwrap();
            }
            let loaded = read(folder.path(), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(numbers(&loaded), expected(&[0, 1, 2]), "{ending}");
        }
    }

    #[test]
    fn sixteen_bits_opacity_and_colours() {
        let folder = tempfile::tempdir().unwrap();
        for z in 0..2u16 {
            let picture = ImageBuffer::from_fn(2, 2, |x, y| LumaA([1000 * z + 10 * y as u16 + x as u16, 65535]));
            image::DynamicImage::ImageLumaA16(picture).save(folder.path().join(format!("{z}.png"))).unwrap();
        }
        let loaded = read(folder.path(), &ReadOptions::default()).unwrap();
        assert_eq!(numbers(&loaded), [0., 1., 10., 11., 1000., 1001., 1010., 1011.]);
        assert!(loaded.notes.iter().any(|n| n == "component 0 is taken, of 0 to 1"));
        let folder = tempfile::tempdir().unwrap();
        for z in 0..2u8 {
            let picture = ImageBuffer::from_fn(2, 2, |x, y| Rgb([z, 10 + x as u8, 20 + y as u8]));
            picture.save(folder.path().join(format!("{z}.png"))).unwrap();
        }
        let red = read(folder.path(), &ReadOptions::default()).unwrap();
        assert!(red.volume.colors().is_some(), "{:?}", red.notes);
        let green = ReadOptions { component: Some(1), ..Default::default() };
        assert_eq!(numbers(&read(folder.path(), &green).unwrap()), [10., 11., 10., 11., 10., 11., 10., 11.]);
    }

    #[test]
    fn twelve_bits_of_a_pgm_stay_twelve_bits() {
        let folder = tempfile::tempdir().unwrap();
        for z in 0..2 {
            let text = format!("P2\n2 2\n4095\n{z} 17 2000 4095\n");
            std::fs::write(folder.path().join(format!("{z}.pgm")), text).unwrap();
        }
        let loaded = read(folder.path(), &ReadOptions::default()).unwrap();
        assert_eq!(numbers(&loaded), [0., 17., 2000., 4095., 1., 17., 2000., 4095.]);
    }

    #[test]
    fn a_slice_of_another_size_or_type_is_named() {
        let folder = tempfile::tempdir().unwrap();
        (0..3).for_each(|z| grey(z).save(folder.path().join(format!("{z}.png"))).unwrap());
        GrayImage::new(2, 2).save(folder.path().join("1.png")).unwrap();
        let message = read(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("1.png: slice: found 2×2 u8; must be 3×2 u8 as in 0.png"), "{message}");
        ImageBuffer::from_pixel(3, 2, Luma([7u16])).save(folder.path().join("1.png")).unwrap();
        let message = read(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("found 3×2 u16"), "{message}");
        std::fs::write(folder.path().join("1.png"), b"\x89PNG\r\n\x1a\nrubbish").unwrap();
        let message = read(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("1.png") && message.contains("damaged"), "{message}");
    }

    #[test]
    fn a_picture_that_claims_too_much_is_refused_before_memory_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        for z in 0..2 {
            std::fs::write(folder.path().join(format!("{z}.pgm")), "P5 60000 60000 255\n12345").unwrap();
        }
        let message = read(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("bytes behind") || message.contains("damaged"), "{message}");
    }
}
