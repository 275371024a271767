//! Slices: values of the scene's own field, whatever kind of volume it is, and the labels there.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use glam::DVec3;
use vr_core::{Control, RenderError, Volume};
use vr_view::session::{Document, LabelFiles, Labels, MAX_SLICE_SIDE, SliceQuery, Subject, TruthError};

use crate::common::{Running, Watched, document, kinds, of_volume, renderers, taken_apart};

fn query(axis: usize, at: f64, side: u32) -> SliceQuery {
    SliceQuery { axis, at, side }
}

/// The field's own value, asked for by itself.
fn value(volume: &Volume, at: DVec3) -> f64 {
    match (volume.field(), volume.value_grid()) {
        (Some(field), _) => field.value(at).unwrap_or(f64::NAN),
        (_, Some(grid)) => grid.calibration().value(grid.stored_at(grid.placement().to_index(at).to_array())),
        _ => panic!("a volume is a field or a grid"),
    }
}

#[test]
fn slices_are_the_field_bit_for_bit_of_every_kind_of_volume() {
    for (kind, volume) in kinds() {
        let watched = Watched::of(of_volume(volume.clone(), [32, 24]));
        let (low, high) = volume.bounds();
        let mut seen = 0;
        for axis in 0..3 {
            let at = low[axis] + 0.4 * (high[axis] - low[axis]);
            let slice = watched.session.slice(&query(axis, at, 40), &Control::default()).unwrap();
            let [w, h] = slice.size;
            assert_eq!((w.max(h), slice.values.len(), slice.label_indices.len()), (40, (w * h) as usize, 0), "{kind}");
            // Pixels are square, but for whole numbers of them.
            let pixel = [slice.right.length() / f64::from(w), slice.down.length() / f64::from(h)];
            assert!((pixel[0] / pixel[1] - 1.0).abs() < 0.5 / f64::from(w.min(h)) + 1e-9, "{kind}: {pixel:?}");
            for y in 0..h {
                for x in 0..w {
                    let place = slice.place([x, y]);
                    assert!(place[axis] == at && (place - place.clamp(low, high)).length() < 1e-9);
                    let (found, want) = (slice.values[(y * w + x) as usize], value(&volume, place));
                    assert_eq!(found.to_bits(), want.to_bits(), "{kind}, axis {axis}: {found} {want}");
                    seen += usize::from(!found.is_nan());
                }
            }
            // The place itself is told the same.
            let place = slice.place([w / 2, h / 2]);
            let told = watched.session.place(place).unwrap();
            let want = value(&volume, place);
            assert!(told.label.is_none() && told.value.unwrap_or(f64::NAN).to_bits() == want.to_bits(), "{kind}");
        }
        assert!(seen > 200, "{kind}: {seen} pixels have values");
    }
}

#[test]
fn slices_have_the_shape_of_the_world_and_not_of_the_grid() {
    // 8×8×8 voxels of 1×2×3.
    let volume = kinds().into_iter().find(|(kind, _)| *kind == "uneven grid").unwrap().1;
    let watched = Watched::of(of_volume(volume, [16, 16]));
    let size = |axis| watched.session.slice(&query(axis, 3.0, 90), &Control::default()).unwrap().size;
    assert_eq!([size(0), size(1), size(2)], [[60, 90], [30, 90], [45, 90]]);
    assert_eq!(watched.session.opened().steps, DVec3::new(1.0, 2.0, 3.0));
}

/// A patient's head of 6×6×6 mm³, whose values are 10·(distance to the right) + that to the front + that up / 10; labels on its right half.
fn patient(folder: &Path) -> Subject {
    let write = |name: &str, voxels: &[u8]| {
        let path = folder.join(name);
        let head = "NRRD0005\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 6 6 6\n\
                    space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nkinds: domain domain domain\nencoding: raw\n\n";
        std::fs::write(&path, [head.as_bytes(), voxels].concat()).unwrap();
        path
    };
    let each = |value: fn(usize, usize, usize) -> u8| -> Vec<u8> {
        (0..216).map(|i| value(i % 6, i / 6 % 6, i / 36)).collect()
    };
    let path = write("head.nrrd", &each(|x, y, z| (20 * x + 4 * y + z) as u8));
    let labels = write("labels.nrrd", &each(|x, _, _| if x >= 3 { 7 } else { 0 }));
    let names = folder.join("names.label");
    std::fs::write(&names, "0 0 0 0 0 0 0 \"Clear Label\"\n7 255 0 0 1 1 1 \"right half\"\n").unwrap();
    let volume = vr_io::read(&path, &vr_io::ReadOptions::default()).unwrap();
    let mut subject = crate::common::subject_of(volume.volume, [24, 24]);
    subject.volume.info = Some(volume.info);
    subject.labels = Labels::from(LabelFiles { file: labels, names: Some(names) });
    subject
}

#[test]
fn a_patient_s_left_is_on_the_right_and_labels_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let document = Document::new(Arc::new(patient(folder.path())), Arc::new(renderers())).unwrap();
    let watched = Watched::of(document);
    assert!(watched.session.opened().patient);
    let slice = |axis| watched.session.slice(&query(axis, 2.0, 5), &Control::default()).unwrap();
    // Axial: from the patient's right side on the left, the front above.
    let axial = slice(2);
    assert_eq!(
        (axial.size, axial.corner, axial.right),
        ([5, 5], DVec3::new(5.0, 5.0, 2.0), DVec3::new(-5.0, 0.0, 0.0))
    );
    assert_eq!(axial.values[0], 20.0 * 4.5 + 4.0 * 4.5 + 2.0);
    assert_eq!(axial.values[24], 20.0 * 0.5 + 4.0 * 0.5 + 2.0);
    // Coronal and sagittal: the head above; the front on the left of the sagittal one.
    let (coronal, sagittal) = (slice(1), slice(0));
    assert_eq!(coronal.values[0], 20.0 * 4.5 + 8.0 + 4.5);
    assert_eq!(sagittal.values[0], 40.0 + 4.0 * 4.5 + 4.5);
    // Labels: the right half has one; its name and colour are those of the list.
    let [label] = &axial.labels[..] else { panic!("{:?}", axial.labels) };
    assert_eq!((label.number, label.name.as_deref(), label.color), (7, Some("right half"), [1.0, 0.0, 0.0]));
    assert_eq!(axial.label_indices[..5], [1, 1, 1, 0, 0]);
    let told = watched.session.place(DVec3::new(4.0, 1.0, 1.0)).unwrap();
    assert_eq!((told.value, told.label.as_ref()), (Some(85.0), Some(label)));
    assert_eq!(watched.session.place(DVec3::new(-4.0, 1.0, 1.0)).unwrap().value, None);
}

#[test]
fn slices_that_make_no_sense_are_refused_and_stale_ones_end() {
    let watched = Watched::of(document("blobs", 16, [32, 32]));
    for wrong in [
        query(3, 0.0, 10),
        query(0, f64::NAN, 10),
        query(0, f64::INFINITY, 10),
        query(1, 0.0, 0),
        query(1, 0.0, MAX_SLICE_SIDE + 1),
    ] {
        let refused = watched.session.slice(&wrong, &Control::default());
        assert!(matches!(refused, Err(TruthError::Render(RenderError::Parameter(_)))), "{wrong:?}");
    }
    // Outside is vacuum.
    let outside = watched.session.slice(&query(0, 99.0, 10), &Control::default()).unwrap();
    assert!(outside.values.iter().all(|value| value.is_nan()));
    let control = Control::default();
    control.cancel_flag().store(true, Ordering::Relaxed);
    let cancelled = watched.session.slice(&query(0, 0.0, 1024), &control);
    assert!(matches!(cancelled, Err(TruthError::Render(RenderError::Cancelled))));
    watched.session.end();
    let ended = watched.session.slice(&query(0, 0.0, 10), &Control::default());
    assert!(matches!(ended, Err(TruthError::Render(RenderError::Cancelled))));
}

#[test]
fn a_slice_waits_for_no_picture() {
    // A picture under a bound that takes seconds.
    let running = Running::new(document("shepp-logan", 64, [1600, 1200]), true);
    let start = Instant::now();
    for step in 0..10 {
        let answer = running.get(&format!("slice?axis=2&at={}&side=128", 0.1 * f64::from(step)));
        assert_eq!(answer.status, 200);
    }
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    running.end();
}

#[test]
fn slices_and_places_are_told_when_asked_for() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let answer = running.get("slice?axis=1&at=0.25&side=32");
    assert!(answer.status == 200 && answer.head.to_lowercase().contains("content-type: application/octet-stream"));
    let (head, bytes) = taken_apart(&answer.body);
    assert_eq!((&head["size"], &head["axis"], bytes.len()), (&serde_json::json!([32, 32]), &1.into(), 4 * 32 * 32));
    let told: Vec<f32> = bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    let watched = Watched::of(document("blobs", 16, [40, 30]));
    let slice = watched.session.slice(&query(1, 0.25, 32), &Control::default()).unwrap();
    assert!(slice.values.iter().zip(&told).all(|(a, b)| (*a as f32).to_bits() == b.to_bits()));
    let place: serde_json::Value = serde_json::from_slice(&running.get("place?x=0.1&y=0.2&z=-0.3").body).unwrap();
    let want = watched.session.place(DVec3::new(0.1, 0.2, -0.3)).unwrap().value.unwrap();
    assert_eq!(place["value"].as_f64(), Some(want));
    assert!(running.get("place?x=10&y=0&z=0").body.starts_with(br#"{"at":[10.0,0.0,0.0],"value":null"#));
    assert_eq!(running.get("slice?axis=5&at=0&side=32").status, 422);
    for path in ["slice", "slice?axis=1&at=0", "slice?axis=-1&at=0&side=8", "place?x=1", "place?x=1&y=1&z=1&w=1"] {
        assert_eq!(running.get(path).status, 400, "{path}");
    }
    running.end();
}
