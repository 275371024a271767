//! Notes of readers on what they chose, changed or assumed.

use std::ops::{Deref, DerefMut};

use crate::error::on_one_line;

/// Part of a grid's placement that a header may leave open, so that its reader assumes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Assumption {
    /// World units between voxels, along one axis or several.
    Spacing,
    /// World position of the first voxel.
    Origin,
}

/// Notes on the way from a header to a volume, one line each, with those about assumptions known as such: they are taken back where a caller
/// gives what was assumed. Everything else about them is a list of lines, to which readers add.
#[derive(Clone, Debug, Default)]
pub(crate) struct Notes {
    lines: Vec<String>,
    /// Places of the lines about assumptions, ascending.
    assumed: Vec<(Assumption, usize)>,
}

impl Notes {
    /// Adds a line that says what is assumed.
    pub fn assume(&mut self, part: Assumption, line: impl Into<String>) {
        self.assumed.push((part, self.lines.len()));
        self.lines.push(line.into());
    }

    /// Removes the lines about an assumption that does not hold; true if there were any.
    pub fn take_back(&mut self, part: Assumption) -> bool {
        let (gone, kept): (Vec<_>, Vec<_>) = self.assumed.iter().partition(|(of, _)| *of == part);
        // From the last one on, so that places before it stay.
        for &(_, place) in gone.iter().rev() {
            self.lines.remove(place);
        }
        let before = |place: usize| gone.iter().filter(|&&(_, other)| other < place).count();
        self.assumed = kept.into_iter().map(|(of, place)| (of, place - before(place))).collect();
        !gone.is_empty()
    }

    pub fn into_lines(self) -> Vec<String> {
        as_lines(self.lines)
    }
}

/// Notes, each on one line, whatever a file's names and units have in them.
pub(crate) fn as_lines(notes: Vec<String>) -> Vec<String> {
    notes.into_iter().map(|note| on_one_line(&note).into_owned()).collect()
}

impl From<Vec<String>> for Notes {
    fn from(lines: Vec<String>) -> Self {
        Self { lines, assumed: Vec::new() }
    }
}

impl Deref for Notes {
    type Target = Vec<String>;

    fn deref(&self) -> &Vec<String> {
        &self.lines
    }
}

impl DerefMut for Notes {
    fn deref_mut(&mut self) -> &mut Vec<String> {
        &mut self.lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_one_line_whatever_a_file_says() {
        let notes = Notes::from(vec!["units \"\r\u{1b}[31mm\" are not known".to_owned()]);
        assert_eq!(notes.into_lines(), ["units \"\\r\\u{1b}[31mm\" are not known"]);
    }

    #[test]
    fn assumptions_are_taken_back_and_other_lines_stay_in_their_order() {
        let mut notes = Notes::from(vec!["a".to_owned()]);
        notes.assume(Assumption::Spacing, "spacing");
        notes.push("b".to_owned());
        notes.assume(Assumption::Origin, "origin");
        notes.assume(Assumption::Spacing, "distance of slices");
        notes.push("spacing is no assumption here".to_owned());
        assert!(notes.take_back(Assumption::Spacing) && !notes.take_back(Assumption::Spacing));
        assert_eq!(*notes, ["a", "b", "origin", "spacing is no assumption here"]);
        assert!(notes.take_back(Assumption::Origin));
        assert_eq!(notes.into_lines(), ["a", "b", "spacing is no assumption here"]);
    }
}
