//! Targets of the RMSE over the kinds of random scenes: pictures large enough that a caster chooses steps and rays by a few of them.

use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

use vr_core::{Control, MIN_MAX_ERROR, Model, Renderer, StudiedRenderer, View};
use vr_physics::Reference;
use vr_physics::check::TestScene;
use vr_physics::check::strategies::Kind;
use vr_physics::metrics::Metrics;
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatter;
use vr_study::candidate::candidates;
use vr_study::choose::{BoundedRenderer, ChoiceError, draw_aimed, draw_within};
use vr_study::reference::ReferenceCache;
use vr_texslice::TextureSlicer;

use crate::Error;

/// Targets, one scene after the other.
const TARGETS: [f64; 2] = [0.01, 0.001];

/// Pixels along the sides of a picture.
const SIZE: [u32; 2] = [320, 240];

/// Tolerance of the reference.
const TOLERANCE: f64 = 1e-5;

/// Draws scenes of every kind within a target, and prints how often the whole picture is within it.
pub fn count(seeds: Range<u64>, out: &Path) -> Result<(), Error> {
    let control = Control::default();
    let renderers: Vec<Box<dyn StudiedRenderer>> = vec![
        Box::new(RayCaster::default()),
        Box::new(ShearWarp::default()),
        Box::new(TextureSlicer::default()),
        Box::new(Splatter::default()),
        Box::new(Reference::default()),
    ];
    let candidates = candidates(&renderers)?;
    let (mut kept, mut missed, mut unreached, mut searched) = (0, 0, 0, 0);
    let (mut ratios, mut shares) = (Vec::new(), Vec::new());
    println!(
        "seeds {} to {}, kinds and targets ({TARGETS:?}) in turns, pictures of {}x{} pixels, all of them compared",
        seeds.start, seeds.end, SIZE[0], SIZE[1]
    );
    println!(
        "| seed | kind | target | aim, or setting of a search | RMSE in targets | time of the choice in pictures |"
    );
    for seed in seeds {
        let kind = Kind::ALL[(seed % Kind::ALL.len() as u64) as usize];
        let TestScene { scene, view } = kind.draw(seed);
        let view = View { size: SIZE, supersampling: 1, ..view };
        let target = TARGETS[(seed / Kind::ALL.len() as u64) as usize % TARGETS.len()];
        let max_error = (target / 8.0).max(MIN_MAX_ERROR);
        let promising = RayCaster::default().with_max_error(max_error).expect("a ray caster promises")?;
        let bounded = [BoundedRenderer { renderer: promising, max_error }];
        let (cache, start) = (ReferenceCache::none(), Instant::now());
        // As `vr render` does it: a ray caster that aims at the target, and else a search.
        let seen = (&scene, &view);
        let aimed = draw_aimed(target, &RayCaster::default(), &bounded, seen, (&cache, &control))?;
        let drawn = match aimed {
            Some(aimed) => {
                let kind = if aimed.error.proven { "promised" } else { "aimed at" };
                let name = format!("{kind} {:.1e}, tried {}", aimed.aim, aimed.tried);
                Ok((name, aimed.rendered.frame, aimed.times, aimed.error))
            }
            None => {
                searched += 1;
                let choice = draw_within(target, &candidates, &bounded, seen, &cache, (&control, &|_| ()));
                choice.map(|c| (candidates[c.candidate].name(), c.rendered.frame, c.times, c.error))
            }
        };
        let (name, frame, times, error) = match drawn {
            Ok(drawn) => drawn,
            Err(e @ (ChoiceError::OutOfReach { .. } | ChoiceError::NoRenderer)) => {
                println!("seed {seed}, {}: {e}", kind.name());
                unreached += 1;
                continue;
            }
            Err(e) => return Err(e.into()),
        };
        let share = start.elapsed().as_secs_f64() / times.iter().sum::<Duration>().as_secs_f64().max(1e-9);
        let solution = Reference::new(TOLERANCE).solve(&scene, &view, &Model::Canonical, &control)?;
        let rgba: Vec<[f64; 4]> = solution.pixels.iter().map(|pixel| pixel.rgba).collect();
        let rmse = Metrics::of(&rgba, frame.pixels()).rmse;
        ratios.push(rmse / target);
        shares.push(share);
        println!("| {seed} | {} | {target} | {name} | {:.4} | {share:.1} |", kind.name(), rmse / target);
        if rmse <= target {
            kept += 1;
            continue;
        }
        missed += 1;
        println!(
            "seed {seed}, {}: RMSE {rmse:.2e} for {target}, by {name}, which told {:.2e} and at most {:.2e}; the reference is certain to {:.1e}",
            kind.name(),
            error.rmse,
            error.upper,
            solution.certainty().value()
        );
        std::fs::create_dir_all(out)?;
        let path = out.join(format!("target-{}-{seed}.toml", kind.name()));
        std::fs::write(
            &path,
            format!("# target-rmse {target}: {rmse:.2e}\n{}\n", TestScene { scene, view }.scene_file()?),
        )?;
    }
    let quantiles = |numbers: &mut Vec<f64>| {
        numbers.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let last = numbers.len().checked_sub(1)?;
            Some(numbers[(share * last as f64).round() as usize])
        };
        [0.1, 0.5, 0.9, 0.99, 1.0].map(|share| at(share).map_or("-".to_owned(), |x| format!("{x:.3}"))).join(" | ")
    };
    println!("kept {kept}, missed {missed}, out of reach {unreached}; by a search {searched}");
    println!("| | 10 % | median | 90 % | 99 % | largest |");
    println!("| RMSE of the whole picture, in targets | {} |", quantiles(&mut ratios));
    println!("| time of the choice, in times of the picture that it gives | {} |", quantiles(&mut shares));
    Ok(())
}
