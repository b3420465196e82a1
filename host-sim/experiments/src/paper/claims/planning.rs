//! Claims of sections 2.4 and 2.5: the two maps together, from a goal to an action (Figs. 3 and 4).

use super::{Claim, ClaimVerdict, PRESETS, by_preset, percent, percents};
use crate::paper::measure::Measured;
use crate::paper::plans::Plans;
use crate::traversed::Aims;
use sim::statistics::mean;

/// The claims of these sections, in order.
pub(super) fn claims(measured: &Measured) -> Vec<Claim> {
    let plans = measured.rooms.each_ref().map(|rooms| {
        let all = rooms.iter().map(|room| room.plans);
        all.fold(Plans::default(), Plans::plus)
    });
    vec![
        brings_about(&plans),
        metric(measured),
        nearer_neighbor(&plans),
        becomes_intermediate(&plans),
        aim_is_reached(&measured.traversed),
        until_goal(&plans),
        differences(&plans),
    ]
}

fn decisions(plans: &[Plans], count: impl Fn(&Plans) -> u32) -> String {
    let counts: Vec<_> = plans.iter().map(|plans| count(plans).to_string()).collect();
    format!("{} decisions", counts.join(", "))
}

/// For the readings that probe the action map with the wanted change.
fn brings_about([_, probe, touzet]: &[Plans; 3]) -> Claim {
    let plans = [*probe, *touzet];
    let shares = plans.map(|plans| {
        [
            percent(plans.along, plans.moves),
            percent(plans.nearer, plans.moves),
        ]
    });
    let text = |[along, nearer]: &[f64; 2]| {
        format!("{along:.1} % (nearer to the wanted values than before: {nearer:.1} %)")
    };
    Claim::new(
        "2.4",
        "the action that will change the inputs from the current to the intermediate situation",
    )
    .holds_if("≥ 75 % of the moves change the wanted values in the wanted direction (cosine > 0)")
    .measured(
        by_preset(&PRESETS[1..], &shares, text),
        decisions(&plans, |plans| plans.moves),
    )
    .verdict(ClaimVerdict::of(&shares.map(|[along, _]| along >= 75.0)))
}

fn metric(measured: &Measured) -> Claim {
    let [_, probe, touzet] = measured
        .rooms
        .each_ref()
        .map(|rooms| mean(rooms.iter().map(|room| room.topology.correlation)));
    let mini = mean(measured.miniatures.iter().map(|m| m.topology.correlation));
    let all = [probe, touzet, mini];
    Claim::new(
        "2.5 (1)",
        "neighborhood conservation allows the definition of a metric on the input space",
    )
    .holds_if("grid steps and code distance correlate by ≥ 0.7 (Pearson)")
    .measured(
        by_preset(&["probe", "touzet", "miniature"], &all, |r| {
            format!("{r:.2}")
        }),
        format!(
            "{} rooms per preset, {} miniature robots",
            measured.size.rooms,
            measured.miniatures.len()
        ),
    )
    .verdict(ClaimVerdict::of(&all.map(|r| r >= 0.7)))
}

fn nearer_neighbor(plans: &[Plans; 3]) -> Claim {
    let shares = [plans[1], plans[2]].map(|plans| {
        let share = |count| percent(count, plans.unmet);
        [
            share(plans.nearer_neighbor),
            share(plans.neighbor - plans.nearer_neighbor),
            share(plans.at_goal_neuron),
            share(plans.no_nearer),
        ]
    });
    let text = |[nearer, not_nearer, goal, none]: &[f64; 4]| {
        format!(
            "{nearer:.0} % nearer neighbor, {not_nearer:.0} % neighbor not nearer in its code, {goal:.0} % at a neuron that meets the goal, {none:.0} % none (a local minimum)"
        )
    };
    let met = shares.map(|[nearer, _, goal, _]| nearer + goal >= 90.0);
    Claim::new(
        "2.5 (1)",
        "possible to choose a neighbor neuron closer to the goal",
    )
    .holds_if(
        "in ≥ 90 % of decisions away from the goal there is one, or the present neuron meets the goal already",
    )
    .measured(
        by_preset(&PRESETS[1..], &shares, text),
        decisions(&plans[1..], |plans| plans.unmet),
    )
    .verdict(ClaimVerdict::of(&met))
}

fn becomes_intermediate(plans: &[Plans; 3]) -> Claim {
    let there = [plans[1], plans[2]].map(|plans| percent(plans.at_aim, plans.neighbor));
    Claim::new(
        "2.5 (2)",
        "the action that will move the robot into that desired intermediate situation",
    )
    .holds_if("after ≥ 50 % of the moves the neuron aimed at is the best-matching one")
    .measured(
        by_preset(&PRESETS[1..], &there, |share| percents(*share)),
        decisions(&plans[1..], |plans| plans.neighbor),
    )
    .verdict(ClaimVerdict::of(&there.map(|share| share >= 50.0)))
}

/// The neighbors are those that were really driven to.
fn aim_is_reached(aims: &Aims) -> Claim {
    let share = |part: f64| 100.0 * part / f64::from(aims.legs.max(1));
    let reached = share(aims.reached.into());
    let often = share(aims.most_frequent.into());
    Claim::new(
        "2.5 (2)",
        "move the robot into that desired intermediate situation (a neighbor that was driven to)",
    )
    .holds_if(
        "in ≥ 50 % of the aims of preset graph the next neuron is the one aimed at, and more often than the most frequent successor",
    )
    .measured(
        format!(
            "reached {reached:.1} %, the most frequent successor {often:.1} %, a random one of the successors {:.1} %; after one move {:.1} %",
            share(aims.random),
            percent(aims.after_one, aims.moves)
        ),
        format!("{} aims, {} worlds of twelve other kinds", aims.legs, aims.drives),
    )
    .verdict(ClaimVerdict::of(&[reached >= 50.0, reached > often]))
}

fn until_goal(plans: &[Plans; 3]) -> Claim {
    let stretches = |plans: &Plans| plans.reached + plans.unfinished;
    let soon = plans.map(|plans| percent(plans.reached_soon, stretches(&plans)));
    let texts: Vec<_> = plans
        .iter()
        .zip(&soon)
        .map(|(plans, soon)| {
            let mean = f64::from(plans.reached_in) / f64::from(plans.reached.max(1));
            format!("{soon:.1} % ({mean:.1} decisions on average)")
        })
        .collect();
    let counts: Vec<_> = plans.iter().map(|p| stretches(p).to_string()).collect();
    Claim::new(
        "2.5 (3)",
        "repeated until the robot is in the desired goal situation",
    )
    .holds_if("free of obstacles again within 10 decisions in ≥ 95 % of the periods without it")
    .measured(
        by_preset(&PRESETS, &texts, String::clone),
        format!("{} stretches", counts.join(", ")),
    )
    .verdict(ClaimVerdict::of(&soon.map(|share| share >= 95.0)))
}

fn differences([_, probe, touzet]: &[Plans; 3]) -> Claim {
    let plans = [*probe, *touzet];
    let agreement = plans.map(|plans| plans.agreement / f64::from(plans.changes.max(1)));
    Claim::new(
        "Fig. 4",
        "the sensory differences are the inputs for probing the second map",
    )
    .holds_if(
        "mean cosine ≥ 0.5 between the change probed with and the one measured after the move",
    )
    .measured(
        by_preset(&PRESETS[1..], &agreement, |cosine| format!("{cosine:.2}")),
        decisions(&plans, |plans| plans.changes),
    )
    .verdict(ClaimVerdict::of(&agreement.map(|cosine| cosine >= 0.5)))
}
