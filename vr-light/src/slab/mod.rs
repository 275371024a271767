//! Plane-parallel slabs, solved without random numbers.
