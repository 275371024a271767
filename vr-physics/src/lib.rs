//! Stub.
#![allow(missing_docs)]
mod crossings;
mod nodes;
mod poly;
