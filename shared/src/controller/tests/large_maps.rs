//! Maps of more neurons than a [`Mask`](crate::fixed::Mask) has bits.

use super::*;
use crate::fixed::Selection;
use std::boxed::Box;

const NEURONS: usize = 64;

/// A robot whose 64 actions point all around; each sensor's value
/// rises by the cosine of the angle to the move.
fn robot(config: &Config<16>) -> Box<State<16, NEURONS, 4>> {
    let grid = Grid::rectangle(8, 8);
    let mut state = Box::new(State::new(grid));
    let heading = |neuron: usize| Bearing::from_turns((neuron << 10) as u16);
    let action = |neuron: usize| {
        let way = Displacement::along(heading(neuron), 250);
        config.action_code.encode(way, 250)
    };
    let change = |neuron: usize| {
        let way = heading(neuron).direction();
        config.robot.directions.map(|axis| {
            let cosine = axis.along(i32::from(way.x_q14), i32::from(way.y_q14));
            Weight::from_bits((cosine / 36) as i16)
        })
    };
    let (changes, actions) = (core::array::from_fn(change), core::array::from_fn(action));
    state.replace_actions(ActionMap::new(grid, changes, actions));
    state.learned = true;
    state
}

/// The neuron of the first decision beside a wall, with these neurons inhibited.
fn decided(inhibited: &[usize]) -> usize {
    let mut config = Config::recommended();
    config.shield = None;
    config.online = None;
    let mut state = robot(&config);
    let goal = Goal::nothing_within(Range::from_mm(600), config.encoding);
    let at = Millis::from_ms(0);
    let _ = handle(&config, &mut state, at, Event::Command(Command::Seek(goal)));
    for neuron in inhibited {
        state.inhibited[*neuron] = 3;
    }
    let mut last = Outputs::NONE;
    for sensor in 0..16_u8 {
        let mm = if (10..=14).contains(&sensor) {
            150
        } else {
            3_000
        };
        let range = Some(Range::from_mm(mm));
        last = handle(
            &config,
            &mut state,
            Millis::from_ms(640),
            Event::Echo { sensor, range },
        );
    }
    let plan = last.decision.and_then(|decision| decision.plan);
    plan.expect("a decision").action_neuron.into()
}

#[test]
fn every_neuron_of_64_can_be_inhibited() {
    let config = Config::recommended();
    for neuron in [0, 31, 32, 47, 63] {
        let mut state = robot(&config);
        state.inhibited[neuron] = 1;
        let allowed: crate::fixed::WideMask = state.allowed_neurons();
        let left_out: Vec<_> = (0..NEURONS).filter(|k| !allowed.contains(*k)).collect();
        assert_eq!(left_out, [neuron]);
    }
}

#[test]
fn a_decision_avoids_an_inhibited_neuron_beyond_the_32nd() {
    // Of 16 headings each is the way of another neuron; the best one is inhibited, again and again.
    let mut inhibited = Vec::new();
    for _ in 0..16 {
        let neuron = decided(&inhibited);
        assert!(!inhibited.contains(&neuron), "{neuron} of {inhibited:?}");
        inhibited.push(neuron);
    }
    assert!(inhibited.iter().any(|neuron| *neuron >= 32));
}
