//! Folder of the reference pixels that are kept.

use std::sync::Once;

use vr_study::reference::ReferenceCache;

use crate::args::CacheArgs;
use crate::console::Console;

/// Opens the folder that flags name, or that of the user's caches; nothing is kept where there is neither. What cannot be written is noted, once.
pub fn open(args: &CacheArgs, console: Console) -> ReferenceCache {
    let users = || dirs::cache_dir().map(|folder| folder.join("vr").join("exact"));
    let Some(folder) = args.cache.clone().or_else(users).filter(|_| !args.no_cache) else {
        return ReferenceCache::none();
    };
    let once = Once::new();
    ReferenceCache::in_folder(folder).with_warning(move |reason| {
        once.call_once(|| {
            console.note(&format!(
                "reference pixels are not kept, and cost time again: {reason}; --cache names another folder"
            ));
        });
    })
}
