//! Limit on the size that a compressed file may claim.

use std::path::Path;

use crate::error::{FileError, FileErrorKind};

/// Bytes that a byte of a compressed file may stand for. Deflate reaches 1032, LZW 2730, and real volumes are far below either.
const MAX_RATIO: u64 = 4096;
/// Bytes that any file may claim: too few to harm.
const ALWAYS: u64 = 1 << 24;

/// Refuses a claim that no decoder could make good from what is stored, before memory is asked for.
pub(crate) fn check_claim(path: &Path, field: &str, claimed: u64, stored: u64) -> Result<(), FileError> {
    let limit = stored.saturating_mul(MAX_RATIO).max(ALWAYS);
    if claimed <= limit {
        return Ok(());
    }
    let found = format_args!("{claimed} bytes behind {stored} bytes of coded data").to_string();
    let allowed = format!("must be at most {MAX_RATIO} to one, which no coding reaches");
    Err(FileError::new(path, FileErrorKind::field(field, found, allowed)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claims_are_held_against_what_is_stored() {
        let check = |claimed, stored| check_claim(Path::new("x"), "size", claimed, stored);
        assert!(check(1 << 24, 0).is_ok());
        assert!(check(1 << 30, 1 << 18).is_ok());
        let message = check(1 << 40, 1 << 10).unwrap_err().to_string();
        assert!(message.contains("1099511627776 bytes behind 1024 bytes"), "{message}");
    }
}
