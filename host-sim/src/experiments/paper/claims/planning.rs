//! Sections 2.4 and 2.5: the two maps together, from a goal to an action (Figs. 3 and 4), and repetition.

use super::{Claim, PRESETS, Verdict, each, mean, percent, percents};
use crate::experiments::paper::measure::Measured;
use crate::experiments::paper::plans::Plans;
use crate::experiments::repetition::Curve;
use crate::experiments::scenes::Scene;

/// The claims of these sections, in their order.
pub(super) fn claims(measured: &Measured) -> Vec<Claim> {
    let plans = measured.rooms.each_ref().map(|rooms| {
        let all = rooms.iter().map(|room| room.plans);
        all.fold(Plans::default(), Plans::plus)
    });
    let mut claims = vec![brings_about(&plans)];
    claims.extend(improves(measured));
    claims.push(metric(measured));
    claims.push(nearer_neighbour(&plans));
    claims.push(becomes_intermediate(&plans));
    claims.push(until_goal(&plans));
    claims.push(differences(&plans));
    claims
}

fn decisions(plans: &[Plans], count: impl Fn(&Plans) -> u32) -> String {
    let counts: Vec<_> = plans.iter().map(|plans| count(plans).to_string()).collect();
    format!("{} decisions", counts.join(", "))
}

fn brings_about(plans: &[Plans; 3]) -> Claim {
    let nearer = plans.map(|plans| percent(plans.nearer, plans.moves));
    Claim::new(
        "2.4",
        "the action that will change the inputs from the current to the intermediate situation",
    )
    .holds_if("≥ 75 % of the moves lead nearer to the wanted values than where they began")
    .measured(
        each(&PRESETS, &nearer, |share| percents(*share)),
        decisions(plans, |plans| plans.moves),
    )
    .verdict(Verdict::of(&nearer.map(|share| share >= 75.0)))
}

/// A measure of which less is better.
fn is_error(scene: &Scene) -> bool {
    scene.measure.ends_with(" m")
}

fn improves(measured: &Measured) -> [Claim; 2] {
    let curves = &measured.repetitions;
    let gains: Vec<_> = curves.iter().map(gain).collect();
    let better: Vec<bool> = gains.iter().map(|gain| gain.against_frozen > 0).collect();
    let worse = gains.iter().filter(|gain| gain.against_frozen < 0).count();
    let risen = gains.iter().filter(|gain| gain.first_to_last > 0).count();
    let fallen = gains.iter().filter(|gain| gain.first_to_last < 0).count();
    let differing = gains.iter().filter(|gain| gain.against_frozen != 0);
    let differing: Vec<_> = differing.map(|gain| gain.text.clone()).collect();
    let sample = format!(
        "{} scenes of `default`, {} repetitions after 100 random moves",
        curves.len(),
        measured.size.times
    );
    let rises: Vec<bool> = gains.iter().map(|gain| gain.first_to_last > 0).collect();
    [
        Claim::new("2.4", "the behavior performance will improve with repetition")
            .holds_if("the last repetition is better than the first in the mean, their 95 % intervals apart")
            .measured(
                format!("{risen} of {} scenes better, {fallen} worse, the others the same within the intervals", gains.len()),
                sample.clone(),
            )
            .verdict(Verdict::of(&rises)),
        Claim::new("2.4", "learning occurs by the mere realization of the behavior")
            .holds_if("maps that go on learning do better than frozen ones (95 % interval of the difference, last half)")
            .measured(
                format!(
                    "{} of {} scenes better, {worse} worse: {}",
                    better.iter().filter(|&&is| is).count(),
                    gains.len(),
                    if differing.is_empty() { "none differs".to_owned() } else { differing.join("; ") }
                ),
                sample,
            )
            .verdict(Verdict::of(&better)),
    ]
}

/// Whether learning helped (1), hurt (−1), or neither.
struct Gain {
    first_to_last: i8,
    against_frozen: i8,
    text: String,
}

fn gain((scene, curve): &(&'static Scene, Curve)) -> Gain {
    let sign = |low: f64, high: f64| {
        let up = i8::from(low > 0.0) - i8::from(high < 0.0);
        if is_error(scene) { -up } else { up }
    };
    let [low, high] = curve.difference.interval;
    let first_to_last = match (curve.learning.first(), curve.learning.last()) {
        (Some(first), Some(last)) => sign(
            last.interval[0] - first.interval[1],
            last.interval[1] - first.interval[0],
        ),
        _ => 0,
    };
    Gain {
        first_to_last,
        against_frozen: sign(low, high),
        text: format!(
            "{} {:+.3} {}",
            scene.title(),
            curve.difference.mean,
            scene.measure
        ),
    }
}

fn metric(measured: &Measured) -> Claim {
    let [_, probe, touzet] = measured
        .rooms
        .each_ref()
        .map(|rooms| mean(rooms.iter().map(|room| room.order.correlation)));
    let mini = mean(measured.miniatures.iter().map(|m| m.order.correlation));
    let all = [probe, touzet, mini];
    Claim::new(
        "2.5 (1)",
        "neighborhood conservation allows the definition of a metric on the input space",
    )
    .holds_if("grid steps and code distance correlate by ≥ 0.7 (Pearson)")
    .measured(
        each(&["probe", "touzet", "miniature"], &all, |r| {
            format!("{r:.2}")
        }),
        format!(
            "{} rooms per preset, {} miniature robots",
            measured.size.rooms,
            measured.miniatures.len()
        ),
    )
    .verdict(Verdict::of(&all.map(|r| r >= 0.7)))
}

fn nearer_neighbour(plans: &[Plans; 3]) -> Claim {
    let shares = [plans[1], plans[2]].map(|plans| {
        let share = |count| percent(count, plans.unmet);
        [
            share(plans.nearer_neighbour),
            share(plans.neighbour - plans.nearer_neighbour),
            share(plans.at_goal_neuron),
            share(plans.no_nearer),
        ]
    });
    let text = |[nearer, not_nearer, goal, none]: &[f64; 4]| {
        format!(
            "{nearer:.0} % nearer neighbour, {not_nearer:.0} % neighbour not nearer in its code, {goal:.0} % at the goal neuron, {none:.0} % none (a local minimum)"
        )
    };
    let met = shares.map(|[nearer, _, goal, _]| nearer + goal >= 90.0);
    Claim::new(
        "2.5 (1)",
        "possible to choose a neighbor neuron closer to the goal",
    )
    .holds_if(
        "in ≥ 90 % of decisions away from the goal there is one, or the goal neuron is reached",
    )
    .measured(
        each(&PRESETS[1..], &shares, text),
        decisions(&plans[1..], |plans| plans.unmet),
    )
    .verdict(Verdict::of(&met))
}

fn becomes_intermediate(plans: &[Plans; 3]) -> Claim {
    let there = [plans[1], plans[2]].map(|plans| percent(plans.at_aim, plans.neighbour));
    Claim::new(
        "2.5 (2)",
        "the action that will move the robot into that desired intermediate situation",
    )
    .holds_if("after ≥ 50 % of the moves the neuron aimed at is the best-matching one")
    .measured(
        each(&PRESETS[1..], &there, |share| percents(*share)),
        decisions(&plans[1..], |plans| plans.neighbour),
    )
    .verdict(Verdict::of(&there.map(|share| share >= 50.0)))
}

fn until_goal(plans: &[Plans; 3]) -> Claim {
    let stretches = |plans: &Plans| plans.reached + plans.unfinished;
    let soon = plans.map(|plans| percent(plans.reached_soon, stretches(&plans)));
    let texts: Vec<_> = plans
        .iter()
        .zip(&soon)
        .map(|(plans, soon)| {
            let mean = f64::from(plans.reached_in) / f64::from(plans.reached.max(1));
            format!("{soon:.1} % ({mean:.1} decisions on the average)")
        })
        .collect();
    let counts: Vec<_> = plans.iter().map(|p| stretches(p).to_string()).collect();
    Claim::new(
        "2.5 (3)",
        "repeated until the robot is in the desired goal situation",
    )
    .holds_if("free of obstacles again within 10 decisions in ≥ 95 % of the stretches away from it")
    .measured(
        each(&PRESETS, &texts, String::clone),
        format!("{} stretches", counts.join(", ")),
    )
    .verdict(Verdict::of(&soon.map(|share| share >= 95.0)))
}

fn differences(plans: &[Plans; 3]) -> Claim {
    let agreement = plans.map(|plans| plans.agreement / f64::from(plans.changes.max(1)));
    Claim::new(
        "Fig. 4",
        "the sensory differences are the inputs for probing the second map",
    )
    .holds_if("mean cosine ≥ 0.5 between the wanted change and the one measured after the move")
    .measured(
        each(&PRESETS, &agreement, |cosine| format!("{cosine:.2}")),
        decisions(plans, |plans| plans.changes),
    )
    .verdict(Verdict::of(&agreement.map(|cosine| cosine >= 0.5)))
}
