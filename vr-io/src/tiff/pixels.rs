//! Pixels that the decoder gives, as bytes.

use tiff::decoder::DecodingResult;

/// Appends every `step`-th number from `offset` on, `count` of them, in the byte order of the machine. False if there are not so many.
pub(super) fn append(pixels: &DecodingResult, offset: usize, step: usize, count: usize, out: &mut Vec<u8>) -> bool {
    match pixels {
        DecodingResult::U8(p) => pick(p, offset, step, count, out),
        DecodingResult::I8(p) => pick(p, offset, step, count, out),
        DecodingResult::U16(p) => pick(p, offset, step, count, out),
        DecodingResult::I16(p) => pick(p, offset, step, count, out),
        DecodingResult::U32(p) => pick(p, offset, step, count, out),
        DecodingResult::I32(p) => pick(p, offset, step, count, out),
        DecodingResult::U64(p) => pick(p, offset, step, count, out),
        DecodingResult::I64(p) => pick(p, offset, step, count, out),
        DecodingResult::F32(p) => pick(p, offset, step, count, out),
        DecodingResult::F64(p) => pick(p, offset, step, count, out),
        DecodingResult::F16(p) => {
            let floats: Vec<f32> = p.iter().map(|h| h.to_f32()).collect();
            pick(&floats, offset, step, count, out)
        }
    }
}

pub(crate) fn pick<T: bytemuck::NoUninit>(
    pixels: &[T],
    offset: usize,
    step: usize,
    count: usize,
    out: &mut Vec<u8>,
) -> bool {
    let Some(rest) = pixels.get(offset..) else { return false };
    if step == 1 {
        let Some(run) = rest.get(..count) else { return false };
        out.extend_from_slice(bytemuck::cast_slice(run));
        return true;
    }
    if rest.len().div_ceil(step) < count {
        return false;
    }
    rest.iter().step_by(step).take(count).for_each(|p| out.extend_from_slice(bytemuck::bytes_of(p)));
    true
}
