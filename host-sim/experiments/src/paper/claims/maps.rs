//! Claims of sections 2.1 to 2.4: perceived goals, lazy memory, self-organizing maps (Figs. 1 and
//! 2).

use super::{Claim, ClaimVerdict, PRESETS, by_preset, controls, percent, percents};
use crate::paper::chain::{Chain, NEURONS, PROBES};
use crate::paper::measure::Measured;
use crate::paper::rooms::RoomResult;
use crate::paper::topology::{MapTopology, SHUFFLINGS};
use sim::statistics::{mean, median};

/// The claims of these sections, in order.
pub(super) fn claims(measured: &Measured) -> Vec<Claim> {
    let mut claims = vec![perceived(measured), similar_samples(measured)];
    claims.push(
        Claim::new("2.2", "no guarantee that lazy learning leads to the goal").untestable(
            "A guarantee cannot be measured; for how rarely the memory knows the situation see above.",
        ),
    );
    claims.extend([by_content(measured), controls::neighborhood(measured)]);
    claims.push(
        Claim::new(
            "2.3",
            "4 neighbors correspond to a 2-D map; the number of neurons is fixed",
        )
        .by_construction("4 × 4 neurons with up to 4 direct neighbors; the chain has 2"),
    );
    claims.extend(chains(measured));
    claims.extend([same_number(measured), larger_fields(measured)]);
    claims.push(controls::two_maps(measured));
    claims.extend([continuous(measured), paths(measured), alike(measured)]);
    claims.push(
        Claim::new("Fig. 2", "1.0: shorter than 2 cm; 0.0: at least 5 cm away")
            .by_construction("The miniature robot's scale of nearness; linear in between"),
    );
    claims.push(discreteness(measured));
    claims
}

/// A figure of each room, by reading.
fn by_room(measured: &Measured, figure: impl Fn(&RoomResult) -> f64) -> [f64; 3] {
    std::array::from_fn(|i| mean(measured.rooms[i].iter().map(&figure)))
}

fn rooms(measured: &Measured) -> String {
    format!("{} rooms per preset", measured.size.rooms)
}

fn perceived(measured: &Measured) -> Claim {
    let ever = by_room(measured, |room| {
        100.0 * f64::from(u8::from(room.report.goal_steps > 0))
    });
    let share = by_room(measured, |room| {
        percent(room.report.goal_steps, room.report.steps)
    });
    let texts: Vec<_> = ever
        .iter()
        .zip(&share)
        .map(|(ever, share)| {
            format!(
                "in {} of rooms ({share:.0} % of decisions)",
                percents(*ever)
            )
        })
        .collect();
    Claim::new(
        "2.1",
        "the robot must be able to perceive such an achievement",
    )
    .holds_if("the goal \"free of obstacles\" is perceived in ≥ 99 % of rooms")
    .measured(by_preset(&PRESETS, &texts, String::clone), rooms(measured))
    .verdict(ClaimVerdict::of(&ever.map(|share| share >= 99.0)))
}

fn similar_samples(measured: &Measured) -> Claim {
    let of = |rooms: &Vec<RoomResult>| -> Vec<f64> {
        rooms
            .iter()
            .flat_map(|room| room.alike.iter().map(|&count| count as f64))
            .collect()
    };
    let counts = measured.rooms.each_ref().map(of);
    let none = counts.each_ref().map(|counts| {
        100.0
            * mean(
                counts
                    .iter()
                    .map(|&count| f64::from(u8::from(count == 0.0))),
            )
    });
    let middle = counts.clone().map(median);
    let texts: Vec<_> = middle
        .iter()
        .zip(&none)
        .map(|(middle, none)| format!("{middle:.0} (none in {none:.0} % of situations)"))
        .collect();
    Claim::new(
        "2.2",
        "for each current situation, there are extremely few similar ones",
    )
    .holds_if("median ≤ 5 of the 100 samples lie nearer than one move changes a situation")
    .measured(
        by_preset(&PRESETS, &texts, String::clone),
        format!("{} situations per preset", counts[0].len()),
    )
    .verdict(ClaimVerdict::of(&middle.map(|middle| middle <= 5.0)))
}

fn by_content(measured: &Measured) -> Claim {
    let errors = [1, 2].map(|i| -> Vec<f64> {
        let rooms = measured.rooms[i].iter();
        rooms
            .flat_map(|room| room.recalled.errors_deg.clone())
            .collect()
    });
    let sample = by_preset(&PRESETS[1..], &errors, |errors| {
        format!("{} moves", errors.len())
    });
    let middle = errors.map(median);
    Claim::new(
        "2.3",
        "associative memories are accessible using part of their content",
    )
    .holds_if("median error < 45° of the action recalled from a change not learned (chance: 90°)")
    .measured(
        by_preset(&PRESETS[1..], &middle, |m| format!("{m:.0}°")),
        sample,
    )
    .verdict(ClaimVerdict::of(&middle.map(|middle| middle < 45.0)))
}

fn chains(measured: &Measured) -> [Claim; 3] {
    let sample = format!("{} chains of {NEURONS} neurons", measured.chains[0].len());
    let [regions, void] = clustered_chains(measured, &sample);
    [uniform_chains(measured, &sample), regions, void]
}

fn uniform_chains(measured: &Measured, sample: &str) -> Claim {
    let [uniform, ..] = &measured.chains;
    let shares: Vec<f64> = uniform.iter().flat_map(Chain::relative_hits).collect();
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let most = shares.iter().copied().fold(0.0, f64::max);
    Claim::new(
        "Fig. 1a",
        "each neuron represents 1/32 (on average) of the input space",
    )
    .holds_if("every neuron between half and twice 1/32")
    .measured(
        format!(
            "{least:.2} to {most:.2} times 1/32, standard deviation {:.2}",
            spread(&shares)
        ),
        format!("{sample}, {PROBES} fresh points each"),
    )
    .verdict(ClaimVerdict::of(&[least >= 0.5 && most <= 2.0]))
}

fn clustered_chains(measured: &Measured, sample: &str) -> [Claim; 2] {
    let [_, clusters, _] = &measured.chains;
    let void: Vec<usize> = clusters.iter().map(|chain| chain.in_the_void).collect();
    let inside = void
        .iter()
        .map(|&v| 100.0 * (1.0 - v as f64 / NEURONS as f64));
    let inside = mean(inside);
    let (fewest, greatest) = (
        void.iter().min().copied().unwrap_or(0),
        void.iter().max().copied().unwrap_or(0),
    );
    let from = if fewest == greatest {
        String::new()
    } else {
        format!("{fewest} to ")
    };
    [
        Claim::new("Fig. 1b", "neurons code preferably these 2 regions")
            .holds_if("≥ 90 % of the neurons lie inside the two clusters")
            .measured(percents(inside), sample.to_owned())
            .verdict(ClaimVerdict::of(&[inside >= 90.0])),
        Claim::new(
            "Fig. 1b",
            "a few neurons code space regions devoid of input points",
        )
        .holds_if("every chain has at least one such neuron")
        .measured(
            format!("{from}{greatest} of {NEURONS} neurons"),
            sample.to_owned(),
        )
        .verdict(ClaimVerdict::of(&[fewest >= 1])),
    ]
}

/// Standard deviation of values whose mean is 1.
fn spread(shares: &[f64]) -> f64 {
    mean(shares.iter().map(|share| (share - 1.0) * (share - 1.0))).sqrt()
}

fn same_number(measured: &Measured) -> Claim {
    let [uniform, _, uneven] = &measured.chains;
    let of = |chains: &[Chain]| mean(chains.iter().map(|chain| spread(&chain.relative_hits())));
    let maps = by_room(measured, |room| room.topology.hit_spread);
    // Both maps of `default` and `probe` are identical.
    let spreads = [of(uniform), of(uneven), maps[1], maps[2]];
    let names = [
        "uniform chain",
        "uneven chain",
        "situation map of probe",
        "of touzet",
    ];
    let idle = by_room(measured, |room| room.topology.idle as f64);
    Claim::new(
        "2.3",
        "each neuron corresponds to (approximately) the same number of input points",
    )
    .holds_if("standard deviation ≤ 25 % of the mean")
    .measured(
        format!(
            "{} of the mean; neurons without any: probe {:.1}, touzet {:.1} of 16",
            by_preset(&names, &spreads, |s| format!("{:.0} %", 100.0 * s)),
            idle[1],
            idle[2]
        ),
        format!("{} chains, {}", uniform.len(), rooms(measured)),
    )
    .verdict(ClaimVerdict::of(&spreads.map(|spread| spread <= 0.25)))
}

fn larger_fields(measured: &Measured) -> Claim {
    let ratios: Vec<f64> = measured.chains[2]
        .iter()
        .filter_map(|chain| match chain.halves() {
            [Some([_, dense]), Some([_, sparse])] => Some(sparse / dense),
            _ => None,
        })
        .collect();
    let larger = ratios.iter().filter(|&&ratio| ratio > 1.0).count();
    Claim::new(
        "2.3",
        "where the input data are scarce: neurons with larger fields of attraction",
    )
    .holds_if("the sparse half's receptive fields are larger in ≥ 95 % of chains")
    .measured(
        format!(
            "larger in {larger} of {}; {:.2} times on average where points are 3 times as sparse",
            ratios.len(),
            mean(ratios.iter().copied())
        ),
        format!("{} chains", ratios.len()),
    )
    .verdict(ClaimVerdict::of(&[
        20 * larger >= 19 * ratios.len() && larger > 0
    ]))
}

fn continuous(measured: &Measured) -> Claim {
    let errors = by_room(measured, |room| 100.0 * room.topology.topographic_error);
    let [_, probe, touzet] = errors;
    let mini = mean(
        measured
            .miniatures
            .iter()
            .map(|m| 100.0 * m.topology.topographic_error),
    );
    Claim::new(
        "2.4",
        "the first map builds a continuous representation of the situation space",
    )
    .holds_if("≤ 10 % of what was learned has its best two neurons apart (topographic error)")
    .measured(
        by_preset(
            &["probe", "touzet", "miniature"],
            &[probe, touzet, mini],
            |e| percents(*e),
        ),
        format!(
            "{}, {} miniature robots",
            rooms(measured),
            measured.miniatures.len()
        ),
    )
    .verdict(ClaimVerdict::of(&[
        probe <= 10.0,
        touzet <= 10.0,
        mini <= 10.0,
    ]))
}

fn paths(measured: &Measured) -> Claim {
    let joined = [1, 2].map(|i| {
        let rooms = measured.rooms[i].iter();
        let (joined, pairs) = rooms.fold((0, 0), |(joined, pairs), room| {
            (
                joined + room.goal_paths.joined,
                pairs + room.goal_paths.pairs,
            )
        });
        percent(joined, pairs)
    });
    Claim::new(
        "2.4",
        "can be used to find a path towards a goal situation, wherever it is",
    )
    .holds_if("≥ 95 % of the neurons lead to any other: over grid steps, and over neighbors ever nearer in code")
    .measured(
        format!(
            "over grid steps all (the grid is connected); over ever nearer neighbors {}",
            by_preset(&PRESETS[1..], &joined, |share| percents(*share))
        ),
        format!("240 pairs of neurons in {}", rooms(measured)),
    )
    .verdict(ClaimVerdict::of(&[true, joined[0] >= 95.0, joined[1] >= 95.0]))
}

fn alike(measured: &Measured) -> Claim {
    let minis: Vec<MapTopology> = measured.miniatures.iter().map(|m| m.topology).collect();
    let nomads = [1, 2].map(|i| -> Vec<MapTopology> {
        let rooms = measured.rooms[i].iter();
        rooms.map(|room| room.topology).collect()
    });
    let [probe, touzet] = nomads;
    let maps = [minis, probe, touzet];
    let names = ["miniature", "probe", "touzet"];
    let texts = maps.each_ref().map(|orders| {
        format!(
            "{:.2} against {:.2}",
            mean(orders.iter().map(|order| order.neighbors)),
            mean(orders.iter().map(|order| order.others))
        )
    });
    let orderly = |order: &MapTopology| {
        let by_chance = order.as_good_by_chance * 100 < SHUFFLINGS;
        order.neighbors < order.others && by_chance
    };
    let share = maps.each_ref().map(|orders| {
        let orderly = orders.iter().filter(|order| orderly(order)).count();
        100.0 * orderly as f64 / orders.len().max(1) as f64
    });
    Claim::new("Fig. 2", "similar situations are coded by neighbor neurons")
        .holds_if(
            "in ≥ 95 % of maps neighbors are nearer than others, as < 1 % of shuffled maps are",
        )
        .measured(
            format!(
                "code distance {}; in {} of maps",
                by_preset(&names, &texts, String::clone),
                by_preset(&names, &share, |share| percents(*share))
            ),
            format!("{} miniature robots, {}", maps[0].len(), rooms(measured)),
        )
        .verdict(ClaimVerdict::of(&share.map(|share| share >= 95.0)))
}

fn discreteness(measured: &Measured) -> Claim {
    let figures = measured.rooms.each_ref().map(|rooms| {
        let found: Vec<_> = rooms.iter().filter_map(|room| room.discreteness).collect();
        let finer = found
            .iter()
            .filter(|d| d.error_after < d.error_before)
            .count();
        [
            100.0 * finer as f64 / found.len().max(1) as f64,
            mean(found.iter().map(|d| d.error_before)),
            mean(found.iter().map(|d| d.error_after)),
            mean(found.iter().map(|d| d.used_before as f64)),
            mean(found.iter().map(|d| d.used_after as f64)),
        ]
    });
    let text = |[finer, before, after, used, uses]: &[f64; 5]| {
        format!(
            "error {before:.2} → {after:.2} (smaller in {finer:.0} % of rooms), answering neurons {used:.1} → {uses:.1}"
        )
    };
    Claim::new("2.4", "a greater discreteness in the areas of interest")
        .holds_if("after 500 decisions the map's quantization error on the next 500 is smaller in ≥ 90 % of rooms")
        .measured(by_preset(&PRESETS, &figures, text), rooms(measured))
        .verdict(ClaimVerdict::of(&figures.map(|[finer, ..]| finer >= 90.0)))
}
