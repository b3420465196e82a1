//! What is tried instead of a way that is closed, or was seen from one place only.

use super::*;

fn step_aside(shield: &Shield<16>, config: &Config<16>) -> Option<(Displacement, Allowed)> {
    shield.step_aside(config, Mask::ALL, mm(250, 0), Millis::from_ms(6))
}

#[test]
fn the_first_step_is_across_the_way_and_slow() {
    let config = Config::recommended();
    // Something stands on the left: to the right.
    let shield = heard(&config, &[(4, 400)]);
    let (way, allowed) = step_aside(&shield, &config).expect("the right side is free");
    assert_eq!(way, mm(0, -80));
    assert_eq!((allowed.distance_mm, allowed.speed_mm_s), (80, 254));
    // Both sides are closed.
    let shield = heard(&config, &[(4, 130), (12, 130)]);
    assert_eq!(step_aside(&shield, &config), None);
    // The way has been seen from a second place.
    let mut shield = heard(&config, &[]);
    shield.moved(mm(0, 80), Bearing::ZERO);
    assert_eq!(step_aside(&shield, &config), None);
}

#[test]
fn a_detour_is_tried_where_less_than_half_of_the_way_is_free() {
    let config = Config::recommended();
    let way = |ahead_mm| {
        let shield = heard(&config, &[(0, ahead_mm)]);
        let (way, allowed) = shield.detour(&config, Mask::ALL, mm(250, 0), Millis::from_ms(6), 0);
        (way, allowed.distance_mm)
    };
    // At 45° 225 mm are free, which would count for more.
    assert_eq!(way(287), (mm(250, 0), 149));
    assert_eq!(way(191), (mm(0, 250), 250));
}

/// Some millimeters are left of the way that was allowed: an order costs more than they are worth.
#[test]
fn a_motion_is_shortened_from_four_millimeters_on() {
    let config = Config::recommended();
    let shield = heard(&config, &[(0, 300)]);
    let shorten = |wanted_mm| {
        let shorter = shield.shorten(&config, mm(wanted_mm, 0));
        shorter.map(|allowed| allowed.distance_mm)
    };
    assert_eq!(shorten(165), None);
    assert_eq!(shorten(166), Some(162));
}
