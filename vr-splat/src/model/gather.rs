//! The splats that a ray meets, in f64.

use glam::{DMat3, DVec3};
use vr_core::filter::Lattice;
use vr_core::{GridVolume, LatticeVisitor, Ray, Voxel};

use crate::ghosts::{BEYOND, Ghosts};
use crate::input::SplatInput;
use crate::kernel::Profile;
use crate::projection::SplatView;
use crate::sheets::{OwnSheets, widening};
use crate::splatter::Splatter;
use crate::visible::missing;

/// A ray, as splats are met by it.
pub(crate) struct Line {
    pub(crate) pixel: [u32; 2],
    /// In the world.
    pub(crate) direction: DVec3,
    lateral: [f64; 2],
    /// World length per unit of depth.
    pub(crate) stretch: f64,
    perspective: bool,
    base: f64,
    /// From the view to kernel space.
    axes: DMat3,
    /// Change in kernel space per unit of depth.
    along: DVec3,
    /// A grid's index at the view's base, and its change per unit of depth.
    index: [DVec3; 2],
}

impl Line {
    /// The ray through a point of the image, in pixels.
    pub(crate) fn new(view: &SplatView, input: &SplatInput, ray: &Ray, [x, y]: [f64; 2]) -> Self {
        let lateral = view.lateral(x, y);
        let axes = view.kernel.axes;
        let along = if view.perspective {
            axes.x_axis * lateral[0] + axes.y_axis * lateral[1] + axes.z_axis
        } else {
            axes.z_axis
        };
        let mut line = Self {
            pixel: [x as u32, y as u32],
            direction: ray.direction,
            lateral,
            stretch: view.stretch(lateral),
            perspective: view.perspective,
            base: view.base,
            axes,
            along,
            index: [DVec3::ZERO; 2],
        };
        if let SplatInput::Grid(grid) = input {
            let (origin, steps) = lattice_in_view(grid, view);
            let to_index = DMat3::from_cols(steps[0], steps[1], steps[2]).inverse();
            line.index = [to_index * (line.at(0.0) - origin), to_index * (line.at(1.0) - line.at(0.0))];
        }
        line
    }

    /// Position of the ray in the view, at a depth behind the base.
    fn at(&self, depth: f64) -> DVec3 {
        let lever = if self.perspective { depth + self.base } else { 1.0 };
        DVec3::new(self.lateral[0] * lever, self.lateral[1] * lever, depth)
    }

    /// Position of the ray in a grid at a depth, or the nearest one that is in it.
    pub(crate) fn index_at(&self, grid: &GridVolume, depth: f64) -> DVec3 {
        let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
        (self.index[0] + self.index[1] * depth).clamp(DVec3::ZERO, last)
    }

    /// Depth at which the ray crosses a layer of a grid.
    pub(crate) fn depth_at(&self, axis: usize, layer: u32) -> f64 {
        let step = self.index[1][axis];
        if step.abs() < 1e-12 { 0.0 } else { (f64::from(layer) - self.index[0][axis]) / step }
    }

    /// True if a grid's cell at a depth, so many voxels on, is vacuum.
    pub(crate) fn in_vacuum(&self, input: &SplatInput, depth: f64, ahead: f64) -> bool {
        let SplatInput::Grid(grid) = input else { return false };
        let place = self.index_at(grid, depth) + DVec3::splat(ahead);
        grid.vacuum_cells().is_some_and(|cells| cells.contains(place.to_array()))
    }
}

/// A splat in f64.
pub(crate) struct ExactSplat {
    pub(crate) place: DVec3,
    pub(crate) scale: f64,
    weight: f64,
    /// A calibrated value.
    pub(crate) value: f64,
    pub(crate) sheet: u32,
    /// A voxel's place in its grid; a point's number first.
    pub(crate) index: [usize; 3],
}

impl ExactSplat {
    /// Position of a ray in the splat's kernel space at the splat's depth, and its change per unit of depth.
    fn meet(&self, line: &Line) -> [DVec3; 2] {
        let beside = line.at(self.place.z) - self.place;
        [line.axes * beside * self.scale, line.along * self.scale]
    }

    /// The depths at which a ray enters its kernel, a ball, and leaves it; the wrong way round where it misses it.
    pub(crate) fn chord(&self, line: &Line) -> [f64; 2] {
        let [at, along] = self.meet(line);
        let square = along.length_squared();
        let ahead = at.dot(along) / square;
        let room = 1.0 - (at - along * ahead).length_squared();
        let half = if room > 0.0 { (room / square).sqrt() } else { f64::NEG_INFINITY };
        [self.place.z - ahead - half, self.place.z - ahead + half]
    }

    /// ∫ of its kernel between two depths, in world units.
    pub(crate) fn section(&self, profile: &Profile, line: &Line, from: f64, to: f64) -> f64 {
        let [at, along] = self.meet(line);
        let [from, to] = [from, to].map(|d| (d - self.place.z).clamp(-1e12, 1e12));
        profile.integral(at.to_array(), along.to_array(), from, to) * line.stretch * self.weight
    }

    /// ∫ of the gradient of its kernel, which is radial, between two depths: along the view's axes, and over a length in the world.
    pub(crate) fn gradient_section(&self, profile: &Profile, line: &Line, from: f64, to: f64) -> DVec3 {
        let Profile::Radial(radial) = profile else { return DVec3::ZERO };
        let [at, along] = self.meet(line);
        let speed = along.length();
        let direction = along / speed;
        let ahead = at.dot(direction);
        let across = at - direction * ahead;
        let b = across.length();
        let edge = (1.0 - b * b).max(0.0).sqrt();
        let [from, to] = [from, to].map(|d| ((d - self.place.z) * speed + ahead).clamp(-edge, edge));
        let turn = radial.slope_section(b, from, to);
        let rise = radial.at(b.hypot(to)) - radial.at(b.hypot(from));
        (across * turn + direction * rise) * self.weight
    }

    /// Its kernel at a depth.
    pub(crate) fn at(&self, profile: &Profile, line: &Line, depth: f64) -> f64 {
        let [at, along] = self.meet(line);
        profile.at((at + along * (depth - self.place.z)).to_array()) * self.weight
    }
}

/// All splats that a ray may meet, in the order in which they lie in memory.
pub(crate) fn gather(
    renderer: &Splatter,
    input: &SplatInput,
    view: &SplatView,
    line: &Line,
    own: Option<&OwnSheets>,
    ghosts: Option<&Ghosts>,
) -> Vec<ExactSplat> {
    match input {
        SplatInput::Grid(grid) => {
            let (origin, steps) = lattice_in_view(grid, view);
            let missing = missing(grid);
            let calibration = grid.calibration();
            let beyond = DVec3::splat(ghosts.map_or(0.0, |_| BEYOND as f64));
            let widened = |depth: f64| widening(renderer, view, depth);
            // Kernels are widest where pixels are: at the deepest corner of the grid.
            let last = grid.dims().map(|n| (n - 1) as f64);
            let deepest = origin.z + (0..3).map(|a| (steps[a].z * last[a]).max(0.0)).sum::<f64>();
            let reach = renderer.kernel.reach().map(|reach| reach * widened(deepest));
            let near = NearLine { index: [line.index[0] + beyond, line.index[1]], reach };
            let found = match ghosts {
                Some(ghosts) => near.visit(ghosts.lattice()),
                None => grid.with_lattice(near),
            };
            let weight = 1.0 / renderer.kernel.reach().into_iter().product::<f64>();
            let splat = |(at, stored): ([usize; 3], f64)| {
                let place = origin + (0..3).map(|a| steps[a] * (at[a] as f64 - beyond[a])).sum::<DVec3>();
                let scale = 1.0 / widened(place.z);
                ExactSplat {
                    place,
                    scale,
                    weight: weight * scale * scale * scale,
                    value: calibration.value(stored),
                    sheet: own.map_or(0, |own| own.order[at[own.axis]]),
                    index: at,
                }
            };
            let [nx, ny, _] = grid.dims();
            let lit = renderer.splats_light();
            let there = |(at, _): &([usize; 3], f64)| !(lit && missing((at[2] * ny + at[1]) * nx + at[0]));
            found.into_iter().filter(there).map(splat).collect()
        }
        SplatInput::Points(points) => {
            let splat = |k: usize| {
                let place = view.place(points.positions()[k]);
                let low_pass = renderer.low_pass * view.pixel_at(place.z) * view.unit;
                let radius = f64::from(points.radii()[k]).hypot(low_pass);
                ExactSplat {
                    place,
                    scale: view.unit / radius,
                    weight: f64::from(points.weights()[k]) / (radius * radius * radius),
                    value: f64::from(points.values()[k]),
                    sheet: 0,
                    index: [k, 0, 0],
                }
            };
            let met = |s: &ExactSplat| {
                let [at, along] = s.meet(line);
                let foot = at - along * (at.dot(along) / along.length_squared());
                foot.length_squared() < 1.0
            };
            (0..points.count()).map(splat).filter(met).collect()
        }
    }
}

/// The place of the first sample of a grid, and the change from one to the next along each axis.
fn lattice_in_view(grid: &GridVolume, view: &SplatView) -> (DVec3, [DVec3; 3]) {
    let axes = grid.placement().axes();
    let steps = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| view.place_of_vector(a));
    (view.place(grid.placement().origin()), steps)
}

/// Finds the samples whose kernels a line may meet.
struct NearLine {
    index: [DVec3; 2],
    reach: [f64; 3],
}

impl LatticeVisitor for NearLine {
    type Output = Vec<([usize; 3], f64)>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        let [from, step] = self.index;
        let main = (0..3).fold(0, |best, a| if step[a].abs() > step[best].abs() { a } else { best });
        let (a, b) = ((main + 1) % 3, (main + 2) % 3);
        let mut found = Vec::new();
        for layer in 0..lattice.dims[main] {
            let at = from + step * ((layer as f64 - from[main]) / step[main]);
            // Within a kernel, the line goes aside by its slope.
            let range = |axis: usize| {
                let wide = self.reach[axis] + (step[axis] / step[main]).abs() * self.reach[main] + 1e-6;
                let last = lattice.dims[axis] as f64 - 1.0;
                let (first, end) = ((at[axis] - wide).ceil().max(0.0), (at[axis] + wide).floor().min(last));
                if first <= end { first as usize..end as usize + 1 } else { 0..0 }
            };
            for i in range(a) {
                for j in range(b) {
                    let mut index = [0; 3];
                    (index[main], index[a], index[b]) = (layer, i, j);
                    let sample = lattice.samples[(index[2] * lattice.dims[1] + index[1]) * lattice.dims[0] + index[0]];
                    found.push((index, f64::from(sample.to_f32())));
                }
            }
        }
        // As the renderer meets them.
        found.sort_by_key(|(at, _)| (at[2], at[1], at[0]));
        found
    }
}
