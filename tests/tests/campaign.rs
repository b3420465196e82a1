//! The campaigns with a thousandth of their counts.

use host_sim::sonar::SonarModel;
use tests::campaign::{Verdict, clock, drift, frames, link, silence};

const QUIETLY: &(dyn Fn(u64) + Sync) = &|_| {};

fn all_is_well(verdict: &Verdict) {
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

/// The same figures on any number of threads.
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
