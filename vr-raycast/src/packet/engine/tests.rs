use super::*;
#[path = "speed.rs"]
mod speed;
