//! Folder of the reference pixels that are kept.

use vr_study::reference::ReferenceCache;

use crate::args::CacheArgs;

/// Opens the folder that flags name, or that of the user's caches; nothing is kept where there is neither.
pub fn open(args: &CacheArgs) -> ReferenceCache {
    let users = || dirs::cache_dir().map(|folder| folder.join("vr").join("exact"));
    match args.cache.clone().or_else(users) {
        Some(folder) if !args.no_cache => ReferenceCache::in_folder(folder),
        _ => ReferenceCache::none(),
    }
}
