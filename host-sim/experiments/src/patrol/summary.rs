//! What each namer reached, over all worlds and seeds.

use super::{MISSING, Namer, Patrols, Round};
use sim::statistics::{Mean, bootstrap, mean};

/// What one namer reached.
#[derive(Debug, Clone, PartialEq)]
pub struct NamerSummary {
    /// The namer.
    pub namer: Namer,
    /// Rounds that it led; 0 if it was only asked.
    pub rounds: usize,
    /// Share of them in which every station was reached in order.
    pub completed: Mean,
    /// Share of their stations that were reached.
    pub reached: Mean,
    /// How far the robot was from the stations that it reached, m: mean.
    pub error_m: f64,
    /// Share of stations at which it named the right one, by the values that were
    /// [missing](MISSING); `None` if it does not go by them.
    pub right: [Option<Mean>; 4],
    /// Steps with a contact.
    pub contacts: u32,
}

/// One summary for each namer; intervals are bootstraps over the worlds, each with `seeds` results.
#[must_use]
pub fn summarize(patrols: &[Patrols], seeds: u32) -> Vec<NamerSummary> {
    let worlds: Vec<_> = patrols.chunks(seeds.max(1) as usize).collect();
    Namer::ALL.map(|namer| summary(namer, &worlds)).into()
}

fn summary(namer: Namer, worlds: &[&[Patrols]]) -> NamerSummary {
    let of_rounds = |value: fn(&Round) -> f64| -> Vec<Vec<f64>> {
        let world = |patrols: &&[Patrols]| {
            let rounds = patrols.iter().flat_map(|one| &one.rounds);
            rounds.filter(|r| r.namer == namer).map(value).collect()
        };
        worlds.iter().map(world).collect()
    };
    let right = MISSING.map(|missing| {
        let world = |patrols: &&[Patrols]| -> Vec<f64> {
            let all = patrols.iter().flat_map(|one| &one.namings);
            let all = all.filter(|n| (n.namer, n.missing) == (namer, missing));
            all.map(|n| f64::from(u8::from(n.is_right))).collect()
        };
        let values: Vec<_> = worlds.iter().map(world).collect();
        let is_asked = values.iter().any(|world| !world.is_empty());
        is_asked.then(|| bootstrap(&values))
    });
    // A round without a station has no error.
    let error = |round: &Round| {
        if round.reached > 0 {
            round.error_m
        } else {
            f64::NAN
        }
    };
    let errors = of_rounds(error).concat();
    let contacts = of_rounds(|round| f64::from(round.contacts)).concat();
    NamerSummary {
        namer,
        rounds: contacts.len(),
        completed: bootstrap(&of_rounds(|round| {
            f64::from(u8::from(round.reached == round.stations))
        })),
        reached: bootstrap(&of_rounds(|r| r.reached as f64 / r.stations.max(1) as f64)),
        error_m: mean(errors.into_iter().filter(|error| !error.is_nan())),
        right,
        contacts: contacts.iter().sum::<f64>() as u32,
    }
}
