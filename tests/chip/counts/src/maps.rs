//! Counts single calls of the maps, on code vectors and situations of an episode.

use crate::episode::CountedEpisode;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::action_map::{Effect, Probe, Recall};
use amp::controller::Decision;
use amp::fixed::Mask;
use amp::scan::Situation;
use amp::som::{Neighborhood, Som, Update};
use core::hint::black_box;

/// 0.05 in Q16.
const RATE_Q16: u32 = 3_277;
/// Half of the winner's rate for the neighbors.
const SHARE_Q16: u32 = 1 << 15;

/// Searches of the situation map: by the kernels, and by the portable code.
pub fn searches(watch: &Stopwatch, episode: &CountedEpisode<'_>) -> [InstructionStats; 2] {
    let map = episode.robot.state.situations();
    let mut portable = Som::<16, 16>::zeroed(map.grid());
    for (index, component) in map.code().as_flattened().iter().enumerate() {
        portable.set_component(index, *component);
    }
    let mut stats = [InstructionStats::default(); 2];
    for situation in situations(episode) {
        for (map, stats) in [map, &portable].into_iter().zip(&mut stats) {
            let (instructions, _) = watch.count(|| {
                let (map, probe, mask) = black_box((map, situation, Mask::ALL));
                map.bmu(probe, mask)
            });
            stats.add(instructions);
        }
    }
    stats
}

/// Recalls with the probe of the default preset.
pub fn recalls(watch: &Stopwatch, episode: &CountedEpisode<'_>) -> InstructionStats {
    let probe = Probe {
        recall: Recall::Direction,
        preference: None,
    };
    let mut stats = InstructionStats::default();
    for plan in episode
        .decisions
        .iter()
        .filter_map(|decision| decision.plan)
    {
        let (instructions, _) = watch.count(|| {
            let (map, wanted) = black_box((episode.robot.state.actions(), &plan.wanted));
            map.recall(
                wanted,
                black_box(Mask::ALL),
                black_box(probe),
                black_box(Mask::ALL),
            )
        });
        stats.add(instructions);
    }
    stats
}

/// Updates of the situation map and the action map without the search for the winner: for the
/// winner alone, and with four neighbors.
pub fn updates(watch: &Stopwatch, episode: &CountedEpisode<'_>) -> [[InstructionStats; 2]; 2] {
    [0, SHARE_Q16].map(|share_q16| {
        let update = Update::from_q16(Neighborhood::Direct, RATE_Q16, share_q16);
        let mut situations_map = episode.robot.state.situations().clone();
        let mut actions_map = episode.robot.state.actions().clone();
        let mut stats = [InstructionStats::default(); 2];
        for pair in episode.decisions.windows(2) {
            // Neuron 5 is inside the grid and has four neighbors.
            let winner = black_box(5);
            let after = &pair[1].situation;
            let (situation, ()) = watch.count(|| {
                let (map, probe, update) = black_box((&mut situations_map, after, &update));
                map.update(winner, probe, black_box(Mask::ALL), update);
            });
            let effect = effect(&pair[0], &pair[1], episode);
            let (action, ()) = watch.count(|| {
                let (map, effect, update) = black_box((&mut actions_map, &effect, &update));
                map.update(winner, effect, update);
            });
            stats[0].add(situation);
            stats[1].add(action);
        }
        stats
    })
}

fn effect(before: &Decision<16>, after: &Decision<16>, episode: &CountedEpisode<'_>) -> Effect<16> {
    let config = &episode.robot.config;
    Effect {
        change: amp::planner::difference(&after.situation, &before.situation),
        action: config
            .action_code
            .encode(before.allowed, config.robot.step_mm),
        mask: Mask::ALL,
    }
}

fn situations<'a>(episode: &'a CountedEpisode<'_>) -> impl Iterator<Item = &'a Situation<16>> {
    episode.decisions.iter().map(|decision| &decision.situation)
}
