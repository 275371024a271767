//! The transfer function as kernels look it up: light and opacity of a sample that stands for a given length of a ray.

use vr_core::optics::{opacity_of_depth, source_weight};
use vr_core::{Calibration, TransferFunction};

use crate::codes::{Begin, Codes};

/// Colour (or emission) and extinction at evenly spaced stored numbers; a value takes the nearest entry.
#[derive(Clone, Debug)]
pub(crate) struct Optics {
    rows: Vec<Row>,
    /// A value between codes lies at `code·scale + bias` among the rows, the rounding to the nearest included.
    pub(crate) scale: f32,
    pub(crate) bias: f32,
    /// First entry of tables of codes.
    begin: Begin,
    emits: bool,
}

#[derive(Clone, Copy, Debug)]
struct Row {
    /// Colour; where emission is given on its own, that, per world unit.
    light: [f64; 3],
    /// Per world unit.
    extinction: f64,
}

/// Entry of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Entry {
    /// Premultiplied light, and opacity.
    Sample,
    /// Light without absorption, and optical depth: both grow in proportion with the length.
    Depth,
}

impl Row {
    const NOTHING: Self = Self { light: [0.0; 3], extinction: 0.0 };
}

/// Optical depth of what is opaque however thin: finite in f32 and after multiplication by a colour, and more than enough if but 10⁻¹⁸ of the
/// length counts.
const WALL: f64 = 1e20;
/// An interpolated value may lie beyond the range of the codes by rounding: that many entries are there twice at either end.
const GUARD: usize = 2;
/// Bytes have this many entries to a code, so that a value between two finds its own.
const ENTRIES_PER_BYTE: f64 = 8.0;
/// Entries for wider ranges, unless their codes are few.
const ENTRIES: f64 = 4096.0;
/// Wider ranges have at most this many entries: a little less than a [`Table`](crate::codes::Code::Table) holds.
const MAX_ENTRIES: f64 = 16000.0;

impl Optics {
    /// For values between codes: classified after interpolation.
    pub(crate) fn of_values(transfer: &TransferFunction, calibration: Calibration, codes: &Codes) -> Self {
        let [low, high] = codes.ends();
        let per_code = match high - low {
            s if s < 255.5 => ENTRIES_PER_BYTE,
            s if s <= ENTRIES => (ENTRIES / s).floor(),
            s if s <= MAX_ENTRIES => 1.0,
            s => ENTRIES / s,
        };
        let intervals = ((high - low) * per_code).ceil() as usize;
        let row = |i: usize| {
            let code = low + i.saturating_sub(GUARD).min(intervals) as f64 / per_code;
            row(transfer, calibration.value(codes.stored(code.min(high))))
        };
        let rows = (0..=intervals + 2 * GUARD).map(row).collect();
        let bias = GUARD as f64 + 0.5 - low * per_code;
        Self {
            rows,
            scale: per_code as f32,
            bias: bias as f32,
            begin: Begin::default(),
            emits: transfer.has_emission(),
        }
    }

    /// For codes themselves: classified before interpolation. One entry a code, where there are not too many.
    pub(crate) fn of_voxels(transfer: &TransferFunction, calibration: Calibration, codes: &Codes) -> Self {
        let [low, high] = codes.ends();
        let (first, shift) = if codes.bytes {
            (0, 0)
        } else {
            (low as usize, (0..).find(|&s| (high - low) / f64::from(1 << s) <= MAX_ENTRIES).unwrap_or(0))
        };
        let row = |i: usize| {
            // The middle of those that share the entry.
            let code = (first + (i << shift)) as f64 + 0.5 * f64::from((1 << shift) - 1);
            if code < low { Row::NOTHING } else { row(transfer, calibration.value(codes.stored(code.min(high)))) }
        };
        let rows = (0..=(high as usize - first) >> shift).map(row).collect();
        Self { rows, scale: 1.0, bias: 0.0, begin: Begin { first, shift }, emits: transfer.has_emission() }
    }

    /// The same with all extinction multiplied by a factor. Emission that is given on its own stays; a wall, too, is clear under a factor of 0.
    pub(crate) fn with_extinction_times(&self, factor: f64) -> Self {
        let times = |row: &Row| Row { extinction: if factor == 0.0 { 0.0 } else { factor * row.extinction }, ..*row };
        Self { rows: self.rows.iter().map(times).collect(), ..self.clone() }
    }

    /// First entry of tables of codes.
    #[inline(always)]
    pub(crate) fn codes_begin(&self) -> Begin {
        self.begin
    }

    /// A sample that stands for `length` world units.
    fn sample(&self, place: usize, length: f64, entry: Entry) -> [f32; 4] {
        let Row { light, extinction } = self.rows[place];
        if length <= 0.0 || (extinction == 0.0 && !self.emits) {
            return [0.0; 4];
        }
        let tau = (extinction * length).min(WALL);
        let (share, last) = match entry {
            Entry::Sample if self.emits => (length * source_weight(tau), opacity_of_depth(tau)),
            Entry::Sample => (opacity_of_depth(tau), opacity_of_depth(tau)),
            Entry::Depth if self.emits => (length, tau),
            Entry::Depth => (tau, tau),
        };
        [light[0] * share, light[1] * share, light[2] * share, last].map(|x| x as f32)
    }

    /// All entries for one length.
    pub(crate) fn entries(&self, length: f64, entry: Entry) -> impl Iterator<Item = [f32; 4]> {
        (0..self.rows.len()).map(move |place| self.sample(place, length, entry))
    }
}

fn row(transfer: &TransferFunction, value: f64) -> Row {
    let at = transfer.at(value);
    let light = if transfer.has_emission() { at.emission } else { at.color };
    Row { light, extinction: transfer.extinction(at.opacity) }
}

#[cfg(test)]
mod tests {
    use vr_core::{ControlPoint, OpacityRule};

    use crate::codes::Code;

    use super::*;

    fn ramp() -> TransferFunction {
        let points = vec![
            ControlPoint::new(10.0, [0.0; 3], 0.0),
            ControlPoint::new(20.0, [1.0, 0.5, 0.25], 1.0),
            ControlPoint::new(20.0, [1.0; 3], 0.25),
            ControlPoint::new(30.0, [1.0; 3], 0.0),
        ];
        TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap()
    }

    #[test]
    fn values_find_the_nearest_entry() {
        let codes = Codes { origin: 0.0, spacing: 1.0, bytes: true, range: [5.0, 40.0] };
        let optics = Optics::of_values(&ramp(), Calibration::default(), &codes);
        let table: Vec<_> = optics.entries(0.5, Entry::Sample).collect();
        for (value, exact) in
            [(5.0, 5.0), (40.0, 40.0), (12.5, 12.5), (12.55, 12.5), (4.99, 5.0), (40.1, 40.0), (28.0, 28.0)]
        {
            let wanted = ramp().step(exact, 0.5);
            let got = table[(value * optics.scale + optics.bias) as usize];
            for c in 0..4 {
                assert!((f64::from(got[c]) - wanted[c]).abs() < 1e-7, "{value}: {got:?}, not {wanted:?}");
            }
        }
    }

    #[test]
    fn codes_find_their_own_entry() {
        let codes = Codes { origin: -10.0, spacing: 1.0, bytes: false, range: [5.0, 40.0] };
        let optics = Optics::of_voxels(&ramp(), Calibration::default(), &codes);
        let table: Vec<_> = optics.entries(0.5, Entry::Sample).collect();
        for stored in [5, 12, 19, 20, 29, 40] {
            let got = table[((stored + 10) as u16).place(optics.codes_begin())];
            assert_eq!(got, ramp().step(f64::from(stored), 0.5).map(|x| x as f32));
        }
        let wide = Codes { origin: 0.0, spacing: 1.0 / 65535.0, bytes: false, range: [0.0, 1.0] };
        let optics = Optics::of_voxels(&ramp(), Calibration { slope: 40.0, intercept: 0.0 }, &wide);
        let (got, wanted) = (
            optics.entries(1.0, Entry::Sample).nth(25_000u16.place(optics.codes_begin())).unwrap()[3],
            ramp().step(40.0 * 25e3 / 65535.0, 1.0)[3],
        );
        assert!((f64::from(got) - wanted).abs() < 1e-3);
    }

    #[test]
    fn walls_are_opaque_however_thin() {
        let codes = Codes { origin: 0.0, spacing: 1.0, bytes: true, range: [0.0, 255.0] };
        let wall = TransferFunction::new(vec![ControlPoint::new(0.0, [0.5; 3], 1.0)], OpacityRule::Power, 1.0).unwrap();
        let optics = Optics::of_voxels(&wall, Calibration::default(), &codes);
        let sample = |length, entry| optics.sample(7, length, entry);
        assert_eq!(sample(1e-9, Entry::Sample), [0.5, 0.5, 0.5, 1.0]);
        assert_eq!(sample(0.0, Entry::Sample), [0.0; 4]);
        assert_eq!(sample(1e-9, Entry::Depth), [5e19, 5e19, 5e19, 1e20]);
    }
}
