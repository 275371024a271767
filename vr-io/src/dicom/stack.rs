//! The order of slices and their place: a stack, sorted along its normal (DICOM PS3.3 2024, C.7.6.2.1.1).
//!
//! Rows run along the first direction of ImageOrientationPatient and columns along the second; the third axis is the step from slice to slice
//! that the positions give. Where that leans from the normal, as it does behind a tilted gantry, the grid is sheared.

use glam::{DMat3, DVec3};
use vr_core::Placement;

use super::image::Frame;
use super::tags;
use crate::error::{FieldError, FileErrorKind};
use crate::notes::{Assumption, Notes};
use crate::world::Space;

/// Deviation of a gap from the others, and of a slice from the line of the others, in gaps: above what positions rounded to 0.01 mm make of
/// thin slices, far below a missing slice.
const TOLERANCE: f64 = 0.05;

/// Slices in order, and where they lie.
#[derive(Debug)]
pub(super) struct Stack {
    /// Indices into the slices that were given: the third axis runs fastest, then time.
    pub order: Vec<usize>,
    pub slices: usize,
    pub times: usize,
    pub placement: Placement,
    pub placed_by: &'static str,
    pub space: Space,
    pub has_spacing: bool,
}

impl Stack {
    /// Sorts slices; `numbered` is true where they come from several files, whose numbers then count if there are no positions.
    pub fn new(frames: &[&Frame], numbered: bool, notes: &mut Notes) -> Result<Self, FileErrorKind> {
        if frames.len() < 2 {
            let allowed = "a volume has 2 slices or more";
            return Err(FileErrorKind::field("slices", format_args!("{} image", frames.len()), allowed));
        }
        let placed = frames.iter().filter(|f| f.position.is_some() && f.orientation.is_some()).count();
        match placed {
            0 => unplaced(frames, numbered, notes),
            n if n == frames.len() => placed_stack(frames, notes),
            n => {
                let found = format_args!("in {n} of {} images", frames.len());
                Err(FileErrorKind::field(
                    tags::IMAGE_POSITION_PATIENT.name(),
                    found,
                    "must be in all of them, or in none",
                ))
            }
        }
    }
}

/// A slice with its distance along the normal.
struct Placed<'a> {
    index: usize,
    along: f64,
    position: DVec3,
    frame: &'a Frame,
}

fn placed_stack(frames: &[&Frame], notes: &mut Notes) -> Result<Stack, FileErrorKind> {
    let [row, column] = one_orientation(frames)?;
    let normal = row.cross(column).normalize();
    let mut slices: Vec<Placed<'_>> = frames
        .iter()
        .enumerate()
        .filter_map(|(index, &frame)| {
            let position = frame.position?;
            Some(Placed { index, along: normal.dot(position), position, frame })
        })
        .collect();
    slices.sort_by(|a, b| a.along.total_cmp(&b.along));

    // Several slices at one position are a series in time, or of something else.
    let range = slices[slices.len() - 1].along - slices[0].along;
    let same = range / slices.len() as f64 * TOLERANCE;
    let mut groups: Vec<Vec<Placed<'_>>> = Vec::new();
    for slice in slices {
        match groups.last_mut() {
            Some(group) if slice.along - group[0].along <= same => group.push(slice),
            _ => groups.push(vec![slice]),
        }
    }
    let times = groups.iter().map(Vec::len).min().unwrap_or(0);
    if let Some(group) = groups.iter().find(|g| g.len() != times) {
        let found = format_args!("{} images at {} mm along the normal", group.len(), rounded(group[0].along));
        let allowed =
            format!("must be {times} there, as at other positions: a slice is there twice, or one is missing");
        return Err(FileErrorKind::field(tags::IMAGE_POSITION_PATIENT.name(), found, allowed));
    }
    if groups.len() < 2 {
        let found = format_args!("{} images at one position", frames.len());
        return Err(FileErrorKind::field(
            tags::IMAGE_POSITION_PATIENT.name(),
            found,
            "a volume has 2 positions or more",
        ));
    }
    for group in &mut groups {
        group.sort_by_key(|slice| (slice.frame.order, slice.index));
    }
    if times > 1 {
        notes.push(format!(
            "{times} images at each of {} positions: frames in order of temporal position, AcquisitionNumber and InstanceNumber",
            groups.len()
        ));
    }

    let step = step(&groups.iter().map(|g| &g[0]).collect::<Vec<_>>())?;
    let lean = step.normalize().dot(normal).clamp(-1.0, 1.0).acos().to_degrees();
    // What rounded positions and directions make of a straight stack.
    const STRAIGHT: f64 = 0.1;
    if lean > STRAIGHT {
        notes.push(format!(
            "slices are shifted along the stack, by {lean:.1} degrees (gantry tilt): the grid is sheared"
        ));
    }
    let [between_rows, between_columns] = pixel_spacing(frames, notes)?;
    let axes = DMat3::from_cols(row * between_columns, column * between_rows, step);
    let order = (0..times).flat_map(|t| groups.iter().map(move |g| g[t].index)).collect();
    Ok(Stack {
        order,
        slices: groups.len(),
        times,
        placement: Space::Lps.place(groups[0][0].position, axes)?,
        placed_by: "ImagePositionPatient",
        space: Space::Lps,
        has_spacing: true,
    })
}

fn one_orientation(frames: &[&Frame]) -> Result<[DVec3; 2], FieldError> {
    // Four digits, rounded.
    const SAME: f64 = 1e-3;
    let all: Vec<[DVec3; 2]> = frames.iter().filter_map(|f| f.orientation).collect();
    let first = all[0];
    let other = all.iter().filter(|o| (o[0] - first[0]).length() > SAME || (o[1] - first[1]).length() > SAME).count();
    if other > 0 {
        let found = format_args!("{other} of {} images turned against the first", all.len());
        return Err(FieldError::new(
            tags::IMAGE_ORIENTATION_PATIENT.name(),
            found,
            "must be one for all slices of a volume",
        ));
    }
    Ok(first)
}

/// Vector from slice to slice, which must be the same everywhere.
fn step(slices: &[&Placed<'_>]) -> Result<DVec3, FieldError> {
    let gaps: Vec<f64> = slices.windows(2).map(|pair| pair[1].along - pair[0].along).collect();
    let mut sorted = gaps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[gaps.len() / 2];
    let wrong: Vec<usize> = (0..gaps.len()).filter(|&i| (gaps[i] - usual).abs() > TOLERANCE * usual).collect();
    if let Some(&first) = wrong.first() {
        let between = |i: usize| format!("{} and {} mm", rounded(slices[i].along), rounded(slices[i + 1].along));
        let found = format!("a gap of {} mm between {}", rounded(gaps[first]), between(first));
        let mut allowed = format!("all gaps along the normal must be as the most, {} mm", rounded(usual));
        let missing = wrong.iter().all(|&i| {
            let times = gaps[i] / usual;
            times > 1.5 && (times - times.round()).abs() < 0.1
        });
        if missing {
            let count: f64 = wrong.iter().map(|&i| (gaps[i] / usual).round() - 1.0).sum();
            allowed += &format!(": {count} slice(s) missing");
        }
        const SHOWN: usize = 8;
        for &i in wrong.iter().skip(1).take(SHOWN) {
            allowed += &format!("; another between {}", between(i));
        }
        return Err(FieldError::new(tags::IMAGE_POSITION_PATIENT.name(), found, allowed));
    }
    let (first, last) = (slices[0].position, slices[slices.len() - 1].position);
    let step = (last - first) / gaps.len() as f64;
    let off = |i: usize| (slices[i].position - (first + step * i as f64)).length();
    match (0..slices.len()).find(|&i| off(i) > TOLERANCE * step.length()) {
        None => Ok(step),
        Some(i) => {
            let at = rounded(slices[i].along);
            let found = format!("a slice at {at} mm that is {} mm off the line of the others", rounded(off(i)));
            Err(FieldError::new(
                tags::IMAGE_POSITION_PATIENT.name(),
                found,
                "all steps from slice to slice must be equal",
            ))
        }
    }
}

fn rounded(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}

/// Distances between rows and between columns, the same in all slices.
fn pixel_spacing(frames: &[&Frame], notes: &mut Notes) -> Result<[f64; 2], FieldError> {
    let Some(first) = frames[0].spacing else {
        notes.assume(Assumption::Spacing, "no PixelSpacing: 1, 1 is assumed");
        return Ok([1.0; 2]);
    };
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-3 * b;
    let differs = |f: &&&Frame| f.spacing.is_none_or(|s| !close(s[0], first[0]) || !close(s[1], first[1]));
    if let Some(other) = frames.iter().find(differs) {
        let found = other.spacing.map_or_else(|| "nothing in one image".to_owned(), |s| format!("{}\\{}", s[0], s[1]));
        let allowed = format!("must be {}\\{}, as in the first image", first[0], first[1]);
        return Err(FieldError::new(tags::PIXEL_SPACING.name(), found, allowed));
    }
    if frames[0].spacing_is_detectors {
        notes.push("no PixelSpacing: ImagerPixelSpacing, that at the detector, is taken".into());
    }
    Ok(first)
}

/// A stack of which nothing tells where it lies: in its own frame, in the order of the file or of the numbers of its images.
fn unplaced(frames: &[&Frame], numbered: bool, notes: &mut Notes) -> Result<Stack, FileErrorKind> {
    let mut order: Vec<usize> = (0..frames.len()).collect();
    if numbered {
        order.sort_by_key(|&i| frames[i].order[2]);
        if order.windows(2).any(|pair| frames[pair[0]].order[2] == frames[pair[1]].order[2]) {
            let allowed =
                "without ImagePositionPatient and ImageOrientationPatient, it must be another number in each image";
            return Err(FileErrorKind::field(tags::INSTANCE_NUMBER.name(), "nothing, or one number twice", allowed));
        }
    }
    let by = if numbered { "InstanceNumber" } else { "frame" };
    notes.push(format!(
        "no ImagePositionPatient with ImageOrientationPatient: slices in order of {by}, placed in a frame of their own"
    ));
    let known = frames[0].spacing.is_some();
    let [between_rows, between_columns] = pixel_spacing(frames, notes)?;
    let between = match (frames[0].between_slices, frames[0].thickness) {
        (Some(between), _) if between != 0.0 => between.abs(),
        (_, Some(thickness)) => {
            notes.push("no distance between slices: SliceThickness is taken for it".into());
            thickness
        }
        _ => {
            notes.assume(Assumption::Spacing, "no distance between slices: 1 is assumed");
            1.0
        }
    };
    Ok(Stack {
        order,
        slices: frames.len(),
        times: 1,
        placement: Placement::from_spacing([between_columns, between_rows, between])?,
        placed_by: if known { "PixelSpacing" } else { "assumed" },
        space: Space::Own,
        has_spacing: known,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> Frame {
        Frame {
            position: Some(DVec3::new(x, y, z)),
            orientation: Some([DVec3::X, DVec3::Y]),
            spacing: Some([0.75, 0.5]),
            ..Frame::default()
        }
    }

    fn stack(frames: &[Frame]) -> (Result<Stack, FileErrorKind>, Vec<String>) {
        let mut notes = Notes::default();
        (Stack::new(&frames.iter().collect::<Vec<_>>(), true, &mut notes), notes.into_lines())
    }

    #[test]
    fn sorts_by_position_and_turns_to_ras() {
        let (made, notes) = stack(&[at(10.0, 20.0, 7.0), at(10.0, 20.0, 3.0), at(10.0, 20.0, 5.0)]);
        let made = made.unwrap();
        assert_eq!(made.order, [1, 2, 0]);
        assert_eq!(made.placement.to_world(DVec3::new(1.0, 1.0, 1.0)), DVec3::new(-10.5, -20.75, 5.0));
        assert!(notes.is_empty(), "{notes:?}");
    }

    #[test]
    fn a_sagittal_stack_runs_along_its_normal() {
        // Columns grow towards posterior, rows towards inferior: the normal is to the left's opposite.
        let sagittal = |x: f64| Frame { orientation: Some([DVec3::Y, DVec3::NEG_Z]), ..at(x, 0.0, 0.0) };
        let made = stack(&[sagittal(1.0), sagittal(2.0), sagittal(3.0)]).0.unwrap();
        assert_eq!(made.order, [2, 1, 0]);
        assert_eq!(crate::orientation(&made.placement), "PIR");
    }

    #[test]
    fn a_tilted_gantry_shears_the_grid() {
        let (made, notes) = stack(&[at(0.0, 0.0, 0.0), at(0.0, 1.0, 4.0), at(0.0, 2.0, 8.0)]);
        assert_eq!(made.unwrap().placement.axes().z_axis, DVec3::new(0.0, -1.0, 4.0));
        assert!(notes[0].contains("14.0 degrees"), "{notes:?}");
        let message = stack(&[at(0.0, 0.0, 0.0), at(0.0, 1.0, 4.0), at(0.0, 0.0, 8.0)]).0.unwrap_err().to_string();
        assert!(message.contains("1 mm off the line"), "{message}");
    }

    #[test]
    fn names_the_place_of_a_missing_slice() {
        let frames: Vec<Frame> = [0.0, 2.0, 4.0, 8.0, 10.0].map(|z| at(0.0, 0.0, z)).to_vec();
        let message = stack(&frames).0.unwrap_err().to_string();
        assert!(message.contains("a gap of 4 mm between 4 and 8 mm; all gaps"), "{message}");
        assert!(message.contains("1 slice(s) missing"), "{message}");
        let uneven: Vec<Frame> = [0.0, 2.0, 4.0, 7.0].map(|z| at(0.0, 0.0, z)).to_vec();
        assert!(!stack(&uneven).0.unwrap_err().to_string().contains("missing"));
    }

    #[test]
    fn two_slices_at_each_position_are_two_times() {
        let late = |z: f64| Frame { order: [2, 0, 0], ..at(0.0, 0.0, z) };
        let frames = [late(1.0), at(0.0, 0.0, 1.0), at(0.0, 0.0, 3.0), late(3.0)];
        let (made, notes) = stack(&frames);
        let made = made.unwrap();
        assert_eq!((made.slices, made.times, made.order), (2, 2, vec![1, 2, 0, 3]));
        assert!(notes[0].contains("2 images at each of 2 positions"), "{notes:?}");
        let message = stack(&frames[..3]).0.unwrap_err().to_string();
        assert!(message.contains("2 images at 1 mm") && message.contains("must be 1 there"), "{message}");
    }

    #[test]
    fn refuses_what_is_no_stack() {
        let turned = Frame { orientation: Some([DVec3::Y, DVec3::Z]), ..at(0.0, 0.0, 2.0) };
        assert!(stack(&[at(0.0, 0.0, 1.0), turned]).0.unwrap_err().to_string().contains("1 of 2 images turned"));
        let wider = Frame { spacing: Some([1.0, 0.5]), ..at(0.0, 0.0, 2.0) };
        assert!(stack(&[at(0.0, 0.0, 1.0), wider]).0.unwrap_err().to_string().contains("PixelSpacing"));
        assert!(stack(&[at(0.0, 0.0, 1.0)]).0.is_err());
        assert!(stack(&[at(0.0, 0.0, 1.0), at(0.0, 0.0, 1.0)]).0.is_err());
        assert!(stack(&[at(0.0, 0.0, 1.0), Frame::default()]).0.is_err());
    }
}
