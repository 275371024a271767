//! Folder of the reference pixels that are kept.

use std::io;
use std::path::Path;

use vr_study::reference::ReferenceCache;

use crate::args::CacheArgs;
use crate::console::Console;

/// Opens the folder that flags name, or that of the user's caches. Nothing is kept where there is neither, nor where nothing can be written,
/// which is noted.
pub fn open(args: &CacheArgs, console: Console) -> ReferenceCache {
    let users = || dirs::cache_dir().map(|folder| folder.join("vr").join("exact"));
    let Some(folder) = args.cache.clone().or_else(users).filter(|_| !args.no_cache) else {
        return ReferenceCache::none();
    };
    match check_writable(&folder) {
        Ok(()) => ReferenceCache::in_folder(folder),
        Err(e) => {
            let place = folder.display();
            console.note(&format!(
                "reference pixels are not kept, and cost time again: {place}: {e}; --cache names another folder"
            ));
            ReferenceCache::none()
        }
    }
}

/// Makes a folder, and a file in it that is gone at once.
fn check_writable(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    tempfile::tempfile_in(folder).map(drop)
}
