//! Masks: the parts of pixels that shapes cover, antialiased.

use ab_glyph_rasterizer::{Point, Rasterizer, point};

/// Coverage of the pixels of a rectangle by shapes.
pub struct Mask {
    /// Pixel of the upper left corner.
    origin: [i32; 2],
    size: [usize; 2],
    coverage: Vec<f32>,
}

impl Mask {
    /// Makes a mask without shapes for those between two corners, the upper left one and the lower right one, in pixels.
    pub fn new(low: [f32; 2], high: [f32; 2]) -> Self {
        let origin = low.map(|x| x.floor() as i32);
        // The casts saturate; a mask is no larger than what is drawn in it.
        let size = [0, 1].map(|c| (i64::from(high[c].ceil() as i32) - i64::from(origin[c])).clamp(0, 1 << 16) as usize);
        Self { origin, size, coverage: vec![0.0; size[0] * size[1]] }
    }

    /// Adds the inside of a polygon.
    pub fn add_polygon(&mut self, corners: &[[f32; 2]]) {
        let corners: Vec<Point> = corners.iter().map(|&[x, y]| point(x, y)).collect();
        let low = corners.iter().fold([f32::INFINITY; 2], |[x, y], p| [x.min(p.x), y.min(p.y)]);
        let high = corners.iter().fold([f32::NEG_INFINITY; 2], |[x, y], p| [x.max(p.x), y.max(p.y)]);
        if !(low[0] < high[0] && low[1] < high[1]) {
            return;
        }
        let corner = low.map(f32::floor);
        let [w, h] = [0, 1].map(|c| (high[c].ceil() - corner[c]).clamp(1.0, 65536.0) as usize);
        let mut rasterizer = Rasterizer::new(w, h);
        let inside = |p: Point| point(p.x - corner[0], p.y - corner[1]);
        for (i, &from) in corners.iter().enumerate() {
            rasterizer.draw_line(inside(from), inside(corners[(i + 1) % corners.len()]));
        }
        let at = corner.map(|c| c as i32);
        rasterizer.for_each_pixel_2d(|x, y, coverage| self.add([at[0] + x as i32, at[1] + y as i32], coverage));
    }

    /// Adds a rectangle.
    pub fn add_rectangle(&mut self, [x, y]: [f32; 2], [width, height]: [f32; 2]) {
        self.add_polygon(&[[x, y], [x + width, y], [x + width, y + height], [x, y + height]]);
    }

    /// Adds a line of a width.
    pub fn add_line(&mut self, [ax, ay]: [f32; 2], [bx, by]: [f32; 2], width: f32) {
        let (dx, dy) = (bx - ax, by - ay);
        let half = 0.5 * width / dx.hypot(dy).max(1e-6);
        let (nx, ny) = (-dy * half, dx * half);
        self.add_polygon(&[[ax + nx, ay + ny], [bx + nx, by + ny], [bx - nx, by - ny], [ax - nx, ay - ny]]);
    }

    /// Adds a disc.
    pub fn add_disc(&mut self, [x, y]: [f32; 2], radius: f32) {
        // Sides that leave the circle by a fiftieth of a pixel at most.
        let sides = (16.0 + 8.0 * radius.sqrt()) as usize;
        let corner = |k: usize| {
            let angle = std::f32::consts::TAU * k as f32 / sides as f32;
            [x + radius * angle.cos(), y + radius * angle.sin()]
        };
        self.add_polygon(&(0..sides).map(corner).collect::<Vec<_>>());
    }

    /// Adds to the coverage of a pixel, as if what is there and what is added had nothing to do with each other.
    pub fn add(&mut self, [x, y]: [i32; 2], coverage: f32) {
        let (x, y) = (i64::from(x) - i64::from(self.origin[0]), i64::from(y) - i64::from(self.origin[1]));
        let inside = |k: i64, n: usize| (0..n as i64).contains(&k);
        if inside(x, self.size[0]) && inside(y, self.size[1]) {
            let there = &mut self.coverage[y as usize * self.size[0] + x as usize];
            *there += (1.0 - *there) * coverage.abs().min(1.0);
        }
    }

    /// Returns the mask grown by a radius all around.
    pub fn grown(&self, radius: f32) -> Self {
        let reach = radius.ceil() as i32;
        let [x, y] = self.origin;
        let [w, h] = self.size.map(|n| n as i32 + 2 * reach);
        let origin = [x - reach, y - reach];
        let mut grown = vec![0.0f32; w as usize * h as usize];
        // Soft edges stay soft: the rim of the disc that each pixel becomes fades over a pixel.
        let offsets: Vec<(i32, i32, f32)> = (-reach..=reach)
            .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
            .map(|(dx, dy)| (dx, dy, (radius + 1.0 - (dx as f32).hypot(dy as f32)).clamp(0.0, 1.0)))
            .filter(|offset| offset.2 > 0.0)
            .collect();
        for ([px, py], coverage) in self.covered() {
            for &(dx, dy, share) in &offsets {
                let at = (py + dy - origin[1]) as usize * w as usize + (px + dx - origin[0]) as usize;
                grown[at] = grown[at].max(coverage * share);
            }
        }
        Self { origin, size: [w as usize, h as usize], coverage: grown }
    }

    /// Returns the pixels that are covered, and by how much, row by row.
    pub fn covered(&self) -> impl Iterator<Item = ([i32; 2], f32)> {
        let ([x, y], w) = (self.origin, self.size[0].max(1));
        let place = move |i: usize| [x + (i % w) as i32, y + (i / w) as i32];
        self.coverage.iter().enumerate().filter(|(_, c)| **c > 0.0).map(move |(i, &c)| (place(i), c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mask: &Mask) -> f32 {
        mask.covered().map(|(_, coverage)| coverage).sum()
    }

    #[test]
    fn coverage_is_area() {
        let mut mask = Mask::new([-3.0, -3.0], [20.0, 20.0]);
        mask.add_rectangle([-1.25, 0.5], [3.0, 2.25]);
        assert!((area(&mask) - 3.0 * 2.25).abs() < 1e-3, "{}", area(&mask));
        let mut mask = Mask::new([0.0, 0.0], [20.0, 20.0]);
        mask.add_disc([9.6, 10.1], 7.0);
        // The polygon's own area: n/2 sin(2π/n) r².
        let sides = (16.0 + 8.0 * 7.0f32.sqrt()).floor();
        let right = 0.5 * sides * (std::f32::consts::TAU / sides).sin() * 49.0;
        assert!((area(&mask) - right).abs() < 1e-2 * right, "{} {right}", area(&mask));
        let mut mask = Mask::new([0.0, 0.0], [20.0, 20.0]);
        mask.add_line([2.0, 3.0], [12.0, 13.0], 1.5);
        assert!((area(&mask) - 1.5 * 200f32.sqrt()).abs() < 1e-2, "{}", area(&mask));
    }

    #[test]
    fn grown_masks_hold_what_they_grew_from() {
        let mut mask = Mask::new([0.0, 0.0], [4.0, 4.0]);
        mask.add_rectangle([1.0, 1.0], [2.0, 2.0]);
        let grown = mask.grown(2.5);
        let at = |x, y| grown.covered().find(|(p, _)| *p == [x, y]).map_or(0.0, |(_, c)| c);
        assert_eq!([at(1, 1), at(-1, 1), at(2, 4)], [1.0; 3]);
        assert!(at(-2, 1) > 0.0 && at(-2, 1) < 1.0 && at(-3, 1) == 0.0 && at(-1, -1) < 1.0);
    }

    #[test]
    fn what_lies_outside_is_left_out() {
        let mut mask = Mask::new([0.0, 0.0], [2.0, 2.0]);
        mask.add_rectangle([-50.0, 1.0], [100.0, 1.0]);
        assert_eq!(area(&mask), 2.0);
        mask.add_polygon(&[[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(area(&mask), 2.0);
    }
}
