//! Maps of a person's own data: the commands `som` and `learn`.

pub mod learn;
pub mod som;
