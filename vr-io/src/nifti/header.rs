//! The binary headers of both versions, as numbers.

use crate::error::FieldError;
use crate::scalar::Endian;

/// The fields that matter to us, of either version.
#[derive(Clone, Debug)]
pub(super) struct Header {
    /// `NIfTI-1` or `NIfTI-2`.
    pub version: &'static str,
    pub endian: Endian,
    /// Bytes of the header itself.
    pub length: u64,
    /// True if the voxels are in another file.
    pub is_pair: bool,
    pub dim: [i64; 8],
    pub datatype: i16,
    pub pixdim: [f64; 8],
    vox_offset: f64,
    pub scl_slope: f64,
    pub scl_inter: f64,
    pub xyzt_units: i32,
    pub qform_code: i32,
    pub sform_code: i32,
    /// Quaternion b, c, d.
    pub quatern: [f64; 3],
    pub qoffset: [f64; 3],
    /// Rows of the affine map.
    pub srow: [[f64; 4]; 3],
}

/// Numbers at offsets of a header, which is known to be long enough.
struct Fields<'a> {
    bytes: &'a [u8],
    endian: Endian,
}

macro_rules! number_at {
    ($($name:ident: $t:ty),*) => {$(
        fn $name(&self, offset: usize) -> $t {
            let b = self.bytes[offset..].first_chunk().copied().unwrap_or_default();
            match self.endian {
                Endian::Little => <$t>::from_le_bytes(b),
                Endian::Big => <$t>::from_be_bytes(b),
            }
        }
    )*};
}

impl Fields<'_> {
    number_at!(i16: i16, i32: i32, i64: i64, f32: f32, f64: f64);
}

impl Header {
    pub fn parse(head: &[u8]) -> Result<Self, FieldError> {
        const ALLOWED: &str = "must be 348 (NIfTI-1) or 540 (NIfTI-2) in either byte order, and as many bytes";
        let size = head
            .first_chunk()
            .ok_or_else(|| FieldError::new("sizeof_hdr", format_args!("{} bytes", head.len()), ALLOWED))?;
        let (size, endian) = match (i32::from_le_bytes(*size), i32::from_be_bytes(*size)) {
            (n @ (348 | 540), _) => (n as usize, Endian::Little),
            (_, n @ (348 | 540)) => (n as usize, Endian::Big),
            (n, _) => return Err(FieldError::new("sizeof_hdr", n, ALLOWED)),
        };
        if head.len() < size {
            let found = format!("{size} in a file of {} bytes", head.len());
            return Err(FieldError::new("sizeof_hdr", found, ALLOWED));
        }
        let f = Fields { bytes: head, endian };
        if size == 348 { Self::version_1(&f) } else { Self::version_2(&f) }
    }

    fn version_1(f: &Fields<'_>) -> Result<Self, FieldError> {
        let is_pair = match &f.bytes[344..348] {
            b"n+1\0" => false,
            b"ni1\0" => true,
            other => return Err(FieldError::new("magic", String::from_utf8_lossy(other), "must be n+1 or ni1")),
        };
        let f32 = |offset| f64::from(f.f32(offset));
        Ok(Self {
            version: "NIfTI-1",
            endian: f.endian,
            length: 348,
            is_pair,
            dim: std::array::from_fn(|i| f.i16(40 + 2 * i).into()),
            datatype: f.i16(70),
            pixdim: std::array::from_fn(|i| f32(76 + 4 * i)),
            vox_offset: f32(108),
            scl_slope: f32(112),
            scl_inter: f32(116),
            xyzt_units: f.bytes[123].into(),
            qform_code: f.i16(252).into(),
            sform_code: f.i16(254).into(),
            quatern: std::array::from_fn(|i| f32(256 + 4 * i)),
            qoffset: std::array::from_fn(|i| f32(268 + 4 * i)),
            srow: std::array::from_fn(|r| std::array::from_fn(|c| f32(280 + 16 * r + 4 * c))),
        })
    }

    fn version_2(f: &Fields<'_>) -> Result<Self, FieldError> {
        let is_pair = match &f.bytes[4..12] {
            b"n+2\0\r\n\x1a\n" => false,
            b"ni2\0\r\n\x1a\n" => true,
            other => return Err(FieldError::new("magic", String::from_utf8_lossy(other), "must be n+2 or ni2")),
        };
        Ok(Self {
            version: "NIfTI-2",
            endian: f.endian,
            length: 540,
            is_pair,
            dim: std::array::from_fn(|i| f.i64(16 + 8 * i)),
            datatype: f.i16(12),
            pixdim: std::array::from_fn(|i| f.f64(104 + 8 * i)),
            vox_offset: f.i64(168) as f64,
            scl_slope: f.f64(176),
            scl_inter: f.f64(184),
            xyzt_units: f.i32(500),
            qform_code: f.i32(344),
            sform_code: f.i32(348),
            quatern: std::array::from_fn(|i| f.f64(352 + 8 * i)),
            qoffset: std::array::from_fn(|i| f.f64(376 + 8 * i)),
            srow: std::array::from_fn(|r| std::array::from_fn(|c| f.f64(400 + 32 * r + 8 * c))),
        })
    }

    /// Numbers along each axis; at least three axes (of one number, where the file has fewer).
    pub fn sizes(&self) -> Result<Vec<usize>, FieldError> {
        let n = self.dim[0];
        if !(1..=7).contains(&n) {
            return Err(FieldError::new("dim[0]", n, "must be 1 to 7; a volume needs 3"));
        }
        let mut sizes = Vec::new();
        for axis in 1..=n as usize {
            let size = self.dim[axis];
            let size = usize::try_from(size).ok().filter(|&s| s > 0);
            sizes
                .push(size.ok_or_else(|| FieldError::new(format!("dim[{axis}]"), self.dim[axis], "must be positive"))?);
        }
        sizes.resize(sizes.len().max(3), 1);
        Ok(sizes)
    }

    /// Offset of the voxels: `min` or more.
    pub fn vox_offset(&self, min: u64) -> Result<u64, FieldError> {
        let v = self.vox_offset;
        // 0 in a single file means: right behind the header and its four bytes of extension flags.
        if v == 0.0 && min > 0 {
            return Ok(min + 4);
        }
        if !(v >= min as f64 && v <= i64::MAX as f64 && v.fract() == 0.0) {
            return Err(FieldError::new("vox_offset", v, format!("must be a whole number, {min} or more")));
        }
        Ok(v as u64)
    }

    /// The unit of length, if the file says.
    pub fn units(&self) -> Option<&'static str> {
        match self.xyzt_units & 7 {
            1 => Some("m"),
            2 => Some("mm"),
            3 => Some("µm"),
            _ => None,
        }
    }
}
