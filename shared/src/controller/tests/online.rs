//! What is learned on the way, move by move.

use super::*;
use crate::config::{LearnFrom, Online, PlannerKind};
use crate::fixed::Weight32;

#[test]
fn without_online_learning_the_maps_stay() {
    let seek = |config: Config<16>| {
        let mut bench = Bench::ready(config);
        let maps = (
            bench.state.situations().clone(),
            bench.state.actions().clone(),
        );
        bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
        for _ in 0..30 {
            bench.step();
        }
        maps == (
            bench.state.situations().clone(),
            bench.state.actions().clone(),
        )
    };
    assert!(seek(Config {
        online: None,
        ..Config::recommended()
    }));
    assert!(!seek(Config::recommended()));
}

#[test]
fn rates_of_online_learning_fall_as_one_over_n_and_begin_anew_with_new_maps() {
    let mut bench = Bench::ready(Config::recommended());
    let state = &mut bench.state;
    assert_eq!(state.updates, 0);
    let mut halvings = 0;
    for lesson in 1..=70_000_u32 {
        let now = state.halvings();
        assert!(now == halvings || lesson.is_power_of_two(), "{lesson}");
        assert_eq!(
            now,
            (lesson.min(65_535) / 2_048 * 2)
                .checked_ilog2()
                .unwrap_or(0)
        );
        halvings = now;
    }
    assert_eq!(halvings, 5);
    bench.send(Event::Command(Command::Learn));
    assert_eq!(bench.state.updates, 0);
}

#[test]
fn a_map_that_has_learned_long_moves_less() {
    let moved = |updates| {
        let mut bench = Bench::ready(Config::recommended());
        bench.state.updates = updates;
        bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
        bench.step();
        let before = bench.state.situations().code().to_vec();
        bench.step();
        let after = bench.state.situations().code();
        let values = before.iter().flatten().zip(after.iter().flatten());
        values
            .map(|(before, after)| f64::from(before.to_bits().abs_diff(after.to_bits())))
            .sum::<f64>()
    };
    let (young, old) = (moved(0), moved(40_000));
    assert!(young > 0.0, "{young}");
    assert!((old / young - 1.0 / 32.0).abs() < 0.005, "{old} of {young}");
}

/// What one move teaches while the robot seeks: a robot that gets half as far as it was to, its
/// maps before and after, and the neuron it asked.
fn taught_by_half_a_move(change: impl Fn(&mut Config<16>)) -> (Robot, Robot, Motion, usize) {
    taught(change, |asked| asked.with_length(asked.length_mm() / 2))
}

/// The same of a robot that is moved otherwise.
fn taught(
    change: impl Fn(&mut Config<16>),
    moved: fn(Displacement) -> Displacement,
) -> (Robot, Robot, Motion, usize) {
    let mut config = Config::probing();
    change(&mut config);
    let mut bench = Bench::ready(config);
    (bench.x, bench.y) = (1_300, 400);
    bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
    let out = bench.ring();
    let (motion, plan) = (
        out.motion.expect("a motion"),
        out.decision.and_then(|d| d.plan).expect("a plan"),
    );
    let before = bench.state.clone();
    bench.execute(Motion {
        displacement: moved(motion.displacement),
        ..motion
    });
    bench.ring();
    (before, bench.state, motion, plan.action_neuron.into())
}

/// Neurons of both maps that have changed.
fn changed(before: &Robot, after: &Robot) -> [Vec<usize>; 2] {
    let differ = |k: &usize| {
        [
            before.situations().code()[*k] != after.situations().code()[*k],
            before.actions().actions().code()[*k] != after.actions().actions().code()[*k],
        ]
    };
    [0, 1].map(|map| (0..16).filter(|k| differ(k)[map]).collect())
}

#[test]
fn each_move_teaches_the_winners_alone_or_their_neighbors_as_well() {
    let (before, after, motion, _) = taught_by_half_a_move(|_| ());
    let [situations, actions] = changed(&before, &after);
    assert_eq!((situations.len(), actions.len()), (1, 1));
    // A fiftieth of the way towards what was carried out: half of what was asked for.
    let towards = |share: f64, before: &Robot, after: &Robot, winner: usize| {
        let part =
            |state: &Robot, i: usize| state.actions().actions().code()[winner][i].to_num::<f64>();
        let mm = [motion.displacement.dx_mm, motion.displacement.dy_mm];
        (0..2).all(|i| {
            let taught = f64::from(mm[i]) * share / 250.0;
            let expected = part(before, i) + (taught - part(before, i)) * 1_310.0 / 65_536.0;
            (part(after, i) - expected).abs() < 2e-4
        })
    };
    assert!(towards(0.5, &before, &after, actions[0]));
    let (before, after, _, _) =
        taught_by_half_a_move(|config| config.learning.learn_from = LearnFrom::Commanded);
    let [_, actions] = changed(&before, &after);
    assert!(towards(1.0, &before, &after, actions[0]));
    let shared = |config: &mut Config<16>| {
        config.online = config.online.map(|online| Online {
            share_q16: 32_768,
            ..online
        });
    };
    let (before, after, _, _) = taught_by_half_a_move(shared);
    let [situations, actions] = changed(&before, &after);
    assert!(
        situations.len() >= 3 && actions.len() >= 3,
        "{situations:?} {actions:?}"
    );
    // The neuron that was asked may be the one that is to know better.
    let blamed = |config: &mut Config<16>| {
        config.online = config.online.map(|online| Online {
            blame_recalled: true,
            ..online
        });
    };
    // It is pushed back: another neuron knew that this would come of it.
    let pushed = |asked: Displacement| Displacement::ZERO.minus(asked);
    let (before, after, _, asked) = taught(blamed, pushed);
    assert_eq!(changed(&before, &after)[1], [asked]);
    let (before, after, _, asked) = taught(|_| (), pushed);
    assert_ne!(changed(&before, &after)[1], [asked]);
}

/// What the one neuron that learned from a move was taught of action and change: it went a fiftieth
/// of the way there.
fn lesson(before: &Robot, after: &Robot) -> ([f64; 2], [f64; 16]) {
    let [_, winners] = changed(before, after);
    assert_eq!(winners.len(), 1);
    let [(action, change), (new_action, new_change)] = [before, after].map(|robot| {
        let map = robot.actions();
        let winner = winners[0];
        (map.actions().code()[winner], map.changes().code()[winner])
    });
    let taught = |before: Weight32, after: Weight32| {
        let (before, after) = (before.to_num::<f64>(), after.to_num::<f64>());
        before + (after - before) * 65_536.0 / 1_310.0
    };
    (
        core::array::from_fn(|i| taught(action[i], new_action[i])),
        core::array::from_fn(|i| taught(change[i], new_change[i])),
    )
}

/// By how much of a turn the action that was taught is off the motion.
fn turned(action: [f64; 2], motion: Motion) -> u16 {
    let mm = action.map(|part| (part * 250.0) as i32);
    let taught = Displacement::saturating(mm[0], mm[1]).bearing();
    taught.minus(motion.displacement.bearing()).as_turns()
}

/// One step ahead, moves are taught turned by a random number of ring places, change and action
/// alike.
#[test]
fn what_is_learned_on_the_way_is_turned_with_the_ring() {
    let (before, after, motion, _) =
        taught_by_half_a_move(|config| *config = Config::recommended());
    let (action, change) = lesson(&before, &after);
    let turns = turned(action, motion).wrapping_add(2_048);
    assert!(
        (turns % 4_096).abs_diff(2_048) < 200 && turns > 4_096,
        "{turns}"
    );
    let places = usize::from(turns >> 12);
    let encoding = Config::recommended().encoding;
    let [was, is] = [&before, &after].map(|robot| encoding.situation(robot.scan()));
    for place in 0..16 {
        let brought = (is[place] - was[place]).to_num::<f64>();
        let taught = change[(place + places) % 16];
        assert!(
            (taught - brought).abs() < 1e-3,
            "{place}: {taught} {brought}"
        );
    }
}

/// A robot before and after a move in which ranges that change by more than 100 mm belong to
/// another surface, the move, and by how much each range changed.
fn past_other_surfaces(most_changed: u8) -> (Robot, Robot, Motion, [f64; 16]) {
    let mut bench = Bench::ready(Config::recommended());
    bench.config.learning.largest_change_mm = 100;
    bench.config.learning.most_changed = most_changed;
    (bench.x, bench.y) = (1_300, 400);
    bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
    let motion = bench.ring().motion.expect("a motion");
    let before = bench.state.clone();
    bench.execute(motion);
    bench.ring();
    let encoding = bench.config.encoding;
    let [was, is] = [&before, &bench.state].map(|robot| encoding.situation(robot.scan()));
    let changes_mm = core::array::from_fn(|i| (is[i] - was[i]).to_num::<f64>().abs() * 4_500.0);
    (before, bench.state, motion, changes_mm)
}

/// With more than the most allowed in a move the action map learns nothing from it; the situation
/// map learns what is there.
#[test]
#[cfg_attr(miri, ignore = "eighteen robots made ready: minutes")]
fn a_move_to_many_other_surfaces_teaches_no_action() {
    let learned_with = |most_changed| {
        let (before, after, _, changes_mm) = past_other_surfaces(most_changed);
        let many = changes_mm.iter().filter(|mm| **mm > 100.0).count();
        (many, changed(&before, &after).map(|neurons| neurons.len()))
    };
    let (many, _) = learned_with(255);
    assert!((3..=13).contains(&many), "{many}");
    for most in 0..=16 {
        let actions = usize::from(usize::from(most) >= many);
        assert_eq!(learned_with(most), (many, [1, actions]), "{most}");
    }
}

/// Of a move of up to 250 mm only those changes are learned that are below 100 mm.
#[test]
fn ranges_of_another_surface_are_not_learned() {
    let (before, after, motion, changes_mm) = past_other_surfaces(255);
    let (action, _) = lesson(&before, &after);
    let places = usize::from(turned(action, motion).wrapping_add(2_048) >> 12);
    assert_ne!(places, 0);
    let [_, winners] = changed(&before, &after);
    let [old, new] = [&before, &after].map(|robot| robot.actions().changes().code()[winners[0]]);
    let mut learned = 0;
    for (place, change_mm) in changes_mm.into_iter().enumerate() {
        let component = (place + places) % 16;
        let is_learned = old[component] != new[component];
        assert_eq!(is_learned, change_mm < 100.0, "{place}: {change_mm}");
        learned += usize::from(is_learned);
    }
    assert!((3..=13).contains(&learned), "{learned}");
}

#[test]
#[cfg_attr(miri, ignore = "four robots made ready: minutes")]
fn what_is_learned_on_the_way_is_not_turned_where_that_would_be_another_ring() {
    let changes: [fn(&mut Config<16>); 4] = [
        |config| config.learning.augment_rotations = false,
        |config| config.enabled = Mask::ALL.without(11),
        // The first transducer need not look ahead.
        |config| {
            config.robot.symmetric = false;
            config.robot.directions.rotate_left(4);
        },
        |config| config.planning.planner = PlannerKind::Recall,
    ];
    for change in changes {
        let (before, after, motion, _) = taught_by_half_a_move(|config| {
            *config = Config::recommended();
            change(config);
        });
        let off = turned(lesson(&before, &after).0, motion);
        assert!(off.wrapping_add(200) < 400, "{off}");
    }
}

/// Whatever has been learned since, and whoever learned it.
#[test]
#[cfg_attr(miri, ignore = "sixty decisions: minutes")]
fn a_decision_is_taken_by_the_maps_as_they_are() {
    for share_q16 in [0, 65_536] {
        let mut bench = Bench::ready(Config::probing());
        bench.config.online = bench.config.online.map(|online| Online {
            situation_rate_q16: 32_768,
            share_q16,
            ..online
        });
        // Something like what it learns about all the time.
        let here = bench.config.encoding.situation(bench.state.scan());
        let goal = Goal::perceived(&here);
        bench.send(Event::Command(Command::Seek(goal)));
        for _ in 0..30 {
            let out = bench.ring();
            let decision = out.decision.expect("a decision");
            let plan = decision.plan.expect("a plan");
            let map = bench.state.situations();
            let nearest = map.bmu(&decision.situation, Mask::ALL);
            let deviation = |k: &usize| goal.distance(&map.code_vector(*k), Mask::ALL);
            let wanted = (0..16).min_by_key(deviation).expect("a neuron");
            assert_eq!(
                [plan.current_neuron, plan.goal_neuron].map(usize::from),
                [nearest, wanted]
            );
            bench.execute(out.motion.expect("a motion"));
        }
    }
}
