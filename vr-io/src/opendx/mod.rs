//! IBM Data Explorer, later OpenDX: headers of raw files (`.general`) and native files (`.dx`) with regular grids. "IBM Visualization Data
//! Explorer QuickStart Guide", chapter 5, and "User's Guide", appendix B (OpenDX 4.4, 2006).
//!
//! Both name sizes in the order x, y, z and store numbers with the last of these fastest, unless they say otherwise.

mod general;
mod keyword;
mod native;
mod objects;

pub(crate) use general::describe as describe_general;
pub(crate) use native::describe as describe_native;
pub(crate) use objects::is_native;
