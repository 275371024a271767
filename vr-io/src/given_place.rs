//! Spacing and origin of a grid that are given in place of those that its file states, or leaves open.

use std::path::Path;

use glam::{DMat3, DVec3};
use vr_core::{Placement, number_text};

use crate::error::{FieldError, FileError};
use crate::notes::Assumption;
use crate::read::Description;

/// Spacing and origin of a grid in place of its file's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenPlace {
    /// World units between voxels along the index axes, whose directions stay.
    pub spacing: Option<[f64; 3]>,
    /// World position of the first voxel, in RAS for patients.
    pub origin: Option<[f64; 3]>,
}

impl GivenPlace {
    /// Puts what is given in the place of what a file says, and notes what that was.
    ///
    /// # Errors
    /// Lengths that no placement has.
    pub(crate) fn apply(&self, description: &mut Description) -> Result<(), FileError> {
        if *self == Self::default() {
            return Ok(());
        }
        let in_file = |e| FileError::new(&description.header, e);
        let own = description.placement;
        let mut axes = own.axes();
        if let Some(spacing) = self.spacing {
            // Lengths are checked as those of a file are.
            Placement::from_spacing(spacing).map_err(in_file)?;
            axes *= DMat3::from_diagonal(DVec3::from(spacing) / own.spacing());
        }
        let origin = self.origin.map_or(own.origin(), DVec3::from);
        description.placement = Placement::new(origin, axes).map_err(in_file)?;
        // Take back the notes about assumptions that no longer hold.
        if self.origin.is_some() {
            description.notes.take_back(Assumption::Origin);
        }
        if self.spacing.is_some() {
            if !description.notes.take_back(Assumption::Spacing) && description.placed_by != "assumed" {
                let [x, y, z] = own.spacing().to_array().map(number_text);
                description.notes.push(format!("the spacing that is given replaces the file's, {x}, {y}, {z}"));
            }
            description.placed_by = "given";
        }
        Ok(())
    }

    /// Refuses what is given for a volume that is no uniform grid.
    ///
    /// # Errors
    /// A field that means nothing there.
    pub(crate) fn refuse(&self, path: &Path) -> Result<(), FileError> {
        let given = [("spacing", self.spacing), ("origin", self.origin)].into_iter().find_map(|(f, v)| Some((f, v?)));
        given.map_or(Ok(()), |(field, found)| {
            Err(FieldError::new(field, format!("{found:?}"), "only uniform grids take one").in_file(path))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{ReadOptions, read, write_bytes};

    use super::*;

    fn placed(name: &str, bytes: &[u8], place: GivenPlace) -> (Placement, &'static str, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        write_bytes(&path, bytes).unwrap();
        let loaded = read(&path, &ReadOptions { place, ..ReadOptions::default() }).unwrap();
        (*loaded.volume.grid().unwrap().placement(), loaded.info.placed_by, loaded.notes)
    }

    #[test]
    fn what_is_given_takes_the_place_of_what_is_assumed() {
        let spacing = Some([0.5, 0.25, 2.0]);
        let place = GivenPlace { spacing, origin: Some([1.0, 2.0, 3.0]) };
        let (found, by, notes) = placed("x_2x2x2_uint8.raw", &[0; 8], place);
        assert_eq!((found.spacing().to_array(), found.origin().to_array()), ([0.5, 0.25, 2.0], [1.0, 2.0, 3.0]));
        assert_eq!((by, notes), ("given", Vec::new()));
    }

    #[test]
    fn what_a_file_states_is_replaced_and_said() {
        let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspace dimension: 3\nencoding: raw\n\
                      space directions: (0,3,0) (-3,0,0) (0,0,5)\nspace origin: (7,8,9)\n\n";
        let bytes = [header.as_bytes(), &[0; 8]].concat();
        let place = GivenPlace { spacing: Some([1.0, 1.0, 2.0]), origin: None };
        let (found, by, notes) = placed("x.nrrd", &bytes, place);
        assert_eq!((found.spacing().to_array(), by), ([1.0, 1.0, 2.0], "given"));
        // Directions and origin stay.
        assert_eq!(found.axes().x_axis, DVec3::Y);
        assert_eq!(found.origin().to_array(), [7.0, 8.0, 9.0]);
        assert_eq!(notes, ["the spacing that is given replaces the file's, 3, 3, 5"]);
    }

    #[test]
    fn wrong_lengths_and_other_volumes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        write_bytes(at("x_2x2x2_uint8.raw"), &[0; 8]).unwrap();
        write_bytes(at("points.csv"), b"x,y,z,v\n0,0,0,1\n1,0,0,2\n").unwrap();
        for (name, spacing, words) in
            [("x_2x2x2_uint8.raw", [1.0, -1.0, 1.0], "-1"), ("points.csv", [1.0; 3], "only uniform grids")]
        {
            let place = GivenPlace { spacing: Some(spacing), origin: None };
            let refused = read(at(name), &ReadOptions { place, ..ReadOptions::default() }).unwrap_err().to_string();
            assert!(refused.contains(words), "{refused}");
        }
    }
}
