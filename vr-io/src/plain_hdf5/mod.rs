//! HDF5 in its plainest form: groups that are symbol tables, and datasets of numbers in one run. The library up to version 1.6 wrote no other,
//! and later ones write it unless they are told otherwise.
//!
//! The form is that of the HDF5 File Format Specification, version 2.0: superblock 0 or 1 (II.A), B-tree version 1 (III.A.1), symbol table nodes
//! and entries (III.B, III.C), local heap (III.D), object header version 1 (IV.A.1). Own code: `hdf5-reader` (0.12.1), behind the feature `hdf5`,
//! misreads the layouts of version 1.6 and before.

mod dataset;
mod header;
mod window;

use std::path::Path;

use crate::error::{FileErrorKind, shown};

pub(crate) use dataset::PlainDataset;

use header::{Message, messages};
use window::Window;

/// Types of messages in the header of an object.
const DATASPACE: u16 = 0x01;
const DATATYPE: u16 = 0x03;
const LAYOUT: u16 = 0x08;
const SYMBOL_TABLE: u16 = 0x11;

/// Members of a group that are listed: more than any program writes.
const MAX_MEMBERS: usize = 1 << 16;
/// Nodes of a tree that are visited, and members or children of one of them: more than any program writes, and few enough to end.
const MAX_NODES: usize = 1 << 15;
const MAX_IN_NODE: u64 = 1 << 12;

/// A file.
pub(crate) struct PlainHdf5 {
    window: Window,
    /// Place of the root group's header.
    root: u64,
}

impl PlainHdf5 {
    /// Opens a file; `None` for one in another form.
    ///
    /// # Errors
    /// A file that cannot be read, or is cut off in its first bytes.
    pub fn open(path: &Path) -> Result<Option<Self>, FileErrorKind> {
        const BEGIN: &[u8] = b"\x89HDF\r\n\x1a\n";
        let mut window = Window::open(path)?;
        let superblock = window.bytes(0, 24)?;
        let version = superblock[8];
        // Addresses and lengths of 8 bytes each.
        if superblock[..8] != *BEGIN || version > 1 || superblock[13..15] != [8, 8] {
            return Ok(None);
        }
        let addresses = if version == 0 { 24 } else { 28 };
        if window.word(addresses)? != 0 {
            return Ok(None);
        }
        // The root's entry follows four addresses, with that of its header in second place.
        let root = window.word(addresses + 32 + 8)?;
        Ok(Some(Self { window, root }))
    }

    /// Members of a group in the root, and the places of their headers; `None` where there is no such group.
    ///
    /// # Errors
    /// Tables that are damaged.
    pub fn members(&mut self, group: &str) -> Result<Option<Vec<(String, u64)>>, FileErrorKind> {
        let groups = self.members_at(self.root)?.unwrap_or_default();
        let Some((_, header)) = groups.into_iter().find(|(name, _)| name == group) else { return Ok(None) };
        self.members_at(header)
    }

    /// Members of the group with a header; `None` for what is no group of this form.
    fn members_at(&mut self, header: u64) -> Result<Option<Vec<(String, u64)>>, FileErrorKind> {
        let found = messages(&mut self.window, header)?;
        let Some(Message { data, at, .. }) = found.iter().find(|message| message.kind == SYMBOL_TABLE) else {
            return Ok(None);
        };
        let [Some(tree), Some(heap)] = [0, 8].map(|from| window::word(data, from)) else {
            return Err(damaged(*at, "a table of members that is too short"));
        };
        let heap = self.heap(heap)?;
        let (mut members, mut nodes, mut next) = (Vec::new(), vec![tree], 0);
        while let Some(&node) = nodes.get(next) {
            self.visit(node, heap, &mut nodes, &mut members)?;
            if nodes.len() > MAX_NODES || members.len() > MAX_MEMBERS {
                return Err(damaged(node, "too many members"));
            }
            next += 1;
        }
        Ok(Some(members))
    }

    /// Place and length of the names in a heap.
    fn heap(&mut self, at: u64) -> Result<(u64, u64), FileErrorKind> {
        let head = self.window.bytes(at, 32)?;
        match (window::word(&head, 8), window::word(&head, 24)) {
            (Some(length), Some(data)) if head.starts_with(b"HEAP") => Ok((data, length)),
            _ => Err(damaged(at, "no HEAP")),
        }
    }

    /// Collects the members of a table, or the nodes and tables that a node of a tree leads to.
    fn visit(
        &mut self,
        at: u64,
        heap: (u64, u64),
        nodes: &mut Vec<u64>,
        members: &mut Vec<(String, u64)>,
    ) -> Result<(), FileErrorKind> {
        let head = self.window.bytes(at, 8)?;
        let is_table = head.starts_with(b"SNOD");
        // A node of a group's tree: its kind is 0.
        let is_node = head.starts_with(b"TREE") && head[4] == 0;
        if !is_table && !is_node {
            return Err(damaged(at, "no node of a group"));
        }
        let count = u64::from(u16::from_le_bytes([head[6], head[7]]));
        if count > MAX_IN_NODE {
            return Err(damaged(at, "too many members of one node"));
        }
        if !is_table {
            // Behind two neighbours, keys and children in turns, of 8 bytes each.
            let children = self.window.bytes(at.saturating_add(24), 16 * count)?;
            nodes.extend(children.as_chunks::<16>().0.iter().filter_map(|pair| window::word(pair, 8)));
            return Ok(());
        }
        // Entries of 40 bytes: place of the name, place of the header, and more.
        let entries = self.window.bytes(at.saturating_add(8), 40 * count)?;
        for entry in entries.as_chunks::<40>().0 {
            let [Some(name), Some(header)] = [0, 8].map(|from| window::word(entry, from)) else { continue };
            members.push((self.name(heap, name)?, header));
        }
        Ok(())
    }

    fn name(&mut self, (data, length): (u64, u64), from: u64) -> Result<String, FileErrorKind> {
        const MAX_NAME: u64 = 1024;
        let at = data.saturating_add(from);
        let bytes = self.window.up_to(at, length.saturating_sub(from).min(MAX_NAME))?;
        let end = bytes.iter().position(|&b| b == 0).ok_or_else(|| damaged(at, "a name without an end"))?;
        Ok(shown(&String::from_utf8_lossy(&bytes[..end])))
    }

    /// The dataset with a header; `None` for a group, and for datasets of other than numbers or in other than one run.
    ///
    /// # Errors
    /// A header that is damaged.
    pub fn dataset(&mut self, header: u64) -> Result<Option<PlainDataset>, FileErrorKind> {
        let found = messages(&mut self.window, header)?;
        let of = |kind: u16| found.iter().find(|message| message.kind == kind).map(|message| &message.data[..]);
        let parts = (of(DATASPACE), of(DATATYPE), of(LAYOUT));
        let (Some(space), Some(kind), Some(layout)) = parts else { return Ok(None) };
        Ok(PlainDataset::new(space, kind, layout))
    }

    /// All numbers of a dataset.
    ///
    /// # Errors
    /// A dataset that reaches beyond the end of the file.
    pub fn numbers(&mut self, dataset: &PlainDataset) -> Result<Vec<f64>, FileErrorKind> {
        dataset.numbers(&mut self.window)
    }
}

/// The fault of a place in a file.
fn damaged(at: u64, found: &str) -> FileErrorKind {
    FileErrorKind::field(format!("HDF5, byte {at}"), found, "must be whole, as HDF5 describes it")
}
