//! Figures of the C-buffer over a turntable: `cargo test --release -p vr-raycast --lib c_buffer::figures -- --nocapture`.

use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::*;

use super::super::Coherence;
use super::*;
use crate::caster::{EmptySpace, ImageSampling, RayCaster, Vector};
use crate::prepared::PreparedCaster;

/// Pixels of a frame whose bits are not another's.
fn differing(a: &Frame, b: &Frame) -> usize {
    let bits = |f: &Frame| f.pixels().iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    bits(a).into_iter().zip(bits(b)).filter(|(a, b)| a != b).count()
}

/// 24 views of a turntable, a few degrees apart: without the proof pixels are wrong, with it none is.
#[test]
fn a_turntable_is_wrong_without_the_proof_and_right_with_it() {
    println!(
        "| phantom | degrees a view | claimed | of them wrong or unsure | empty distance left out | wrong without proof | with |"
    );
    for (name, degrees) in [("blobs", 1.0), ("blobs", 5.0), ("shells", 1.0), ("shells", 5.0), ("hydrogen", 5.0)] {
        let phantom = phantom::by_name(name).unwrap();
        let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, TRANSFER_UNIT_DISTANCE);
        let scene = Scene::new(phantom::sample::<u8>(&*phantom, [64; 3]).unwrap().into(), transfer.unwrap());
        let control = Control::default();
        let prepare = |screen, checked: bool| {
            // Ray by ray and without leaping, as it was published: a packet begins where the first of its rays does.
            let caster = RayCaster {
                image_sampling: screen,
                vector: Vector::Off,
                empty_space: EmptySpace::None,
                ..RayCaster::uniform(0.5)
            };
            let mut made = PreparedCaster::new(caster, &scene, &control).unwrap();
            if let Some(Coherence::Points(buffer)) = &mut made.coherence {
                buffer.checked = checked;
            }
            made
        };
        let mut plain = prepare(ImageSampling::EveryPixel, true);
        let mut buffers = [false, true].map(|checked| prepare(ImageSampling::CBuffer, checked));
        let start = Camera::framing(scene.volume.bounds(), 10.0, 25.0, None);
        let (mut wrong, mut sums, mut pixels) = ([0, 0], Starts::default(), 0);
        for k in 0..24 {
            let view = View::new(start.orbit(degrees * f64::from(k), 0.0), [128, 128]);
            let want = plain.render(&view, &control).unwrap().frame;
            pixels += want.pixels().len();
            for (buffer, wrong) in buffers.iter_mut().zip(&mut wrong) {
                *wrong += differing(&buffer.render(&view, &control).unwrap().frame, &want);
            }
            let Some(Coherence::Points(buffer)) = &buffers[1].coherence else { panic!("a C-buffer") };
            // The first view has nothing to begin from.
            if k > 0 {
                sums.add(&buffer.starts);
            }
        }
        let percent = |a: f64, b: f64| 100.0 * a / b;
        println!(
            "| {name} | {degrees} | {:.1} % | {:.1} % | {:.1} % | {:.4} % | {} |",
            percent(sums.claimed as f64, sums.rays as f64),
            percent(sums.wrong as f64, sums.claimed as f64),
            percent(sums.saved, sums.empty),
            percent(f64::from(u32::try_from(wrong[0]).unwrap()), pixels as f64),
            wrong[1],
        );
        // On the others no pixel need be wrong: a block that a claim passes over may be clear along the ray.
        assert!(name != "blobs" || wrong[0] > 0, "{name}: a proof that nothing needs");
        assert_eq!(wrong[1], 0, "{name}");
        assert!(sums.saved > 0.2 * sums.empty && sums.saved <= sums.empty, "{name}: {sums:?}");
    }
}
