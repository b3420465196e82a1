use super::*;
use crate::world::Shape;
use core::f64::consts::{FRAC_PI_2, PI, TAU};

fn wall(x: f64) -> World {
    let points = vec![Point::new(x, -50.0), Point::new(x, 50.0)];
    World::new("wall", Pose::default(), vec![Shape::Wall { points }]).unwrap()
}

fn axes() -> Axes {
    let limits = BaseLimits {
        slip: 0.0,
        ..BaseLimits::default()
    };
    Axes::new(Pose::default(), &limits)
}

fn run(axes: &mut Axes, seconds: f64, world: &World) -> Point {
    let mut counted = Point::default();
    for _ in 0..(seconds * 1e3) as u32 {
        counted = counted + axes.advance(1e-3, world).1;
    }
    counted
}

#[test]
fn a_velocity_is_reached_with_the_acceleration_and_held() {
    let (mut axes, world, mut noise) = (axes(), wall(90.0), Noise::new(1));
    axes.run(Axis::Translation, 0.4, &mut noise);
    run(&mut axes, 0.25, &world);
    assert!((axes.rate(Axis::Translation) - 0.25 * 0.762).abs() < 1e-9);
    run(&mut axes, 1.0, &world);
    assert!((axes.rate(Axis::Translation) - 0.4).abs() < 1e-9);
    // Velocities above the limit are clamped.
    axes.run(Axis::Translation, 9.0, &mut noise);
    run(&mut axes, 2.0, &world);
    assert!((axes.rate(Axis::Translation) - 0.508).abs() < 1e-9);
    axes.hold(Axis::Translation);
    run(&mut axes, 0.508 / 0.762 - 0.01, &world);
    assert!(axes.is_active(Axis::Translation));
    run(&mut axes, 0.02, &world);
    assert!(!axes.is_active(Axis::Translation));
}

/// At velocity v and turn rate ω the base drives a circle of radius v/ω back to its start.
#[test]
fn rolling_and_steering_together_is_a_circle() {
    let (mut axes, world, mut noise) = (axes(), wall(90.0), Noise::new(1));
    axes.run(Axis::Translation, 0.2, &mut noise);
    axes.run(Axis::Steering, 0.5, &mut noise);
    run(&mut axes, 2.0, &world);
    let (from, steering) = (axes.pose(), axes.at(Axis::Steering));
    let mut far: f64 = 0.0;
    let turn_ms = (TAU / 0.5 * 1e3) as u32;
    for _ in 0..turn_ms {
        axes.advance(1e-3, &world);
        far = far.max(axes.pose().position.distance(from.position));
    }
    assert!((axes.at(Axis::Steering) - steering - TAU).abs() < 1e-3);
    assert!(axes.pose().position.distance(from.position) < 1e-3);
    assert!((far - 2.0 * 0.2 / 0.5).abs() < 1e-3, "{far}");
    // The turret keeps its bearing.
    assert_eq!(axes.pose().heading, 0.0);
}

#[test]
fn all_axes_move_simultaneously_to_their_goals() {
    let (mut axes, world, mut noise) = (axes(), wall(90.0), Noise::new(1));
    axes.go_to(Axis::Translation, 0.5, &mut noise);
    axes.go_to(Axis::Steering, FRAC_PI_2, &mut noise);
    axes.go_to(Axis::Turret, -1.0, &mut noise);
    let counted = run(&mut axes, 4.0, &world);
    for (axis, goal) in Axis::ALL.into_iter().zip([0.5, FRAC_PI_2, -1.0]) {
        assert!((axes.at(axis) - goal).abs() < 1e-8, "{axis:?}");
        assert!(!axes.is_active(axis));
    }
    assert!((axes.pose().heading + 1.0).abs() < 1e-8);
    // Without slip odometry equals the true displacement.
    assert!(counted.distance(axes.pose().position) < 1e-9);
    assert!(counted.x > 0.1 && counted.y > 0.1);
}

#[test]
fn a_wall_stops_the_wheels_and_presses_a_switch_until_the_base_rolls_away() {
    let (mut axes, world, mut noise) = (axes(), wall(0.5), Noise::new(1));
    axes.go_to(Axis::Translation, 1.0, &mut noise);
    run(&mut axes, 3.0, &world);
    assert!((axes.at(Axis::Translation) - (0.5 - 0.269)).abs() < 1e-6);
    assert!(!axes.is_active(Axis::Translation));
    assert_eq!(axes.bumpers(), 1);
    // Steering does not release the switch.
    axes.go_to(Axis::Steering, PI / 2.0, &mut noise);
    run(&mut axes, 3.0, &world);
    assert_eq!(axes.bumpers(), 1);
    axes.go_to(Axis::Steering, 0.0, &mut noise);
    run(&mut axes, 3.0, &world);
    axes.go_to(Axis::Translation, 0.1, &mut noise);
    run(&mut axes, 1.0, &world);
    assert_eq!(axes.bumpers(), 0);
}

#[test]
fn speeds_and_accelerations_stay_within_the_limits() {
    let (mut axes, world, mut noise) = (axes(), wall(90.0), Noise::new(1));
    axes.set_speed(Axis::Steering, 99.0);
    axes.set_acceleration(Axis::Steering, 99.0);
    let limits = AxisLimits::of(&BaseLimits::default())[1];
    assert_eq!(axes.set(Axis::Steering), limits);
    axes.set_acceleration(Axis::Steering, 0.0);
    assert_eq!(axes.set(Axis::Steering), limits);
    // A move at speed 0 does nothing.
    axes.set_speed(Axis::Steering, 0.0);
    axes.go_to(Axis::Steering, 1.0, &mut noise);
    assert!(!axes.is_active(Axis::Steering));
    run(&mut axes, 0.1, &world);
    assert_eq!(axes.at(Axis::Steering), 0.0);
}

#[test]
fn slip_is_drawn_when_the_wheels_begin_to_roll() {
    let (world, mut noise) = (wall(90.0), Noise::new(3));
    let mut axes = Axes::new(Pose::default(), &BaseLimits::default());
    axes.run(Axis::Translation, 0.3, &mut noise);
    let after_first = noise.clone();
    run(&mut axes, 1.0, &world);
    // Repeating the command while the base rolls draws nothing.
    axes.run(Axis::Translation, 0.3, &mut noise);
    assert_eq!(noise, after_first);
    let counted = run(&mut axes, 1.0, &world);
    assert!(counted.y == 0.0 && axes.pose().position.y != 0.0);
}
