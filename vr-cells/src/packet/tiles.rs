//! Tiles of a picture whose rays are marched sixteen at once.

use std::sync::Mutex;

use fearless_simd::Level;
use vr_core::image_order::{ImageSample, PixelValue, in_parallel};
use vr_core::parallel::locked;
use vr_core::{CellMesh, Control, Counts, Layer, Light as Lamp, Ray, Rays, RenderError, Shading, View};
use vr_kernels::vector::{LANES, PacketLights, SeenLights, run};

use super::entries::{Entry, Gate, Grid, Place};
use super::integral::{Integral, Lit};
use super::links::{Links, OUTSIDE};
use super::march::{GROUPS, March, MarchScene, STEPS, Sixteen, Trail};
use super::projected::{Projected, in_two};
use super::segments::Segments;
use super::stretches::{Cut, Hard, Spot, Stretches};
use crate::accumulators::Seen;
use crate::camera_space::CameraSpace;
use crate::entries::{Entries, TILE};
use crate::medium::{Crossing, Light, Medium};

/// Steps without progress after which a ray is left to the plain code: more cells than meet in a vertex.
const PATIENCE: i32 = 256;

/// Lanes of all groups.
const ALL_LANES: usize = GROUPS * LANES;

/// Everything that the rays of a view have in common.
///
/// `N` is the number of attributes of the mesh: 1 for values, 4 with gradients, which are shaded.
pub(crate) struct Packets<'a, const N: usize> {
    pub(crate) mesh: &'a CellMesh,
    pub(crate) links: &'a Links,
    pub(crate) projected: &'a Projected,
    pub(crate) segments: &'a Segments,
    pub(crate) entries: &'a Entries<'a>,
    pub(crate) camera: &'a CameraSpace,
    pub(crate) medium: &'a Medium<'a>,
    pub(crate) view: &'a View,
    pub(crate) layer: Option<&'a Layer>,
    /// Transparency at which a ray may end.
    pub(crate) opaque: f64,
    /// Shading, and lights.
    pub(crate) lit: Option<(&'a Shading, &'a [Lamp])>,
    pub(crate) buffers: Mutex<Vec<Box<Buffers<N>>>>,
}

/// A ray of a tile.
struct TileRay {
    ray: Ray,
    sample: ImageSample,
    /// Length for each unit of depth.
    scale: f64,
    /// Depths between which it is drawn.
    part: [f64; 2],
    /// Entries of the ray that it has not tried yet.
    entries: std::ops::Range<usize>,
    /// Number of the piece of the transfer function that held last.
    piece: usize,
    rgb: [f64; 3],
    clear: f64,
    /// World distance at which half of the light is left.
    half: Option<f64>,
    parts: u64,
    /// True if it is left to the plain code.
    stuck: bool,
}

/// Buffers of a tile.
pub(crate) struct Buffers<const N: usize> {
    places: Vec<Place>,
    rays: Vec<TileRay>,
    entries: Vec<Entry>,
    /// Entries as they are found, face by face.
    found: Vec<Entry>,
    stretches: Stretches<N>,
    groups: [Sixteen<N>; GROUPS],
    trails: [Trail<N>; GROUPS],
    /// The lights as the ray of each lane sees them, and those of sixteen stretches.
    of_lanes: Vec<SeenLights>,
    lights: PacketLights,
}

impl<const N: usize> Default for Buffers<N> {
    fn default() -> Self {
        Self {
            places: Vec::new(),
            rays: Vec::new(),
            entries: Vec::new(),
            found: Vec::new(),
            stretches: Stretches::default(),
            groups: std::array::from_fn(|_| Sixteen::default()),
            trails: std::array::from_fn(|_| Trail::default()),
            of_lanes: vec![SeenLights::default(); ALL_LANES],
            lights: PacketLights::default(),
        }
    }
}

impl<const N: usize> Packets<'_, N> {
    /// Draws all pixels; `plain` draws a single ray and counts it.
    pub(crate) fn draw(
        &self,
        control: &Control,
        plain: impl Fn(&Ray, ImageSample, &mut Counts) -> Seen + Sync,
    ) -> Result<(Vec<Seen>, Counts), RenderError> {
        let rays = Rays::new(self.view)?;
        let [width, height] = self.view.size;
        // Tiles lie in those of the entries, and have at most about 256 rays.
        let edge = (TILE / self.view.supersampling.next_power_of_two()).max(1);
        let (across, down) = (width.div_ceil(edge), height.div_ceil(edge));
        let level = Level::new();
        let one = |tile: u32| {
            let corner = [tile % across * edge, tile / across * edge];
            let size = [edge.min(width - corner[0]), edge.min(height - corner[1])];
            let mut counts = Counts::default();
            (self.tile(level, &rays, corner, size, &mut counts, &plain), counts)
        };
        // A row of tiles is a piece of work: its buffers are made once.
        let mut image = vec![Seen::NOTHING; width as usize * height as usize];
        let mut counts = Counts::default();
        for (tile, (values, more)) in in_parallel(control, across * down, one)?.into_iter().enumerate() {
            counts += more;
            let [x, y] = [tile as u32 % across * edge, tile as u32 / across * edge];
            let row = edge.min(width - x) as usize;
            for (i, values) in values.chunks(row).enumerate() {
                let start = (y as usize + i) * width as usize + x as usize;
                image[start..start + row].copy_from_slice(values);
            }
        }
        Ok((image, counts))
    }

    /// Draws the pixels of a tile, row by row.
    fn tile(
        &self,
        level: Level,
        rays: &Rays,
        corner: [u32; 2],
        size: [u32; 2],
        counts: &mut Counts,
        plain: &impl Fn(&Ray, ImageSample, &mut Counts) -> Seen,
    ) -> Vec<Seen> {
        // Buffers go from tile to tile.
        let mut buffers = locked(&self.buffers).pop().unwrap_or_default();
        self.begin(rays, corner, size, &mut buffers);
        self.march(level, &mut buffers);

        // The pixels: of each, the rays of its rows.
        let n = self.view.supersampling as usize;
        let across = size[0] as usize * n;
        let mut of_pixel = Vec::with_capacity(n * n);
        let mut pixels = Vec::with_capacity((size[0] * size[1]) as usize);
        for (y, x) in (0..size[1] as usize).flat_map(|y| (0..size[0] as usize).map(move |x| (y, x))) {
            of_pixel.clear();
            for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
                let ray = &buffers.rays[(y * n + row) * across + x * n + column];
                of_pixel.push(if ray.stuck { plain(&ray.ray, ray.sample, counts) } else { self.seen(ray, counts) });
            }
            pixels.push(if n == 1 { of_pixel[0] } else { Seen::mean(&of_pixel) });
        }
        locked(&self.buffers).push(buffers);
        pixels
    }

    /// The rays of a tile, and where they enter the mesh.
    fn begin(&self, rays: &Rays, corner: [u32; 2], size: [u32; 2], buffers: &mut Buffers<N>) {
        let n = self.view.supersampling;
        let [width, height] = self.view.size.map(f64::from);
        let centre = |first: u32, i: u32| f64::from(first) + (f64::from(i) + 0.5) / f64::from(n);
        let [middle, half] = self.projected.depth;
        buffers.places.clear();
        buffers.rays.clear();
        buffers.found.clear();
        for row in 0..size[1] * n {
            for column in 0..size[0] * n {
                let (x, y) = (centre(corner[0], column), centre(corner[1], row));
                let pixel =
                    (corner[1] + row / n) as usize * self.view.size[0] as usize + (corner[0] + column / n) as usize;
                let ray = rays.at(x, y);
                let scale = self.camera.axis(&ray).length;
                let far = self.layer.map_or(f64::INFINITY, |layer| layer.depth(pixel));
                let [from, to] = ray.inside(&self.view.clip).map_or([1.0, 0.0], |[from, to]| [from, to.min(far)]);
                let part = [from, to].map(|s| (s / scale - middle) / half);
                let ([x_high, x_low], [y_high, y_low]) = (in_two(x - 0.5 * width), in_two(0.5 * height - y));
                buffers.places.push([x_high, y_high, x_low, y_low]);
                buffers.rays.push(TileRay {
                    ray,
                    sample: ImageSample { pixel, x, y },
                    scale,
                    part,
                    entries: 0..0,
                    piece: 0,
                    rgb: [0.0; 3],
                    clear: 1.0,
                    half: None,
                    parts: 0,
                    stuck: false,
                });
            }
        }
        let grid = Grid {
            places: &buffers.places,
            across: (size[0] * n) as usize,
            first: [centre(corner[0], 0) - 0.5 * width, 0.5 * height - centre(corner[1], 0)],
            spacing: 1.0 / f64::from(n),
        };
        for face in self.entries.near(f64::from(corner[0]), f64::from(corner[1])) {
            grid.enter(self.mesh, self.projected, face, &mut buffers.found);
        }
        sort_by_ray(&buffers.found, buffers.rays.len(), &mut buffers.entries);
        let mut start = 0;
        for of_ray in buffers.entries.chunk_by_mut(|a, b| a.ray == b.ray) {
            of_ray.sort_unstable_by(|a, b| a.depth.total_cmp(&b.depth));
            let ray = &mut buffers.rays[of_ray[0].ray as usize];
            if ray.part[0] < ray.part[1] {
                ray.entries = start..start + of_ray.len();
            }
            start += of_ray.len();
        }
    }

    /// Marches the rays of a tile.
    fn march(&self, level: Level, buffers: &mut Buffers<N>) {
        let Buffers { places, rays, entries, stretches, groups, trails, of_lanes, lights, .. } = buffers;
        let scene = MarchScene {
            links: self.links.rows(),
            vertices: &self.projected.vertices,
            gradients: &self.projected.gradients,
            widening: self.projected.widening,
        };
        let mut waiting = 0..rays.len();
        let mut of_lane = [None; ALL_LANES];
        loop {
            // Lanes that stand still get the next entry of their ray, or the next ray.
            for (all, of_lane) in of_lane.iter_mut().enumerate() {
                let (group, lane) = (&mut groups[all / LANES], all % LANES);
                while group.places[lane] == OUTSIDE {
                    let Some(i) = of_lane.or_else(|| waiting.next()) else { break };
                    let reached = of_lane.map(|_| group.reached(lane));
                    if let (None, Some((_, lights))) = (&of_lane, self.lit) {
                        of_lanes[all] = SeenLights::along(lights, rays[i].ray.direction);
                    }
                    let enters = self.enter(&mut rays[i], &places[i], entries, reached, group, lane);
                    *of_lane = enters.then_some(i);
                }
            }
            if of_lane.iter().all(Option::is_none) {
                return;
            }
            run(level, March { scene, rays: groups, trails });

            // What the rays have passed, its light, and which of them end.
            stretches.clear();
            let mut ends = [0; ALL_LANES];
            let mut past = [false; ALL_LANES];
            for i in 0..ALL_LANES {
                if let Some(ray) = of_lane[i] {
                    past[i] = self.pass(rays, ray, (&groups[i / LANES], &trails[i / LANES]), i, stretches);
                }
                ends[i] = stretches.rows.len();
            }
            let lit = self.lit.map(|(shading, _)| Lit { shading, of_lanes, lights });
            run(level, Integral { segments: self.segments, stretches, lit });
            self.solve_hard(rays, stretches);
            let mut start = 0;
            for i in 0..ALL_LANES {
                let of_ray = start..ends[i];
                start = ends[i];
                let Some(ray) = of_lane[i] else { continue };
                let (ray, group, lane) = (&mut rays[ray], &mut groups[i / LANES], i % LANES);
                for k in of_ray {
                    self.add(ray, stretches, k);
                }
                ray.stuck = group.waited[lane] > PATIENCE;
                if past[i] || ray.clear <= self.opaque || ray.stuck {
                    of_lane[i] = None;
                    group.places[lane] = OUTSIDE;
                }
            }
        }
    }

    /// Puts a ray into a lane where it enters the mesh next, beyond what it has reached; false if it does not.
    fn enter(
        &self,
        ray: &mut TileRay,
        place: &Place,
        entries: &[Entry],
        reached: Option<f64>,
        sixteen: &mut Sixteen<N>,
        lane: usize,
    ) -> bool {
        for entry in &entries[ray.entries.clone()] {
            ray.entries.start += 1;
            // On an edge of the surface two faces are entered at once, and the first way has gone through what lies behind the second.
            if reached.is_some_and(|reached| entry.depth < reached - 1e-6) {
                continue;
            }
            let Some(gate) = Gate::new(self.mesh, self.projected, entry.face, place) else { continue };
            // Depth and value are counted from those of the place.
            let [depth, value] = gate.depth_value(self.projected);
            let ([high_depth, low_depth], [high_value, low_value]) = (in_two(depth), in_two(value));
            for (lanes, x) in sixteen.base.iter_mut().zip([high_depth, high_value, low_depth, low_value]) {
                lanes.0[lane] = x;
            }
            for (i, name) in gate.names.into_iter().enumerate() {
                let [of_depth, of_value] = self.projected.vertices[name as usize].depth_value();
                let [x, y] = gate.corners[i];
                for (lanes, x) in sixteen.corners[i].iter_mut().zip([x, y, (of_depth - depth) as f32]) {
                    lanes.0[lane] = x;
                }
                let attributes = self.attributes(name, (of_value - value) as f32);
                for (lanes, x) in sixteen.attributes[i].iter_mut().zip(attributes) {
                    lanes.0[lane] = x;
                }
            }
            for i in 0..N {
                let of_corners = sixteen.attributes.each_ref().map(|attributes| f64::from(attributes[i].0[lane]));
                sixteen.here[i].0[lane] = gate.at_place(of_corners) as f32;
            }
            sixteen.depth.0[lane] = reached.map_or(0.0, |reached| (reached - depth).max(0.0) as f32);
            for (lanes, x) in sixteen.weights.iter_mut().zip(gate.weights) {
                lanes.0[lane] = x;
            }
            for (lanes, x) in sixteen.ray.iter_mut().zip(*place) {
                lanes.0[lane] = x;
            }
            sixteen.waited[lane] = 0;
            sixteen.places[lane] = 4 * (4 * entry.face.cell + u32::from(entry.face.across));
            return true;
        }
        false
    }

    /// Attributes of a vertex that has a value.
    #[inline]
    fn attributes(&self, vertex: u32, value: f32) -> [f32; N] {
        let mut attributes = [value; N];
        if let [_, rest @ ..] = &mut attributes[..]
            && let Some(gradient) = self.projected.gradients.get(vertex as usize)
        {
            rest.copy_from_slice(&gradient[..rest.len()]);
        }
        attributes
    }

    /// Cuts what the ray of a lane has passed into stretches; true if it is past its end.
    #[inline]
    fn pass(
        &self,
        rays: &mut [TileRay],
        number: usize,
        (sixteen, trail): (&Sixteen<N>, &Trail<N>),
        all: usize,
        stretches: &mut Stretches<N>,
    ) -> bool {
        let (ray, lane) = (&mut rays[number], all % LANES);
        let cut = Cut { segments: self.segments, scale: ray.scale, clear: ray.clear as f32, ray: number, lane: all };
        let [from, to] = ray.part;
        let [base_depth, base_value] = sixteen.base_of(lane);
        let spot = |step: usize| {
            let mut attributes = [0.0; N];
            for (x, lanes) in attributes.iter_mut().zip(&trail.attributes[step]) {
                *x = f64::from(lanes.0[lane]);
            }
            attributes[0] += base_value;
            Spot { depth: base_depth + f64::from(trail.depths[step].0[lane]), attributes }
        };
        let mut start = spot(0);
        for step in 1..=STEPS {
            let end = spot(step);
            if end.depth > start.depth {
                let mut ends = [start, end];
                if start.depth < from || end.depth > to {
                    let at = |depth: f64| start.towards(&end, (depth - start.depth) / (end.depth - start.depth));
                    ends = [at(start.depth.max(from)), at(end.depth.min(to))];
                }
                if ends[0].depth < ends[1].depth {
                    ray.parts += 1;
                    stretches.add(&cut, ends, &mut ray.piece);
                }
                if end.depth >= to {
                    return true;
                }
            }
            start = end;
        }
        false
    }

    /// The light of stretches that are left to the plain code.
    fn solve_hard(&self, rays: &[TileRay], stretches: &mut Stretches<N>) {
        for hard in &stretches.hard {
            let (light, _) = self.solve_plainly(&rays[hard.ray], hard, 0.0);
            let [r, g, b] = light.rgb.map(|x| x as f32);
            stretches.light[hard.number] = [r, g, b, (1.0 - light.clear) as f32];
        }
    }

    /// The light of a stretch by the plain code, and the world distance at which no more than `level` is left.
    fn solve_plainly(&self, ray: &TileRay, hard: &Hard<N>, level: f64) -> (Light, Option<f64>) {
        let [middle, half] = self.projected.depth;
        let [low, range] = self.projected.value;
        let ends = hard.ends.map(|end| (middle + half * end.depth) * ray.scale);
        let values = hard.ends.map(|end| low + range * end.attributes[0]);
        let gradient = |end: &Spot<N>| match end.attributes[..] {
            [_, x, y, z] => [x, y, z].map(|x| self.projected.slope * x),
            _ => [0.0; 3],
        };
        let shade = self.lit.map(|(shading, lights)| shading.along(lights, ray.ray.direction));
        let gradients = shade.is_some().then(|| hard.ends.each_ref().map(gradient));
        let mut light = Light::NONE;
        let mut crossing = Crossing { level, at: None, ends: false };
        self.medium.add(&mut light, ends, values, gradients, shade.as_ref(), &mut crossing);
        (light, crossing.at)
    }

    /// Adds a stretch to its ray.
    #[inline]
    fn add(&self, ray: &mut TileRay, stretches: &Stretches<N>, k: usize) {
        let [r, g, b, opacity] = stretches.light[k].map(f64::from);
        for (sum, light) in ray.rgb.iter_mut().zip([r, g, b]) {
            *sum += ray.clear * light;
        }
        let left = ray.clear * (1.0 - opacity);
        if left < 0.5 && ray.clear >= 0.5 {
            ray.half = Some(self.half_way(ray, stretches, k));
        }
        ray.clear = left;
    }

    /// World distance at which half of the light is left, inside a stretch: extinction is taken to be linear in the depth.
    fn half_way(&self, ray: &TileRay, stretches: &Stretches<N>, k: usize) -> f64 {
        if let Some(hard) = stretches.hard.iter().find(|hard| hard.number == k)
            && let (_, Some(at)) = self.solve_plainly(ray, hard, 0.5 / ray.clear)
        {
            return at;
        }
        let [from, to, _, piece] = stretches.rows[k];
        let of_ends = [from, to].map(|t| self.segments.extinction(self.segments.opacity(piece.to_bits() as usize, t)));
        let [a, b] = of_ends.map(f64::from);
        let opacity = f64::from(stretches.light[k][3]);
        // The part of the stretch's depth after which half is left: a t + (b − a) t²/2 = part (a + b)/2.
        let part = ((2.0 * ray.clear).ln() / -(-opacity).ln_1p()).clamp(0.0, 1.0);
        let t = if a + b > 0.0 && (a + b).is_finite() {
            let wanted = part * (a + b);
            wanted / (a + (a * a + (b - a) * wanted).max(0.0).sqrt())
        } else {
            0.0
        };
        let [start, end] = stretches.depths[k];
        let [middle, half] = self.projected.depth;
        (middle + half * (start + (end - start) * t)) * ray.scale
    }

    /// The pixel of a ray.
    fn seen(&self, ray: &TileRay, counts: &mut Counts) -> Seen {
        counts.rays += u64::from(ray.parts > 0);
        counts.samples += ray.parts;
        let [r, g, b] = ray.rgb;
        let seen = Seen { rgba: [r, g, b, 1.0 - ray.clear], depth: ray.half.unwrap_or(f64::INFINITY) };
        seen.before(self.layer, ray.sample.pixel)
    }
}

/// Sorts entries by their rays: counts, then places.
fn sort_by_ray(found: &[Entry], rays: usize, sorted: &mut Vec<Entry>) {
    let mut next = vec![0; rays + 1];
    for entry in found {
        next[entry.ray as usize + 1] += 1;
    }
    for ray in 0..rays {
        next[ray + 1] += next[ray];
    }
    sorted.clear();
    sorted.extend_from_slice(found);
    for entry in found {
        let place: &mut usize = &mut next[entry.ray as usize];
        sorted[*place] = *entry;
        *place += 1;
    }
}
