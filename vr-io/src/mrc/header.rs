//! The 1024 bytes before the voxels, as numbers.

use crate::error::FieldError;
use crate::scalar::Endian;

/// Bytes of the header itself.
pub(super) const LENGTH: u64 = 1024;

/// The fields that matter to us, named as the format's page does.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub endian: Endian,
    /// NX, NY, NZ: columns, rows and sections; columns are the fastest.
    pub size: [usize; 3],
    pub mode: i32,
    /// NXSTART, NYSTART, NZSTART: first column, row and section.
    pub start: [i32; 3],
    /// MX, MY, MZ: intervals along X, Y and Z of the cell.
    pub intervals: [i32; 3],
    /// CELLA: lengths of the cell, in Å.
    pub lengths: [f64; 3],
    /// CELLB: its angles, in degrees.
    pub angles: [f64; 3],
    /// The axis of the cell, 0 to 2, along columns, rows and sections.
    pub axes: [usize; 3],
    /// ISPG.
    pub space_group: i32,
    /// NSYMBT: bytes of the extended header.
    pub extended: u64,
    /// ORIGIN along X, Y and Z.
    pub origin: [f64; 3],
    /// True if the bytes of mode 0 are unsigned: IMOD's, unless it says otherwise.
    pub unsigned_bytes: bool,
}

/// Numbers at offsets of the header.
struct Fields<'a> {
    bytes: &'a [u8],
    endian: Endian,
}

impl Fields<'_> {
    fn four(&self, offset: usize) -> [u8; 4] {
        let mut four = self.bytes.get(offset..).and_then(|b| b.first_chunk()).copied().unwrap_or_default();
        if self.endian == Endian::Big {
            four.reverse();
        }
        four
    }

    fn int(&self, offset: usize) -> i32 {
        i32::from_le_bytes(self.four(offset))
    }

    fn ints(&self, offset: usize) -> [i32; 3] {
        [0, 4, 8].map(|o| self.int(offset + o))
    }

    fn floats(&self, offset: usize) -> [f64; 3] {
        [0, 4, 8].map(|o| f64::from(f32::from_le_bytes(self.four(offset + o))))
    }
}

impl Header {
    pub fn parse(bytes: &[u8], notes: &mut Vec<String>) -> Result<Self, FieldError> {
        if (bytes.len() as u64) < LENGTH {
            let found = format!("{} bytes", bytes.len());
            return Err(FieldError::new("header", found, format!("must be {LENGTH} bytes")));
        }
        let endian = byte_order(bytes, notes)?;
        let fields = Fields { bytes, endian };

        let mut size = [0; 3];
        for (axis, found) in fields.ints(0).into_iter().enumerate() {
            size[axis] = usize::try_from(found)
                .ok()
                .filter(|&n| n > 0)
                .ok_or_else(|| FieldError::new(["NX", "NY", "NZ"][axis], found, "must be 1 or more"))?;
        }
        let extended = fields.int(92);
        let extended = u64::try_from(extended).map_err(|_| FieldError::new("NSYMBT", extended, "must be 0 or more"))?;
        const IMOD: i32 = 0x444f_4d49;
        let imod = fields.int(152) == IMOD;
        Ok(Self {
            endian,
            size,
            mode: fields.int(12),
            start: fields.ints(16),
            intervals: fields.ints(28),
            lengths: fields.floats(40),
            angles: fields.floats(52),
            axes: axes(fields.ints(64), notes)?,
            space_group: fields.int(88),
            extended,
            origin: fields.floats(196),
            unsigned_bytes: imod && fields.int(156) & 1 == 0,
        })
    }
}

/// MAPC, MAPR, MAPS, from 0.
fn axes(found: [i32; 3], notes: &mut Vec<String>) -> Result<[usize; 3], FieldError> {
    if found == [0; 3] {
        notes.push(
            "no MAPC, MAPR, MAPS in the header: columns along X, rows along Y, sections along Z are assumed".into(),
        );
        return Ok([0, 1, 2]);
    }
    let mut sorted = found;
    sorted.sort_unstable();
    if sorted != [1, 2, 3] {
        return Err(FieldError::new("MAPC, MAPR, MAPS", format_args!("{found:?}"), "must be 1, 2 and 3 in some order"));
    }
    Ok(found.map(|n| n as usize - 1))
}

/// The machine stamp tells the byte order; where it is missing, the one in which the header makes sense is taken.
fn byte_order(bytes: &[u8], notes: &mut Vec<String>) -> Result<Endian, FieldError> {
    match bytes.get(212..214) {
        Some([0x44, 0x41 | 0x44]) => return Ok(Endian::Little),
        Some([0x11, 0x11]) => return Ok(Endian::Big),
        _ => {}
    }
    let makes_sense = |endian: &Endian| {
        let fields = Fields { bytes, endian: *endian };
        let mode = fields.int(12);
        (0..=127).contains(&mode) && fields.ints(0).iter().all(|n| (1..1 << 24).contains(n))
    };
    let endian = [Endian::Little, Endian::Big].into_iter().find(makes_sense).ok_or_else(|| {
        let stamp = format!("{:02x?}", bytes.get(212..216).unwrap_or_default());
        FieldError::new("MACHST", stamp, "must be 44 44 or 44 41 (little-endian), or 11 11 (big-endian)")
    })?;
    notes.push(format!("no machine stamp in the header: {endian} numbers are assumed, as the sizes make sense then"));
    Ok(endian)
}
