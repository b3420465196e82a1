//! The robot learns from 100 random moves and then drives without contact.

use arena::sonar::SonarModel;
use experiments::ablation::{AblationFigures, AblationTrial, measure, variants};

const IDEAL: AblationTrial = AblationTrial {
    first: 1,
    rooms: 100,
    explore_moves: 100,
    steps: 1_000,
    seed: 1,
    neurons: 16,
    sonar: SonarModel::Ideal,
};

fn figures(row: &str, trial: &AblationTrial) -> AblationFigures {
    let rows = variants().expect("the rows of the table");
    let variant = rows.iter().find(|variant| variant.name == row);
    let figures = measure(variant.expect(row), trial).expect("every episode runs");
    println!("{row}: {figures:?}");
    figures
}

#[test]
fn the_shield_keeps_the_robot_from_every_contact() {
    let shielded = figures("default, shield on", &IDEAL);
    assert_eq!(shielded.contacts, 0.0);
    assert_eq!((shielded.clean, shielded.clean_exploring), (100, 100));
    assert!(shielded.distance_m >= 60.0, "{shielded:?}");
}

#[test]
fn the_maps_alone_avoid_obstacles_and_get_around() {
    let maps = figures("default", &IDEAL);
    let reference = figures("Braitenberg (reference)", &IDEAL);
    assert!(maps.clean >= 98, "{maps:?}");
    assert!(maps.distance_m >= 60.0, "{maps:?}");
    assert!(
        maps.distance_m >= 0.9 * reference.distance_m,
        "{maps:?} {reference:?}"
    );
    assert!(
        maps.coverage_m2 >= 0.75 * reference.coverage_m2,
        "{maps:?} {reference:?}"
    );
}

#[test]
fn a_real_ring_of_sonars_is_enough_for_the_shield() {
    let nomad = AblationTrial {
        rooms: 20,
        steps: 300,
        sonar: SonarModel::Nomad,
        ..IDEAL
    };
    let shielded = figures("default, shield on", &nomad);
    assert_eq!(shielded.contacts, 0.0);
    assert_eq!((shielded.clean, shielded.clean_exploring), (20, 20));
    assert!(shielded.distance_m >= 20.0, "{shielded:?}");
}
