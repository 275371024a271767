//! Options of the renderer.

use vr_core::{Configurable, DeclaredOption, NumberRange, OptionTable};

use super::{LightRenderer, Method};

/// Largest number of paths of a ray, and of scatterings of a path.
const MAX_COUNT: f64 = 1e6;

impl Configurable for LightRenderer {
    fn options() -> OptionTable<Self> {
        let counts = NumberRange::at_least(1.0).up_to(MAX_COUNT);
        let methods = [("full", Method::Full), ("single", Method::Single)];
        OptionTable::new(
            Self::NAME,
            [
                DeclaredOption::<Self>::choice(
                    "model",
                    "light that is drawn: scattered any number of times (random paths), or once (no noise)",
                    methods,
                    |r| r.method,
                    |r, method| r.method = method,
                ),
                DeclaredOption::<Self>::number(
                    "paths",
                    "random paths for each pixel; half the noise takes four times as many",
                    counts,
                    |r| r.paths.into(),
                    |r, x| r.paths = x as u32,
                )
                .refuse("goes with model=full alone", |r| r.method == Method::Single && r.paths != 64),
                DeclaredOption::<Self>::number(
                    "error",
                    "standard error of the picture (RMS of its components) at which it needs no more paths; 0: each pixel takes all",
                    NumberRange::at_least(0.0).up_to(1.0),
                    |r| r.error,
                    |r, x| r.error = x,
                )
                .refuse("goes with model=full alone", |r| r.method == Method::Single && r.error != 0.0),
                DeclaredOption::<Self>::number(
                    "seconds",
                    "time after which a picture gets no more paths, of which paths are the most; 0: as long as it takes",
                    NumberRange::at_least(0.0).up_to(1e6),
                    |r| r.seconds,
                    |r, x| r.seconds = x,
                )
                .refuse("goes with model=full alone", |r| r.method == Method::Single && r.seconds != 0.0),
                DeclaredOption::<Self>::number(
                    "seed",
                    "seed of the random numbers; the same one gives the same bits",
                    NumberRange::at_least(0.0).up_to(4_294_967_295.0),
                    |r| r.seed.into(),
                    |r, x| r.seed = x as u32,
                ),
                DeclaredOption::<Self>::number(
                    "scatterings",
                    "largest number of scatterings of a path; 0: as many as there are",
                    NumberRange::at_least(0.0).up_to(MAX_COUNT),
                    |r| r.max_scatterings.unwrap_or(0).into(),
                    |r, x| r.max_scatterings = (x >= 1.0).then_some(x as u32),
                )
                .refuse("goes with model=full alone", |r| r.method == Method::Single && r.max_scatterings.is_some()),
                DeclaredOption::<Self>::number(
                    "step",
                    "step of model=single, in spacings of the volume; the error falls with its square",
                    NumberRange::at_least(1e-3).up_to(16.0),
                    |r| r.step,
                    |r, x| r.step = x,
                )
                .refuse("goes with model=single exact=false alone", |r| (r.method == Method::Full || r.exact) && r.step != 0.5),
                DeclaredOption::<Self>::switch(
                    "exact",
                    "model=single by quadrature with an account of its error, ray by ray: slow",
                    |r| r.exact,
                    |r, on| r.exact = on,
                )
                .refuse("goes with model=single alone", |r| r.method == Method::Full && r.exact),
            ],
        )
    }
}
