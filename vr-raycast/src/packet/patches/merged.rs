//! Parts of a ray, those of one pace as one.

use super::steps::Part;

/// Parts of a ray in which those that touch, and are of one patch and pace, are one.
pub(super) struct Merged<I> {
    parts: I,
    ahead: Option<Part>,
}

impl<I: Iterator<Item = Part>> Merged<I> {
    pub(super) fn new(parts: I) -> Self {
        Self { parts, ahead: None }
    }
}

impl<I: Iterator<Item = Part>> Iterator for Merged<I> {
    type Item = Part;

    #[inline]
    fn next(&mut self) -> Option<Part> {
        let mut merged = self.ahead.take().or_else(|| self.parts.next())?;
        for part in self.parts.by_ref() {
            if part != (Part { from: merged.to, to: part.to, ..merged }) {
                self.ahead = Some(part);
                break;
            }
            merged.to = part.to;
        }
        Some(merged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_of_one_patch_and_pace_is_one() {
        let part = |from, to, patch, step, is_seen| Part { from, to, patch, step, is_seen };
        let parts = [
            part(0.0, 1.0, 0, 0.5, true),
            part(1.0, 2.0, 0, 0.5, true),
            part(2.5, 3.0, 0, 0.5, true),
            part(3.0, 4.0, 1, 0.5, true),
            part(4.0, 5.0, 1, 0.25, true),
            part(5.0, 6.0, 1, 0.25, false),
        ];
        let merged: Vec<Part> = Merged::new(parts.into_iter()).collect();
        assert_eq!(merged[0], part(0.0, 2.0, 0, 0.5, true));
        assert_eq!(merged[1..], parts[2..]);
    }
}
