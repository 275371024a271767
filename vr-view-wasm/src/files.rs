//! Files that the page sends, in memory until they are read.

use std::collections::BTreeMap;
use std::io;

use vr_view::upload::UploadFolder;

/// Files by their names.
#[derive(Default)]
pub struct Files(pub BTreeMap<String, Vec<u8>>);

impl UploadFolder for Files {
    fn empty() -> io::Result<Self> {
        Ok(Self::default())
    }

    fn append(&mut self, name: &str, _is_new: bool, bytes: &[u8]) -> io::Result<()> {
        self.0.entry(name.to_owned()).or_default().extend_from_slice(bytes);
        Ok(())
    }
}
