//! A simple surface on the command line.

use glam::DVec3;
use vr_io::{FaceName, FinishEntry, ShapeEntry, SurfaceEntry};

use super::value::{grey_or_rgb, numbers};

/// What is expected of `--surface`.
const EXPECTED: &str = "expected SHAPE:PROPERTY..., as in sphere=0,2,0,0.3:emission=9; shapes are plane=POINT,NORMAL, sphere=CENTRE,RADIUS, \
                        triangle=P,Q,R, parallelogram=CORNER,EDGE,EDGE, box=LOW,HIGH (each a vector X,Y,Z); properties emission=RADIANCE, matte=SHARE, \
                        mirror=SHARE, gloss=EXPONENT,SHARE (each a number or R,G,B)";

/// Parses a surface: its shape, what it emits and how it reflects, as in `plane=0,-1,0,0,1,0:matte=0.8`.
pub fn surface(text: &str) -> Result<SurfaceEntry, String> {
    let mut parts = text.split(':');
    let shape = parts.next().and_then(shape).ok_or(EXPECTED)?;
    let mut entry = SurfaceEntry { shape, emission: [0.0; 3], reflectance: [0.0; 3], finish: FinishEntry::Matte };
    for part in parts {
        let (name, value) = part.split_once('=').ok_or(EXPECTED)?;
        match name.trim() {
            "emission" => entry.emission = grey_or_rgb(value)?,
            "matte" => (entry.finish, entry.reflectance) = (FinishEntry::Matte, grey_or_rgb(value)?),
            "mirror" => (entry.finish, entry.reflectance) = (FinishEntry::Mirror, grey_or_rgb(value)?),
            "gloss" => {
                let (exponent, share) = value.split_once(',').ok_or(EXPECTED)?;
                let exponent = exponent.trim().parse().map_err(|_| EXPECTED)?;
                (entry.finish, entry.reflectance) = (FinishEntry::Gloss(exponent), grey_or_rgb(share)?);
            }
            _ => return Err(EXPECTED.to_owned()),
        }
    }
    Ok(entry)
}

/// The shape that a name and its numbers say.
fn shape(text: &str) -> Option<ShapeEntry> {
    let (name, value) = text.split_once('=')?;
    let numbers: Vec<f64> = numbers(value, ',').ok()?;
    let vectors: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
    Some(match (name.trim(), &*vectors, numbers.len()) {
        ("plane", &[point, normal], 6) => ShapeEntry::Plane { point, normal },
        ("sphere", &[centre], 4) => ShapeEntry::Sphere { centre, radius: numbers[3] },
        ("triangle", &[a, b, c], 9) => ShapeEntry::Triangle([a, b, c]),
        ("parallelogram", &[corner, a, b], 9) => ShapeEntry::Parallelogram { corner, edges: [a, b] },
        ("box", &[low, high], 6) => ShapeEntry::Box { low, high, faces: FaceName::ALL.to_vec() },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_are_what_they_say() {
        let lamp = surface("sphere=0,2,0,0.5:emission=9").unwrap();
        assert_eq!(lamp.shape, ShapeEntry::Sphere { centre: DVec3::new(0.0, 2.0, 0.0), radius: 0.5 });
        assert_eq!((lamp.emission, lamp.reflectance), ([9.0; 3], [0.0; 3]));
        let floor = surface("plane=0,-1,0,0,1,0:gloss=20,0.5,0.25,0").unwrap();
        assert_eq!((floor.finish, floor.reflectance), (FinishEntry::Gloss(20.0), [0.5, 0.25, 0.0]));
        assert!(
            matches!(surface("box=0,0,0,1,1,1:mirror=1").unwrap().shape, ShapeEntry::Box { faces, .. } if faces.len() == 6)
        );
        for wrong in ["", "cube=1", "sphere=0,0,0", "sphere=0,0,0,1:", "sphere=0,0,0,1:gloss=1", "plane=0,0,0,0,1,x"] {
            assert!(surface(wrong).is_err(), "{wrong}");
        }
    }
}
