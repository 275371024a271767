//! Tests of sessions, and of the server over plain TCP.

mod common;
mod document;
mod hostile;
mod opening;
mod serving;
mod session;
mod slices;
