//! Sweeps: many episodes from one description; options × behaviors × worlds × seeds.
//!
//! A *point* is one set of options. *Shard* I of N runs the episodes whose number modulo N is I.
//! Results are CSV rows, appended in order: a killed sweep continues after the last whole row. The
//! sweep's hash in the first line keeps sweeps apart.

mod description;
mod identity;
mod in_order;
mod merge;
mod outcome;
mod plan;
mod points;
mod results;
mod run;
mod shard;
mod table;

pub use description::Description;
pub use merge::{Merged, merge};
pub use outcome::{SweepOutcome, SweptChoice, swept_choices};
pub use plan::{EpisodeIndex, SweepPlan, Vocabulary};
pub use points::{Assignment, PointOptions, SweepPoints};
pub use results::{ResultsFile, ResultsHeader};
pub use run::{SweepProgress, run};
pub use shard::Shard;
pub use table::{ResultsTable, Texts};

/// Prefix of the columns with a point's options.
pub const CHOICE_PREFIX: &str = "config.";
