//! Reference pixels on disk, so that a second report does not solve them again.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fmt, fs};

use sha2::{Digest, Sha256};
use vr_core::clock::Instant;
use vr_core::{Control, Model, RenderError, Scene, View};
use vr_physics::{Certainty, DEFAULT_TOLERANCE, Pixel, Reference, Solution};

use super::ReferencePixels;
use super::fingerprint::fingerprint;

/// Takes the reason why pixels could not be kept.
type Warning = dyn Fn(&str) + Send + Sync;

/// Folder of reference pixels, by the hash of all that they depend on. Without a folder, nothing is kept.
///
/// References of scenes that scatter are not kept: the file format has no place for standard errors.
///
/// A file that is damaged, or that disagrees with a few of its pixels solved again, is not believed: it is solved anew, and replaced.
#[derive(Clone, Default)]
pub struct ReferenceCache {
    folder: Option<PathBuf>,
    warn: Option<Arc<Warning>>,
}

impl fmt::Debug for ReferenceCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ReferenceCache").field("folder", &self.folder).finish_non_exhaustive()
    }
}

const MAGIC: &[u8; 8] = b"VREXACT1";
const KEY: usize = 32;
/// Record of a pixel: r, g, b, a, error, and 1 where the error is proven.
const NUMBERS: usize = 6;
/// Number of pixels that are solved again before a file is trusted.
const CHECKED: usize = 4;

impl ReferenceCache {
    /// Returns a cache that keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// Returns a cache in a folder, which is made when first written to.
    pub fn in_folder(folder: PathBuf) -> Self {
        Self { folder: Some(folder), warn: None }
    }

    /// Calls back with the reason, each time that pixels could not be kept.
    #[must_use]
    pub fn with_warning(self, warn: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { warn: Some(Arc::new(warn)), ..self }
    }

    /// Returns the pixels of a view, solved before or now.
    ///
    /// # Errors
    /// Same as for [`ReferencePixels::solve`]. A folder that cannot be read or written is no error; it only costs time ([`Self::with_warning`]).
    pub fn solve(
        &self,
        (scene, view): (&Scene, &View),
        model: &Model,
        pixels: Vec<[u32; 2]>,
        control: &Control,
    ) -> Result<ReferencePixels, RenderError> {
        // Without a folder no key is needed: it takes every voxel, and the surfaces' layer.
        let key = |folder| Some((folder, fingerprint((scene, view), model, &pixels, DEFAULT_TOLERANCE)?));
        let folder = self.folder.as_ref().filter(|_| scene.scattering.is_none());
        let Some((folder, key)) = folder.and_then(key) else {
            return ReferencePixels::solve((scene, view), model, pixels, control);
        };
        let path = folder.join(key.iter().map(|b| format!("{b:02x}")).collect::<String>() + ".exact");
        let start = Instant::now();
        if let Some(kept) = read(&path, &key, pixels.len()) {
            let some = checked(&kept);
            let places: Vec<[u32; 2]> = some.iter().map(|&i| pixels[i]).collect();
            let again = Reference::default().solve_pixels(scene, view, model, &places, control)?;
            if some.iter().zip(&again.pixels).all(|(&i, fresh)| agree(&kept[i], fresh)) {
                let solution = Solution { pixels: kept, counts: again.counts };
                return Ok(ReferencePixels::new(pixels, &solution, start));
            }
        }
        let solution = Reference::default().solve_pixels(scene, view, model, &pixels, control)?;
        // A full disk, or none to write to, is no reason to fail: the solution is there.
        let made = fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()));
        let kept =
            made.and_then(|()| vr_io::write_bytes(&path, &encode(&key, &solution.pixels)).map_err(|e| e.to_string()));
        if let (Err(reason), Some(warn)) = (kept, &self.warn) {
            warn(&reason);
        }
        Ok(ReferencePixels::new(pixels, &solution, start))
    }
}

/// Returns the pixels that are solved again: the most opaque one, since background agrees with any version, and others here and there.
fn checked(kept: &[Pixel]) -> Vec<usize> {
    let opaque = (0..kept.len()).max_by(|&a, &b| kept[a].rgba[3].total_cmp(&kept[b].rgba[3]));
    // By the golden ratio: no row or column of a picture has all of them.
    let scattered = (1..CHECKED).map(|i| ((i as f64 * 0.618_034).fract() * kept.len() as f64) as usize);
    opaque.into_iter().chain(scattered.filter(|&i| i < kept.len())).collect()
}

fn agree(a: &Pixel, b: &Pixel) -> bool {
    let allowed = a.certainty.value() + b.certainty.value();
    // Whatever is allowed, a NaN is not.
    (0..4).all(|c| (a.rgba[c] - b.rgba[c]).abs() <= allowed)
}

fn encode(key: &[u8; KEY], pixels: &[Pixel]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key);
    bytes.extend((pixels.len() as u64).to_le_bytes());
    for p in pixels {
        let proven = matches!(p.certainty, Certainty::Bound(_));
        let [r, g, b, a] = p.rgba;
        let numbers: [f64; NUMBERS] = [r, g, b, a, p.certainty.value(), f64::from(u8::from(proven))];
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    }
    let sum = Sha256::digest(&bytes);
    bytes.extend(sum);
    bytes
}

/// Reads the pixels of a file that is whole and about the pixels asked for; depths are not kept.
fn read(path: &Path, key: &[u8; KEY], count: usize) -> Option<Vec<Pixel>> {
    let bytes = fs::read(path).ok()?;
    let (content, sum) = bytes.split_at_checked(bytes.len().checked_sub(32)?)?;
    let head = MAGIC.len() + KEY + 8;
    let expected = head + count * NUMBERS * 8;
    if content.len() != expected || Sha256::digest(content).as_slice() != sum {
        return None;
    }
    if &content[..8] != MAGIC || content[8..8 + KEY] != key[..] {
        return None;
    }
    let number = |b: &[u8]| f64::from_le_bytes(b.try_into().expect("eight bytes"));
    let pixel = |p: &[u8]| {
        let x: Vec<f64> = p.chunks_exact(8).map(number).collect();
        let certainty = if x[5] == 1.0 { Certainty::Bound(x[4]) } else { Certainty::Estimate(x[4]) };
        Pixel { rgba: [x[0], x[1], x[2], x[3]], depth: f64::INFINITY, certainty }
    };
    Some(content[head..].chunks_exact(NUMBERS * 8).map(pixel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::phantom_subject;
    use vr_physics::metrics::subgrid;

    fn files(folder: &Path) -> Vec<PathBuf> {
        fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect()
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_told() {
        use std::sync::Mutex;
        let folder = tempfile::tempdir().unwrap();
        let blocked = folder.path().join("file");
        fs::write(&blocked, "").unwrap();
        let told = Arc::new(Mutex::new(Vec::new()));
        let list = Arc::clone(&told);
        let cache = ReferenceCache::in_folder(blocked.join("kept"))
            .with_warning(move |reason| list.lock().unwrap().push(reason.to_owned()));
        let subject = phantom_subject("fog", 4, [8, 8]).unwrap();
        let pixels = vec![[0, 0], [4, 4]];
        let solved = cache.solve((&subject.scene, &subject.view), &Model::Canonical, pixels, &Control::default());
        assert!(solved.is_ok(), "it costs time alone");
        assert!(told.lock().unwrap()[0].contains("kept"), "{told:?}");
    }

    #[test]
    fn what_was_solved_comes_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ReferenceCache::in_folder(folder.path().join("deep/down"));
        let subject = phantom_subject("fog", 8, [16, 12]).unwrap();
        let pixels = subgrid(5, subject.view.size);
        let solve = |cache: &ReferenceCache| {
            let view = (&subject.scene, &subject.view);
            cache.solve(view, &Model::Canonical, pixels.clone(), &Control::default()).unwrap()
        };
        let first = solve(&cache);
        assert_eq!(files(&folder.path().join("deep/down")).len(), 1);
        let second = solve(&cache);
        assert_eq!((first.rgba(), first.certainty), (second.rgba(), second.certainty));
        assert_eq!(first.rgba(), solve(&ReferenceCache::none()).rgba());
    }

    #[test]
    fn damaged_and_wrong_files_are_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ReferenceCache::in_folder(folder.path().into());
        let subject = phantom_subject("fog", 6, [9, 9]).unwrap();
        let pixels = subgrid(4, subject.view.size);
        let view = (&subject.scene, &subject.view);
        let solve = || cache.solve(view, &Model::Canonical, pixels.clone(), &Control::default()).unwrap();
        let right = solve();
        let [path] = &files(folder.path())[..] else { panic!("one file") };
        let whole = fs::read(path).unwrap();
        let key: [u8; KEY] = whole[8..8 + KEY].try_into().unwrap();
        // Whole, and of the right key, but wrong where anything is visible: as an older version might have left it.
        let lie = |rgba: &[f64; 4]| Pixel {
            rgba: if rgba[3] > 0.0 { [0.9; 4] } else { *rgba },
            depth: 0.0,
            certainty: Certainty::Bound(1e-12),
        };
        let lies: Vec<Pixel> = right.rgba().iter().map(lie).collect();
        assert!(lies.iter().any(|p| p.rgba[3] == 0.9) && lies.iter().any(|p| p.rgba[3] == 0.0));
        let mut flipped = whole.clone();
        flipped[100] ^= 1;
        for bad in [vec![], whole[..whole.len() - 1].to_vec(), flipped, encode(&key, &lies)] {
            fs::write(path, bad).unwrap();
            assert_eq!(solve().rgba(), right.rgba());
            assert_eq!(fs::read(path).unwrap(), whole, "replaced");
        }
    }
}
