use super::*;
use crate::scenes::BehaviorScene;
use amp::fixed::{Mask, Weight};
use amp::goal::Goal;
use amp::memory::Sample;
use amp::planner::Planner;
use amp::som::{Grid, Som, Update};
use amp::units::{Displacement, Range};
use arena::sonar::SonarModel;
use arena::world::World;
use sim::episode::run;
use std::f64::consts::TAU;

fn config() -> Config<16> {
    let mut config = Config::recommended();
    config.shield = None;
    config
}

/// The linear fit that the planner computes, in floats.
fn fitted<const NEURONS: usize>(slopes: &Slopes) -> Slopes {
    let map = coded::<NEURONS>(slopes, Grid::chain(NEURONS as u16));
    std::array::from_fn(|sensor| {
        let mut sums = [0.0; 5];
        for (action, change) in map.actions().code().iter().zip(map.changes().code()) {
            let [x, y] = action.map(|part| part.to_num::<f64>());
            let change = change[sensor].to_num::<f64>();
            for (sum, term) in sums
                .iter_mut()
                .zip([x * x, x * y, y * y, x * change, y * change])
            {
                *sum += term;
            }
        }
        let [xx, xy, yy, xc, yc] = sums;
        let determinant = xx * yy - xy * xy;
        [
            (yy * xc - xy * yc) / determinant,
            (xx * yc - xy * xc) / determinant,
        ]
    })
}

/// 0.25 m of 4.5 m: 0.0556 per step straight ahead, by the cosine of the angle elsewhere.
#[test]
fn the_code_vectors_of_a_cosine_fit_that_cosine() {
    let close = |slopes: &Slopes, found: &Slopes| {
        let pairs = slopes.as_flattened().iter().zip(found.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!((steepest(&config()) - 0.25 / 4.5).abs() < 1e-12);
    for gain in [0.5, 1.0, 2.0] {
        let exact: Slopes = std::array::from_fn(|sensor| {
            let angle = TAU * sensor as f64 / 16.0;
            [libm::cos(angle), libm::sin(angle)].map(|part| gain * 0.25 / 4.5 * part)
        });
        // The robot's directions are exact to 0.0011.
        assert!(close(&exact, &cosine(&config(), gain)) < 1.3e-4, "{gain}");
        // A component is rounded to 2⁻¹³.
        assert!(close(&exact, &fitted::<16>(&exact)) < 4e-5, "{gain}");
        assert!(close(&exact, &fitted::<4>(&exact)) < 9e-5, "{gain}");
        assert!(close(&exact, &fitted::<64>(&exact)) < 4e-5, "{gain}");
    }
}

/// The planner of the controller itself predicts by that cosine.
#[test]
fn the_planner_predicts_with_what_stands_in_the_slot() {
    let config = config();
    let map = coded::<16>(&cosine(&config, 1.0), Grid::rectangle(4, 4));
    let situations = Som::zeroed(Grid::rectangle(4, 4));
    let planner = Planner {
        config: &config,
        situations: &situations,
        actions: &map,
        enabled: Mask::ALL,
        allowed: Mask::ALL,
        current: None,
        course: Displacement::ZERO,
        cut: false,
    };
    // A wall near sensor 4, all else half way.
    let mut situation = [Weight::from_num(0.5); 16];
    situation[4] = Weight::from_num(0.95);
    let goal = Goal::nothing_within(Range::from_mm(600), config.encoding);
    let plan = planner.plan(&situation, &goal);
    let [x, y] = [plan.action.dx_mm, plan.action.dy_mm].map(|mm| f64::from(mm) / 250.0);
    assert!(y < -0.9, "away from the wall: {x} {y}");
    for (sensor, wanted) in plan.wanted.iter().enumerate() {
        let angle = TAU * sensor as f64 / 16.0;
        let expected = 0.25 / 4.5 * (x * libm::cos(angle) + y * libm::sin(angle));
        let error = (wanted.to_num::<f64>() - expected).abs();
        assert!(error < 6e-4, "sensor {sensor}: {wanted} {expected}");
    }
}

/// Moves of which sensor 0 sees a wall ahead, sensor 3 one that recedes by half; nothing else
/// changes.
fn samples() -> Vec<Sample<16>> {
    let moves = [(200, 0), (-100, 50), (0, -200), (120, 160), (-50, -50)];
    let of = |(dx_mm, dy_mm): (i16, i16)| {
        let moved = Displacement { dx_mm, dy_mm };
        let mut after = [100_u8; 16];
        after[0] = (100 + dx_mm / 10) as u8;
        after[3] = (100 - dy_mm / 20) as u8;
        Sample {
            before: [100; 16],
            after,
            commanded: Displacement::ZERO,
            executed: moved,
        }
    };
    moves.into_iter().map(of).collect()
}

#[test]
fn least_squares_finds_what_made_the_samples() {
    // 25 and 12.5 of 254 per 250 mm; bytes are whole.
    let slopes = fit(pool(&config(), &samples(), false).iter());
    for (sensor, expected) in [(0, [0.0984, 0.0]), (3, [0.0, -0.0492]), (5, [0.0; 2])] {
        for (found, expected) in slopes[sensor].iter().zip(expected) {
            assert!((found - expected).abs() < 2e-3, "{sensor}: {slopes:?}");
        }
    }
    // In all rotations every sensor is the same: along its axis (0.098 − 0.049 · sin 67.5°) / 16.
    let turned = pool(&config(), &samples(), true);
    assert_eq!(turned.len(), 80);
    let slopes = fit(turned.iter());
    let ahead = slopes[0][0];
    assert!((0.002..0.005).contains(&ahead), "{ahead}");
    for (sensor, slope) in slopes.iter().enumerate() {
        let angle = TAU * sensor as f64 / 16.0;
        let along = slope[0] * libm::cos(angle) + slope[1] * libm::sin(angle);
        assert!((along - ahead).abs() < 1e-4, "{sensor}: {along} {ahead}");
    }
    // One move does not span the plane.
    let one = pool(&config(), &samples()[..1], false);
    assert_eq!(fit(one.iter()), [[0.0; 2]; 16]);
}

#[test]
fn the_nearest_samples_alone_are_fitted() {
    let (mut near, mut far) = (samples(), samples());
    for sample in &mut far {
        sample.before = [200; 16];
        sample.after = [200; 16];
    }
    near.extend(far);
    let pool = pool(&config(), &near, false);
    let at = |value: f64| nearest_fit(&pool, &[Weight::from_num(value); 16], 5);
    assert!((at(0.4)[0][0] - 0.0984).abs() < 2e-3);
    assert_eq!(at(0.8)[0], [0.0; 2]);
    // With all of them it is the mean of both.
    let all = nearest_fit(&pool, &[Weight::from_num(0.4); 16], 100);
    assert!((all[0][0] - 0.0492).abs() < 2e-3);
}

#[test]
fn quantization_moves_the_winner_alone() {
    let learning = Training::Quantization.of(config()).learning;
    for training in [learning.situations, learning.actions] {
        for step in [0, 500, 9_999] {
            let [rate, radius] = [&training.rate, &training.radius].map(|s| s.at(step, 10_000));
            let update = Update::from_q16(training.neighborhood, rate, radius);
            let mut moved = Vec::new();
            update.for_each(Grid::rectangle(4, 4), 5, |neuron, _| moved.push(neuron));
            assert_eq!(moved, [5], "step {step}");
        }
    }
    assert_eq!(learning.start, Initialization::Samples);
}

fn trial(sonar: SonarModel, neurons: u8) -> ControlTrial {
    ControlTrial {
        first: 300,
        worlds: 1,
        seeds: 2,
        explore_moves: 30,
        preset: "default",
        config: Config::recommended(),
        sonar,
        neurons,
    }
}

#[test]
fn every_row_drives_and_only_the_first_is_the_controller() {
    let rows = rows();
    assert_eq!(rows.len(), 24);
    let titles: Vec<_> = rows.iter().map(ControlRow::title).collect();
    assert!(
        titles
            .iter()
            .all(|title| titles.iter().filter(|t| *t == title).count() == 1)
    );
    let measures: Vec<_> = measures(WorldSet::Rooms)
        .into_iter()
        .filter(|measure| measure.scene.behavior == "avoid")
        .collect();
    let of = |row: &ControlRow| measure(row, &measures, &trial(SonarModel::Ideal, 16), &|| ());
    let all: Result<Vec<_>, _> = rows.iter().map(of).collect();
    let all = all.expect("they drive");
    let areas: Vec<_> = all.iter().map(|results| results[1].mean().mean).collect();
    for (index, area) in areas.iter().enumerate() {
        assert!(*area > 0.0, "{}", titles[index]);
        assert!(
            index == 0 || (area - areas[0]).abs() > 1e-9,
            "{}",
            titles[index]
        );
    }
}

#[test]
fn the_first_row_is_the_controller_and_64_neurons_are_another() {
    let measures = measures(WorldSet::Rooms);
    let area: &BehaviorScene = measures[1].scene;
    let row = rows()[0];
    let of = |neurons| {
        let results = measure(
            &row,
            &measures[..2],
            &trial(SonarModel::Ideal, neurons),
            &|| (),
        );
        results.expect("they drive")[1].mean().mean
    };
    let world = World::random(300);
    let plain = crate::behaviors::run_all(
        area,
        &crate::behaviors::BehaviorTrial {
            first: 300,
            worlds: 1,
            seeds: 2,
            explore_moves: 30,
            preset: "default",
            config: config(),
            turret: arena::robot::TurretMode::Held,
            robot: None,
            sonar: SonarModel::Ideal,
        },
        |room, setup| {
            assert_eq!(room, &world);
            Ok(run(room, setup, |_, _, _| {})?.report.coverage_m2)
        },
    );
    let plain = plain.expect("it drives");
    let mean = plain.iter().flatten().sum::<f64>() / 2.0;
    assert!((of(16) - mean).abs() < 1e-9);
    assert!((of(64) - mean).abs() > 1e-9 && of(64) > 1.0);
}
