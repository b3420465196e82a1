//! The campaigns with a thousandth of their counts.

use amp::config::Config;
use arena::sonar::SonarModel;
use tests::campaign::{CampaignVerdict, clock, drift, frames, link, shield, silence};

const QUIETLY: &(dyn Fn(u64) + Sync) = &|_| {};

fn all_is_well(verdict: &CampaignVerdict) {
    println!("{}", verdict.text);
    assert_eq!(verdict.broken, [""; 0]);
}

#[test]
fn damaged_frames_are_not_messages() {
    all_is_well(&frames::run(1, frames::COUNT / 1_000, QUIETLY));
}

#[test]
fn nothing_stale_is_done_over_a_bad_line() {
    all_is_well(&link::run(1, link::COUNT / 1_000, QUIETLY));
}

#[test]
fn whatever_is_gone_the_base_stands_in_time() {
    all_is_well(&silence::run(1, silence::COUNT / 1_000, QUIETLY));
}

#[test]
fn the_clocks_end_changes_nothing() {
    let verdict = clock::run(1, 9, QUIETLY).expect("minds that decide");
    all_is_well(&verdict);
}

#[test]
fn a_robot_stays_as_it_is() {
    let verdict = drift::run(1, 2, 1, SonarModel::Ideal, QUIETLY).expect("minds that decide");
    all_is_well(&verdict);
}

/// Five robots that would stand still within three hours if each map update were too large.
#[test]
fn a_robot_goes_on() {
    let verdict = drift::run(9, 5, 3, SonarModel::Nomad, QUIETLY).expect("minds that decide");
    let stands = |what: &&String| what.contains("stands");
    assert_eq!(verdict.broken.iter().find(stands), None);
}

/// Two rooms and two other worlds per cell.
#[test]
fn with_the_shield_the_robot_touches_nothing() {
    let config = Config::recommended();
    for worlds in [shield::Worlds::Random, shield::Worlds::Others] {
        let verdict = shield::run(1, 2 * shield::CELLS, worlds, &config, QUIETLY);
        all_is_well(&verdict.expect("controllers that decide"));
    }
}

/// The campaign detects the contacts of a robot without the shield.
#[test]
fn without_the_shield_the_robot_touches_something() {
    let mut config = Config::recommended();
    config.shield = None;
    let verdict = shield::run(
        1,
        2 * shield::CELLS,
        shield::Worlds::Random,
        &config,
        QUIETLY,
    );
    assert!(!verdict.expect("controllers that decide").broken.is_empty());
}

/// Figures do not depend on the number of threads.
#[test]
fn a_seed_is_a_campaign() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        pool.install(|| frames::run(7, 250_000, QUIETLY))
    };
    let one = on(1);
    assert_eq!(one, on(3));
    assert_ne!(one, frames::run(8, 250_000, QUIETLY));
}
