//! Claims of sections 3 and 5.1: obstacle avoidance (Figs. 5 and 6), other behaviors, any robot.

use super::{Claim, ClaimVerdict, PRESETS, by_preset, percent, percents, reinforcement};
use crate::behaviors::SceneOutcome;
use crate::paper::any_ring::Count;
use crate::paper::gaps::Gaps;
use crate::paper::goal_switch::GoalSwitches;
use crate::paper::measure::{FEWER_MOVES, Measured, SceneResult};
use crate::paper::miniature::Miniature;
use sim::behavior::Behavior;
use sim::statistics::mean;
use sim::statistics::{Mean, bootstrap};

/// The claims of these sections, in order.
pub(super) fn claims(measured: &Measured) -> Vec<Claim> {
    let mut claims = vec![no_bumps(measured)];
    claims.push(reinforcement::similar_quality(measured));
    claims.push(no_iterations());
    claims.push(hundred_moves(measured));
    claims.push(reinforcement::fewer_moves(measured));
    claims.push(goal_switches(measured));
    claims.push(requirement_claim(
        measured,
        "avoid-right",
        "3",
        "avoidance that avoids by the right side",
    ));
    claims.push(requirement_claim(measured, "wall-", "3", "wall following"));
    claims.push(requirement_claim(measured, "nest", "3", "go-to-the-nest"));
    claims.extend([
        Claim::new("Fig. 5", "starts in the center and moves towards the right")
            .untestable("Neither the figure's arena nor its seed is given; the path drawn here is one of many."),
        wider_gaps(measured),
        Claim::new("Fig. 5", "both maps use 16 neurons and a neighborhood of 4")
            .by_construction("So do all presets here"),
        any_behavior(measured),
        requirement_claim(measured, "follow", "5.1", "many different behaviors, such as following another robot"),
        any_robot(measured),
        Claim::new("5.1", "the amount of supervision required is minimal").untestable(
            "An opinion; what is given here is one goal: 16 intervals with weights, no reward, no examples.",
        ),
    ]);
    claims
}

fn no_bumps(measured: &Measured) -> Claim {
    let clean = measured.rooms.each_ref().map(|rooms| {
        let clean = rooms
            .iter()
            .filter(|room| room.report.contacts == 0)
            .count();
        let contacts: u32 = rooms.iter().map(|room| room.report.contacts).sum();
        let steps: u32 = rooms.iter().map(|room| room.report.steps).sum();
        [
            100.0 * clean as f64 / rooms.len().max(1) as f64,
            1_000.0 * f64::from(contacts) / f64::from(steps.max(1)),
        ]
    });
    let text = |[clean, contacts]: &[f64; 2]| {
        format!("{clean:.1} % of rooms without contact ({contacts:.2} contacts per 1000 decisions)")
    };
    Claim::new(
        "3, Fig. 5",
        "the resulting behaviors do not bump into obstacles",
    )
    .holds_if("nothing touched in 1000 decisions in ≥ 99 % of rooms, by the maps alone")
    .measured(
        by_preset(&PRESETS, &clean, text),
        format!("{} rooms of 12 boxes per preset", measured.size.rooms),
    )
    .verdict(ClaimVerdict::of(&clean.map(|[clean, _]| clean >= 99.0)))
}

fn no_iterations() -> Claim {
    let config = amp::config::Config::touzet();
    let presentations = u32::from(config.learning.epochs) * 100;
    Claim::new("3", "need no learning iterations")
        .holds_if(
            "nothing but the 100 moves is needed: no further move, no presentation of samples",
        )
        .measured(
            format!(
                "0 further moves; {presentations} presentations of samples to both maps, at rest"
            ),
            "all presets",
        )
        .verdict(ClaimVerdict::Partly)
}

fn hundred_moves(measured: &Measured) -> Claim {
    let rooms = measured.size.rooms.div_ceil(2);
    let shares: Vec<[f64; 2]> = measured
        .moves
        .iter()
        .map(|figures| figures.map(|f| percent(f.clean, rooms)))
        .collect();
    let of = |preset: usize| {
        let texts = FEWER_MOVES.iter().zip(&shares);
        let texts: Vec<_> = texts
            .map(|(moves, share)| format!("{moves}: {:.1}", share[preset]))
            .collect();
        format!("{} {}", PRESETS[preset], texts.join(", "))
    };
    let at = |moves: u16, preset: usize| {
        let index = FEWER_MOVES.iter().position(|&m| m == moves);
        index
            .and_then(|i| shares.get(i))
            .map_or(0.0, |share| share[preset])
    };
    let enough = [0, 1].map(|preset| at(100, preset) >= at(200, preset) - 1.0);
    Claim::new("3", "a random exploration of - only - 100 moves")
        .holds_if("after 100 moves as many clean rooms as after 200, within 1 %")
        .measured(
            format!("% clean rooms by moves: {}; {}", of(0), of(1)),
            format!("{rooms} rooms per number"),
        )
        .verdict(ClaimVerdict::of(&enough))
}

fn goal_switches(measured: &Measured) -> Claim {
    // The first behavior is the one that is left.
    let sums = measured.goal_switches.each_ref().map(|answers| {
        answers
            .iter()
            .skip(1)
            .fold((0, 0, 0), |sum, answer: &GoalSwitches| {
                (
                    sum.0 + answer.tried,
                    sum.1 + answer.unchanged,
                    sum.2 + answer.other_action,
                )
            })
    });
    let text = |(tried, unchanged, other): &(u32, u32, u32)| {
        format!(
            "nothing learned or moved in {}, another action at once in {}",
            percents(percent(*unchanged, *tried)),
            percents(percent(*other, *tried))
        )
    };
    let met = sums.map(|(tried, unchanged, other)| tried == unchanged && 2 * other >= tried);
    let others = Behavior::NAMES.len() - 1;
    Claim::new(
        "3",
        "the same 100 iterations can be used to generate another behavior instantaneously",
    )
    .holds_if("memory and maps bit-identical, and another next action in ≥ 50 %")
    .measured(
        by_preset(&PRESETS, &sums, text),
        format!(
            "{} changes from avoidance to {others} other goals per preset",
            sums[0].0
        ),
    )
    .verdict(ClaimVerdict::of(&met))
}

/// Whether an outcome meets the scene's requirement ("≥ 0.80", "≤ 0.20"); without a number, a share
/// must be 1.
fn is_reached(required: &str, outcome: &SceneOutcome) -> bool {
    let number = |text: &str| text.trim().parse::<f64>().unwrap_or(f64::NAN);
    let value = outcome.value.mean;
    match (required.strip_prefix('≥'), required.strip_prefix('≤')) {
        (Some(least), _) => value >= number(least),
        (_, Some(most)) => value <= number(most),
        _ => value >= 0.95,
    }
}

fn requirement_claim(
    measured: &Measured,
    name: &str,
    section: &'static str,
    words: &'static str,
) -> Claim {
    let scenes: Vec<&SceneResult> = measured
        .behaviors
        .iter()
        .filter(|(scene, _)| scene.behavior.starts_with(name) && !scene.behavior.contains(','))
        .collect();
    let first = scenes
        .first()
        .map_or(("", ""), |(scene, _)| (scene.measure, scene.required));
    let texts = [0, 1, 2].map(|i| {
        let values = scenes
            .iter()
            .map(|(_, outcomes)| format!("{:.2}", outcomes[i].value.mean));
        values.collect::<Vec<_>>().join(" / ")
    });
    let met = [0, 1, 2].map(|i| {
        let mut all = scenes.iter();
        all.all(|(scene, outcomes)| is_reached(scene.required, &outcomes[i]))
    });
    let places: Vec<_> = scenes.iter().map(|(scene, _)| scene.title()).collect();
    let episodes = episodes_per_scene(scenes.first().copied());
    Claim::new(section, words)
        .holds_if(match name {
            "nest" => "reached in ≥ 98 % of cases in the small room, ≥ 80 % among boxes".to_owned(),
            _ => format!("{} {} in every scene", first.0, first.1),
        })
        .measured(
            format!(
                "{}: {}",
                first.0,
                by_preset(&PRESETS, &texts, String::clone)
            ),
            format!("{}; {episodes} episodes each", places.join(" / ")),
        )
        .verdict(ClaimVerdict::of(&met))
}

/// Episodes of each scene.
fn episodes_per_scene(first: Option<&SceneResult>) -> usize {
    first.map_or(0, |(_, outcomes)| outcomes[0].episodes)
}

/// Wall gap minus obstacle gap, m, by room or seed.
fn difference<'a>(gaps: impl Iterator<Item = &'a Gaps>) -> Mean {
    let pairs = gaps.filter_map(Gaps::means);
    let values: Vec<_> = pairs
        .map(|[wall, obstacle]| vec![wall - obstacle])
        .collect();
    bootstrap(&values)
}

fn wider_gaps(measured: &Measured) -> Claim {
    let arena = measured
        .arena
        .each_ref()
        .map(|gaps| difference(gaps.iter()));
    let rooms = measured
        .rooms
        .each_ref()
        .map(|rooms| difference(rooms.iter().map(|room| &room.gaps)));
    let text = |mean: &Mean| {
        let [low, high] = mean.interval;
        format!(
            "{:+.0} [{:+.0}, {:+.0}] mm",
            mean.mean * 1e3,
            low * 1e3,
            high * 1e3
        )
    };
    let met: Vec<bool> = arena
        .iter()
        .chain(&rooms)
        .map(|mean| mean.interval[0] > 0.0)
        .collect();
    Claim::new("Fig. 5", "avoids walls from a greater distance than the smaller obstacles")
        .holds_if("smallest gap of a pass: wall minus obstacle > 0 (95 % interval), in the arena and in random rooms")
        .measured(
            format!(
                "arena: {}; rooms: {}",
                by_preset(&PRESETS, &arena, text),
                by_preset(&PRESETS, &rooms, text)
            ),
            format!("{} seeds, {} rooms", measured.arena[0].len(), measured.size.rooms),
        )
        .verdict(ClaimVerdict::of(&met))
}

fn any_behavior(measured: &Measured) -> Claim {
    let scenes = &measured.behaviors;
    let reached = [0, 1, 2].map(|i| {
        let met = scenes
            .iter()
            .filter(|(scene, all)| is_reached(scene.required, &all[i]));
        met.count()
    });
    let all = scenes.len();
    let episodes = episodes_per_scene(scenes.first());
    Claim::new("5.1", "any behavior can be generated")
        .holds_if("every behavior meets its requirement in docs/behaviors.md, in every scene")
        .measured(
            by_preset(&PRESETS, &reached, |count| {
                format!("{count} of {all} scenes")
            }),
            format!("{all} scenes × {episodes} episodes per preset"),
        )
        .verdict(ClaimVerdict::of(&reached.map(|count| count == all)))
}

/// Mean share of the miniature robots' moves that touch something, percent.
fn miniature_contacts(measured: &Measured, of: fn(&Miniature) -> Count) -> f64 {
    let shares = measured.miniatures.iter().map(|miniature| {
        let count = of(miniature);
        percent(count.contacts, count.steps)
    });
    mean(shares)
}

fn any_robot(measured: &Measured) -> Claim {
    let clean = |counts: &[Count]| {
        let clean = counts.iter().filter(|count| count.contacts == 0).count();
        100.0 * clean as f64 / counts.len().max(1) as f64
    };
    let mut met = Vec::new();
    let mut parts = Vec::new();
    for (sensors, counts) in &measured.rings {
        met.push(clean(counts) >= 99.0);
        parts.push(format!("ring of {sensors} {}", percents(clean(counts))));
    }
    let following = percent(measured.following.clean, measured.size.rooms.div_ceil(2));
    met.push(following >= 99.0);
    parts.push(format!(
        "ring turning with the heading {}",
        percents(following)
    ));
    let seeking = miniature_contacts(measured, |miniature| miniature.seeking);
    let exploring = miniature_contacts(measured, |miniature| miniature.exploration);
    met.push(seeking <= exploring / 10.0);
    Claim::new("5.1", "the defined goals are independent of the robot geometry or actuators")
        .holds_if("the same goal keeps ≥ 99 % of rooms clean on any ring; the miniature robot touches at most a tenth as often as by random moves")
        .measured(
            format!(
                "{} clean rooms; miniature robot: {} of its moves touch something, {} of its random ones",
                parts.join(", "),
                percents(seeking),
                percents(exploring)
            ),
            format!(
                "default, {} rooms each; probe, {} miniature robots",
                measured.size.rooms.div_ceil(2),
                measured.miniatures.len()
            ),
        )
        .verdict(ClaimVerdict::of(&met))
}
