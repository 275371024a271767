//! Rows of a table, turned into vectors.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};

use super::LANES;

/// Sixteen rows of four, four to a vector: what can be added and scaled before it is turned.
#[inline(always)]
pub fn packed<S: Simd>(rows: [f32x4<S>; LANES]) -> [f32x16<S>; 4] {
    let [r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12, r13, r14, r15] = rows;
    [
        r0.combine(r1).combine(r2.combine(r3)),
        r4.combine(r5).combine(r6.combine(r7)),
        r8.combine(r9).combine(r10.combine(r11)),
        r12.combine(r13).combine(r14.combine(r15)),
    ]
}

/// Sixteen rows of a table by their numbers, [`packed`]. `row` returns one of them. They are named one by one, as compilers keep what a loop fills in memory.
#[inline(always)]
pub fn packed_rows<'a, S: Simd>(simd: S, n: [i32; LANES], row: impl Fn(usize) -> &'a [f32; 4]) -> [f32x16<S>; 4] {
    let load = |i: i32| f32x4::load_array_ref(simd, row(i as u32 as usize));
    packed([
        load(n[0]),
        load(n[1]),
        load(n[2]),
        load(n[3]),
        load(n[4]),
        load(n[5]),
        load(n[6]),
        load(n[7]),
        load(n[8]),
        load(n[9]),
        load(n[10]),
        load(n[11]),
        load(n[12]),
        load(n[13]),
        load(n[14]),
        load(n[15]),
    ])
}

/// Sixteen rows of a table by their numbers, one vector per component.
#[inline(always)]
pub fn rows_at<'a, S: Simd>(simd: S, n: [i32; LANES], row: impl Fn(usize) -> &'a [f32; 4]) -> [f32x16<S>; 4] {
    transpose_packed(packed_rows(simd, n, row))
}

/// Sixteen rows of four into one vector per component.
#[inline(always)]
pub fn transpose<S: Simd>(rows: [f32x4<S>; LANES]) -> [f32x16<S>; 4] {
    transpose_packed(packed(rows))
}

/// One vector per component into sixteen rows of four: undoes [`transpose`].
#[inline(always)]
pub fn rows_of<S: Simd>([a, b, c, d]: [f32x16<S>; 4]) -> [f32x4<S>; LANES] {
    let (ac_low, ac_high) = (a.zip_low(c), a.zip_high(c));
    let (bd_low, bd_high) = (b.zip_low(d), b.zip_high(d));
    let (w, x) = (ac_low.zip_low(bd_low).split(), ac_low.zip_high(bd_low).split());
    let (y, z) = (ac_high.zip_low(bd_high).split(), ac_high.zip_high(bd_high).split());
    let ((r0, r1), (r2, r3), (r4, r5), (r6, r7)) = (w.0.split(), w.1.split(), x.0.split(), x.1.split());
    let ((r8, r9), (r10, r11), (r12, r13), (r14, r15)) = (y.0.split(), y.1.split(), z.0.split(), z.1.split());
    [r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12, r13, r14, r15]
}

/// The same of [`packed`] rows.
#[inline(always)]
pub fn transpose_packed<S: Simd>([a, b, c, d]: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
    // Even components and odd ones, then each in two.
    let (even_low, odd_low) = (a.unzip_low(b), a.unzip_high(b));
    let (even_high, odd_high) = (c.unzip_low(d), c.unzip_high(d));
    [
        even_low.unzip_low(even_high),
        odd_low.unzip_low(odd_high),
        even_low.unzip_high(even_high),
        odd_low.unzip_high(odd_high),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn rows_are_turned_and_turned_back() {
        let found = dispatch!(Level::new(), simd => {
            let mut rows = [f32x4::splat(simd, 0.0); LANES];
            for (i, row) in rows.iter_mut().enumerate() {
                *row = f32x4::load_array_ref(simd, &[0.0, 1.0, 2.0, 3.0]) + 10.0 * i as f32;
            }
            let columns = transpose(rows);
            assert_eq!(columns[2].to_array(), std::array::from_fn(|i| 10.0 * i as f32 + 2.0));
            rows_of(columns).map(|row| row.to_array())
        });
        assert_eq!(found, std::array::from_fn(|i| [0.0, 1.0, 2.0, 3.0].map(|c| c + 10.0 * i as f32)));
    }
}
