//! Trains maps on the user's own data: the commands `som` and `learn`.

pub mod learn;
pub mod som;
