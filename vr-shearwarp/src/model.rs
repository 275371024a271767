//! The renderer's model for any ray: samples in slices, each for its share of the ray; without intermediate image, warp, codes
//! and tables, in f64.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use vr_core::optics::step_of_thickness;
use vr_core::transfer::Mixture;
use vr_core::{
    Classification, Control, DiscreteModel, GridVolume, Layer, RenderError, Scene, SegmentTerm, View, Voxel,
};

use crate::capabilities::last_sample;
use crate::factorization::IndexView;
use crate::lengths::length;
use crate::passes::{Pass, TexelLattice, passes};
use crate::ray_distances::RayDistances;
use crate::region::Region;
use crate::shear_warp::ShearWarp;
use crate::slices::{Sampling, Slice, Slices};
use crate::steepness::{reflects_by_interpolated_gradients, samples_filter_gradients};

/// The sum over slices.
pub(crate) struct SlicedModel {
    renderer: ShearWarp,
    scene: Scene,
    volume: Arc<GridVolume>,
    view: IndexView,
    size: [u32; 2],
    layer: Option<Layer>,
    passes: Vec<(Pass, Slices)>,
}

impl SlicedModel {
    pub(crate) fn new(
        renderer: &ShearWarp,
        (scene, volume): (&Scene, &Arc<GridVolume>),
        view: &View,
    ) -> Result<Self, RenderError> {
        let index_view = IndexView::new(view, volume.placement())?;
        let dims = volume.dims();
        let passes = match Region::of(view, volume.placement(), dims)? {
            None => Vec::new(),
            Some(region) => {
                let slices = |pass: &Pass| {
                    let layers = dims[pass.factorization.axes[2]];
                    let spacing = renderer.slice_spacing();
                    Slices::new(pass.factorization, &region, layers, spacing, Sampling::of(scene, volume, spacing))
                };
                let all = passes(&index_view, region.corners(), last_sample(dims), TexelLattice::of(renderer, volume))?;
                all.into_iter().map(|pass| (pass, slices(&pass))).collect()
            }
        };
        Ok(Self {
            renderer: renderer.clone(),
            scene: scene.clone(),
            volume: Arc::clone(volume),
            view: index_view,
            size: view.size,
            layer: scene.layer(view, &Control::default())?,
            passes,
        })
    }
}

impl DiscreteModel for SlicedModel {
    fn segments(&self, x: f64, y: f64) -> Vec<SegmentTerm> {
        let view = &self.view;
        for (pass, slices) in &self.passes {
            let f = &pass.factorization;
            let texel = f.texels_of_screen() * DVec3::new(x, y, 1.0);
            let at = texel.truncate() / texel.z;
            let mine = pass.within.is_none_or(|[x0, y0, x1, y1]| at.x >= x0 && at.y >= y0 && at.x <= x1 && at.y <= y1);
            if texel.z <= 0.0 || !mine {
                continue;
            }
            let mut chord = slices.chord(at.x, at.y);
            if let Some(layer) = &self.layer {
                let [w, h] = self.size.map(|n| n as usize);
                let end = layer.depth((y as usize).min(h - 1) * w + (x as usize).min(w - 1));
                chord[1] = chord[1].min(RayDistances::new(view, f).depth(DVec2::new(x, y), at, end));
            }
            let along = (f.sign * view.world_vector(f.step(at.x, at.y))).normalize();
            let distance = length(view, f, [at.x, at.y], self.renderer.correction) * slices.spacing;
            // What is interpolated after classification is so for one length everywhere.
            let interpolated =
                if view.is_perspective() { length(view, f, [0.0; 2], false) * slices.spacing } else { distance };
            let inside = |s: &&Slice| s.depth >= chord[0] - 1e-9 && s.depth <= chord[1] + 1e-9;
            return slices
                .slices
                .iter()
                .filter(inside)
                .map(|slice| {
                    let uv = slice.map.offset + slice.map.scale * at;
                    let length = distance * slices.share(slice.depth, chord);
                    let sample = self.sample(f.axes, along, uv, slice, [interpolated, length]);
                    SegmentTerm { transparency: 1.0 - sample[3], light: [sample[0], sample[1], sample[2]] }
                })
                .collect();
        }
        Vec::new()
    }
}

impl SlicedModel {
    /// Light and opacity of one sample of that length on a ray `along` a world direction; classified voxels are interpolated as samples of another.
    fn sample(
        &self,
        axes: [usize; 3],
        along: DVec3,
        uv: DVec2,
        slice: &Slice,
        [interpolated, length]: [f64; 2],
    ) -> [f64; 4] {
        let volume = &*self.volume;
        let dims = volume.dims();
        // The cell along u and v, and the position in it.
        let cell: [(usize, f64); 2] = std::array::from_fn(|a| {
            // `as` saturates.
            let i = (uv[a] as usize).min(dims[axes[a]] - 2);
            (i, (uv[a] - i as f64).clamp(0.0, 1.0))
        });
        let between = f64::from(slice.fraction);
        let edges = if self.renderer.slice_spacing() < 1.0 { 4 } else { 2 };
        // The corners: where they are, and how much they count by linear interpolation, and for values.
        let nearest = |t: f64| if t >= 0.5 { 1.0 } else { 0.0 };
        let mut corners = Vec::with_capacity(8);
        for edge in 0..edges {
            for right in 0..2 {
                let mut index = [0; 3];
                (index[axes[0]], index[axes[1]]) = (cell[0].0 + right, cell[1].0 + edge % 2);
                index[axes[2]] = slice.layer + edge / 2;
                let part = |high: bool, t: f64| if high { t } else { 1.0 - t };
                let weight = |[u, v, w]: [f64; 3]| {
                    let weight = part(right == 1, u) * part(edge % 2 == 1, v);
                    if edges == 4 { weight * part(edge >= 2, w) } else { weight }
                };
                let place = [cell[0].1, cell[1].1, between];
                let of_value = if slice.nearest { place.map(nearest) } else { place };
                corners.push((index, weight(place), weight(of_value)));
            }
        }
        let stored = |index: [usize; 3]| {
            let at = (index[2] * dims[1] + index[1]) * dims[0] + index[0];
            fn one<T: Voxel>(samples: &[T], at: usize) -> f64 {
                samples[at].to_f32().into()
            }
            vr_core::with_grid!(volume.values(), g => one(g.samples(), at))
        };
        let (calibration, transfer) = (volume.calibration(), &self.scene.transfer);
        if corners.iter().any(|&(index, ..)| stored(index).is_nan()) || length <= 0.0 {
            return [0.0; 4];
        }
        // Shading of a sample.
        let lit = |sample: [f64; 4], (factor, added): ([f64; 3], [f64; 3])| -> [f64; 4] {
            std::array::from_fn(|c| if c < 3 { sample[c] * factor[c] + sample[3] * added[c] } else { sample[3] })
        };
        // Classified voxels are interpolated, or the interpolated value is classified.
        match self.renderer.classification {
            Classification::Pre => {
                let mut sum = [0.0; 4];
                for &(index, _, weight) in &corners {
                    let gradient = self.gradient(index);
                    let sample = self.step(calibration.value(stored(index)), gradient.length(), interpolated);
                    let sample = self.tinted(sample, index.map(|i| i as f64));
                    let sample = lit(sample, self.reflection(gradient, along));
                    (0..4).for_each(|c| sum[c] += weight * sample[c]);
                }
                step_of_thickness(sum, length / interpolated)
            }
            Classification::Post => {
                let value: f64 = corners.iter().map(|&(index, _, weight)| weight * stored(index)).sum();
                // Where samples look at gradients, those are interpolated; else what normals reflect.
                let colored = self.scene.volume.colors().is_some();
                let interpolates = reflects_by_interpolated_gradients(&self.renderer, &self.scene);
                let of_filter = samples_filter_gradients(&self.scene);
                if of_filter || interpolates || self.scene.has_gradient_opacity() || colored {
                    let mut at = [0.0; 3];
                    (at[axes[0]], at[axes[1]], at[axes[2]]) = (uv.x, uv.y, slice.layer as f64 + between);
                    let inside = std::array::from_fn(|a| at[a].clamp(0.0, (dims[a] - 1) as f64));
                    let gradient = if of_filter {
                        self.world(volume.stored_and_gradient_at(at).1)
                    } else {
                        corners.iter().map(|&(index, weight, _)| weight * self.gradient(index)).sum()
                    };
                    let sample = self.tinted(self.step(calibration.value(value), gradient.length(), length), inside);
                    return lit(sample, self.reflection(gradient, along));
                }
                let (mut factor, mut added) = ([0.0; 3], [0.0; 3]);
                for &(index, weight, _) in &corners {
                    let (f, a) = self.reflection(self.gradient(index), along);
                    (0..3).for_each(|c| (factor[c], added[c]) = (factor[c] + weight * f[c], added[c] + weight * a[c]));
                }
                lit(transfer.step(calibration.value(value), length), (factor, added))
            }
        }
    }

    /// Light in the colour of its place in index space, where voxels have colours.
    fn tinted(&self, [r, g, b, alpha]: [f64; 4], at: [f64; 3]) -> [f64; 4] {
        let Some(colors) = self.scene.volume.colors() else { return [r, g, b, alpha] };
        let [x, y, z] = colors.color(at);
        [r * x, g * y, b * z, alpha]
    }

    /// Light and opacity of a homogeneous step of the medium of a value and a length of the gradient.
    fn step(&self, value: f64, steepness: f64, length: f64) -> [f64; 4] {
        let transfer = &self.scene.transfer;
        let modulation = self.scene.shading.as_ref().map_or(1.0, |shading| shading.modulation(steepness));
        if !self.scene.has_gradient_opacity() {
            transfer.step(value, length)
        } else if transfer.has_rows() {
            transfer.mixture(value, steepness).step(length)
        } else if transfer.has_emission() {
            // Light that is given stays what it is.
            let at = transfer.at(value);
            let extinction = if modulation == 0.0 { 0.0 } else { modulation * transfer.extinction(at.opacity) };
            Mixture { extinction, emission: at.emission }.step(length)
        } else {
            transfer.step(value, modulation * length)
        }
    }

    /// Gradient in the world of calibrated values at a sample; zero where nothing looks at it.
    fn gradient(&self, index: [usize; 3]) -> DVec3 {
        if self.scene.reflection().is_none() && !self.scene.has_gradient_opacity() {
            return DVec3::ZERO;
        }
        self.world(self.volume.central_differences_at_sample(index))
    }

    fn world(&self, gradient: [f64; 3]) -> DVec3 {
        self.volume.placement().gradient_to_world(gradient.into()) * self.volume.calibration().slope
    }

    /// Reflection of a gradient to a ray `along` a world direction: factor and summand of light.
    fn reflection(&self, gradient: DVec3, along: DVec3) -> ([f64; 3], [f64; 3]) {
        match self.scene.reflection() {
            Some(shading) => shading.along::<f64>(&self.scene.lights, along).reflect(gradient.to_array()),
            None => ([1.0; 3], [0.0; 3]),
        }
    }
}
