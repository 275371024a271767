//! Integration rules.

mod cubic;
mod exact;
