//! The program `vr`.
fn main() {}
