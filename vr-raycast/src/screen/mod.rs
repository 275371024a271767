//! Which rays a picture is made of.

mod every_pixel;

pub(crate) use every_pixel::every_pixel;
