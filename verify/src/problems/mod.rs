//! The problems, one file each.

pub mod poiseuille_series;
