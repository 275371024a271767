//! Blocks of elements of one type.

use crate::error::FileErrorKind;
use crate::netcdf::Classic;
use crate::variables::{Attribute, Store};

use super::super::cell_list::Listed;
use super::{variable, whole};

/// Elements of one type.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Block {
    /// Number in the names of its variables, from 1.
    pub number: usize,
    pub elements: usize,
    /// Nodes of each element.
    nodes: usize,
    /// VTK's number for the type.
    vtk: u8,
}

/// The number of the block whose nodes a variable lists.
pub(super) fn number_of(variable: &str) -> Option<usize> {
    variable.strip_prefix("connect").and_then(|digits| digits.parse().ok())
}

/// The blocks of a file, in order.
pub(super) fn blocks(store: &Classic) -> Result<Vec<Block>, FileErrorKind> {
    let mut blocks = Vec::new();
    for connect in store.variables() {
        let Some(number) = number_of(&connect.name) else { continue };
        let kind = match store.attribute(&connect.name, "elem_type") {
            Some(Attribute::Text(text)) => text.trim_matches(['\0', ' ']).to_uppercase(),
            _ => String::new(),
        };
        let wrong =
            |found: &str, allowed: &str| FileErrorKind::field(format!("{}, elem_type", connect.name), found, allowed);
        // Polyhedra have no fixed number of nodes.
        if kind.starts_with("NFACED") {
            return Err(wrong(&kind, "blocks of tetrahedra, pyramids, wedges and hexahedra are read"));
        }
        let &[elements, nodes] = &connect.shape[..] else {
            return Err(wrong(
                &format!("a list with {} axes", connect.shape.len()),
                "must be of elements and their nodes",
            ));
        };
        let vtk = vtk_type(&kind, nodes).ok_or_else(|| {
            wrong(
                &format!("{kind} of {nodes} nodes"),
                "must be TETRA, PYRAMID, WEDGE or HEX, or a type of fewer than three dimensions",
            )
        })?;
        blocks.push(Block { number, elements, nodes, vtk });
    }
    blocks.sort_by_key(|block| block.number);
    Ok(blocks)
}

/// VTK's number for a type of Exodus: corners come first in both, in the same order.
fn vtk_type(kind: &str, nodes: usize) -> Option<u8> {
    let solids = [("TET", 4, 10, 24), ("PYR", 5, 14, 27), ("WED", 6, 13, 26), ("HEX", 8, 12, 25)];
    if let Some((_, corners, straight, curved)) = solids.into_iter().find(|(begin, ..)| kind.starts_with(begin)) {
        return match nodes.cmp(&corners) {
            std::cmp::Ordering::Less => None,
            std::cmp::Ordering::Equal => Some(straight),
            std::cmp::Ordering::Greater => Some(curved),
        };
    }
    // Any surface, line or point.
    let flat = [
        "SHELL", "QUAD", "TRI", "BAR", "BEAM", "TRUSS", "ROD", "EDGE", "SPRING", "SPHERE", "CIRCLE", "POINT", "NSIDED",
    ];
    flat.iter().any(|begin| kind.starts_with(begin)).then_some(7)
}

impl Block {
    /// Appends the elements to a list of cells.
    pub fn read(&self, store: &Classic, vertices: usize, listed: &mut Listed) -> Result<(), FileErrorKind> {
        let Some(connect) = variable(store, &format!("connect{}", self.number)) else { return Ok(()) };
        // Nodes are counted from 1.
        let numbers: Vec<f64> = whole(store, connect)?.into_iter().map(|node| node - 1.0).collect();
        for element in numbers.chunks(self.nodes.max(1)) {
            listed.push(f64::from(self.vtk), element, vertices)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_told_by_name_and_nodes() {
        assert_eq!([vtk_type("HEX8", 8), vtk_type("HEX", 8), vtk_type("HEX", 27)], [Some(12), Some(12), Some(25)]);
        assert_eq!([vtk_type("TETRA10", 10), vtk_type("TET4", 4), vtk_type("TETRA", 3)], [Some(24), Some(10), None]);
        assert_eq!([vtk_type("SHELL4", 4), vtk_type("", 8), vtk_type("SUPER", 9)], [Some(7), None, None]);
        assert_eq!([number_of("connect12"), number_of("connect"), number_of("coordx")], [Some(12), None, None]);
    }
}
