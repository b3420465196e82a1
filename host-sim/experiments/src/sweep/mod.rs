//! Many episodes from one description: any choices × behaviors × worlds × seeds.
//!
//! Terms. A *point* is one set of choices: flags of `run` and keys of `--set`. A sweep's episodes are numbered from 0 by point,
//! behavior, world and seed, the seed fastest ([`Plan`]). *Shard* I of N does the episodes whose number leaves I when divided by N
//! ([`Shard`]), so that costly points are spread over all shards.
//!
//! Results are rows of CSV in the order of the numbers, added to a file one by one as episodes end ([`ResultsFile`]). The file is all the
//! state there is: a sweep that was killed goes on behind the file's last whole row. Its first line carries the sweep's hash, over
//! everything that its figures depend on, so that rows of different sweeps never mix.

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
pub use plan::{Place, Plan, Vocabulary};
pub use points::{Assignment, Points, Row};
pub use results::{Header, ResultsFile};
pub use run::{Progress, run};
pub use shard::Shard;
pub use table::{Table, Texts};

/// What the columns of a point's choices are called before their key.
pub const CHOICE_PREFIX: &str = "config.";
