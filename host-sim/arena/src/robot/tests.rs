use super::*;
use crate::world::Shape;
use core::f64::consts::FRAC_PI_2;

fn hall() -> World {
    let corners = [
        (-50.0, -50.0),
        (50.0, -50.0),
        (50.0, 50.0),
        (-50.0, 50.0),
        (-50.0, -50.0),
    ];
    let points = corners.map(|(x, y)| Point::new(x, y)).to_vec();
    World::new("hall", Pose::default(), vec![Shape::Wall { points }]).unwrap()
}

fn wall_at(x: f64) -> World {
    let points = vec![Point::new(x, -9.0), Point::new(x, 9.0)];
    World::new("wall", Pose::default(), vec![Shape::Wall { points }]).unwrap()
}

fn exact_limits() -> BaseLimits {
    BaseLimits {
        slip: 0.0,
        ..BaseLimits::default()
    }
}

fn base(turret: TurretMode) -> Base {
    Base::new(Pose::default(), exact_limits(), turret)
}

fn go(base: &mut Base, dx_m: f64, dy_m: f64) {
    base.command(
        BaseMotion {
            dx_m,
            dy_m,
            speed_m_s: 1.0,
        },
        &mut Noise::new(1),
    );
}

/// Runs to rest in steps of `dt` and checks the limits in every step.
fn run(base: &mut Base, world: &World, dt: f64) -> (f64, Executed) {
    let limits = exact_limits();
    let (mut time, mut sum) = (0.0, Executed::none());
    while base.is_moving() && time < 100.0 {
        let (speed, rate) = (base.speed, base.turn_rate);
        let done = base.advance(dt, world);
        assert!(base.speed.abs() <= limits.speed_m_s + 1e-12);
        assert!(base.turn_rate.abs() <= limits.turn_rate_rad_s + 1e-12);
        let stopped_hard = done.touched;
        assert!(stopped_hard || (base.speed - speed).abs() <= limits.acceleration_m_s2 * dt + 1e-9);
        assert!((base.turn_rate - rate).abs() <= limits.turn_acceleration_rad_s2 * dt + 1e-9);
        time += dt;
        sum.traveled_m += done.traveled_m;
        sum.touched |= done.touched;
        sum.bumpers |= done.bumpers;
        sum.min_clearance_m = sum.min_clearance_m.min(done.min_clearance_m);
    }
    (time, sum)
}

#[test]
fn an_exact_move_is_in_the_ring_frame() {
    let mut base = Base::new(
        Pose::new(Point::new(1.0, 2.0), FRAC_PI_2),
        exact_limits(),
        TurretMode::Held,
    );
    let done = base.move_exactly(&hall(), 0.2, 0.1);
    assert!(base.pose().position.distance(Point::new(0.9, 2.2)) < 1e-12);
    assert_eq!(base.odometry(), base.pose().position);
    assert_eq!(base.pose().heading, FRAC_PI_2);
    assert_eq!((done.touched, done.bumpers), (false, 0));
    assert!((done.traveled_m - 0.05f64.sqrt()).abs() < 1e-12);
    assert!((base.heading_in_ring() - libm::atan2(0.1, 0.2)).abs() < 1e-12);
}

#[test]
fn a_following_ring_points_in_the_direction_of_motion() {
    let mut base = base(TurretMode::Follow);
    base.move_exactly(&hall(), 0.0, -0.25);
    assert!((base.pose().heading + FRAC_PI_2).abs() < 1e-12);
    assert_eq!(base.heading_in_ring(), 0.0);
    // A displacement of zero turns nothing; the next move is straight ahead.
    let before = base.pose();
    base.move_exactly(&hall(), 0.0, 0.0);
    assert_eq!(base.pose(), before);
    base.move_exactly(&hall(), 0.25, 0.0);
    assert!(base.pose().position.distance(Point::new(0.0, -0.5)) < 1e-12);
}

#[test]
fn an_exact_move_ends_at_the_contact() {
    let mut base = base(TurretMode::Held);
    let done = base.move_exactly(&wall_at(0.4), 0.25, 0.0);
    let at_wall = base.pose().position;
    assert!(done.touched && (at_wall.x - (0.4 - COLLISION_RADIUS_M)).abs() < 1e-12);
    assert_eq!((done.bumpers, done.min_clearance_m), (1, 0.0));
    let done = base.move_exactly(&wall_at(0.4), 0.25, 0.0);
    assert!(done.touched && base.pose().position.distance(at_wall) < 1e-9);
    let done = base.move_exactly(&wall_at(0.4), -0.25, 0.25);
    let away = base.pose().position - at_wall;
    assert!(!done.touched && away.distance(Point::new(-0.25, 0.25)) < 1e-9);
}

#[test]
fn bumpers_are_counted_from_the_front_of_the_base_to_the_left() {
    // The base points along y; the wall is on its right: switch 15, 18° · 15 = 270°.
    let mut base = Base::new(
        Pose::new(Point::default(), FRAC_PI_2),
        exact_limits(),
        TurretMode::Follow,
    );
    let done = base.move_exactly(&wall_at(0.4), 0.0, -1.0);
    assert_eq!(done.bumpers, 1 << 15);
    // The ring turned with the wheels; base and bumpers did not turn.
    let done = base.move_exactly(&wall_at(0.4), 1.0, 0.0);
    assert_eq!(done.bumpers, 1 << 15);
}

#[test]
fn a_timed_move_ends_at_rest_at_the_commanded_place() {
    for turret in [TurretMode::Held, TurretMode::Follow] {
        for (dx, dy) in [
            (0.25, 0.0),
            (-0.25, 0.0),
            (0.1, 0.2),
            (-0.003, -0.2),
            (3.0, -1.0),
            (-1e-4, 1e-4),
        ] {
            for dt in [0.003, 0.01, 0.04] {
                let mut base = base(turret);
                go(&mut base, dx, dy);
                let (_, sum) = run(&mut base, &hall(), dt);
                assert!(
                    base.pose().position.distance(Point::new(dx, dy)) < 1e-8,
                    "{dx} {dy}"
                );
                assert_eq!((base.speed, base.turn_rate), (0.0, 0.0));
                assert!((sum.traveled_m - Point::new(dx, dy).length()).abs() < 1e-8);
                assert_eq!(base.odometry(), base.chassis.position);
                if turret == TurretMode::Held {
                    assert_eq!(base.pose().heading, 0.0);
                    assert!(
                        base.steering().abs() <= FRAC_PI_2 + 1e-9,
                        "{}",
                        base.steering()
                    );
                } else {
                    let off = wrap_angle(base.pose().heading - libm::atan2(dy, dx));
                    assert!(off.abs() < 1e-8);
                }
            }
        }
    }
}

/// 1 m straight ahead: accelerating to 0.508 m/s and braking take 0.508 / 0.762 s each, and 0.339 m
/// together.
#[test]
fn a_straight_meter_takes_the_expected_time() {
    let mut base = base(TurretMode::Held);
    go(&mut base, 1.0, 0.0);
    let (time, _) = run(&mut base, &hall(), 0.001);
    let ramp = 0.508 / 0.762;
    let expected = 2.0 * ramp + (1.0 - 0.508 * ramp) / 0.508;
    assert!((time - expected).abs() < 0.03, "{time} {expected}");
}

#[test]
fn zero_brakes_within_v_squared_over_2a() {
    let mut base = base(TurretMode::Held);
    go(&mut base, 5.0, 0.0);
    base.advance(2.0, &hall());
    let (speed, before) = (base.speed_m_s(), base.pose().position);
    assert_eq!(speed, 0.508);
    base.command(BaseMotion::default(), &mut Noise::new(1));
    let (time, sum) = run(&mut base, &hall(), 0.01);
    let way = base.pose().position.distance(before);
    assert!(
        (way - speed * speed / (2.0 * 0.762)).abs() < 1e-9 && (sum.traveled_m - way).abs() < 1e-12
    );
    assert!((time - speed / 0.762).abs() < 0.011);
}

/// Stopping the wheels takes up to 1.5 s; reported as rolling, they would seem to be blocked.
#[test]
fn wheels_that_still_turn_after_a_stop_are_reported_as_steering() {
    let mut base = base(TurretMode::Held);
    go(&mut base, 0.0, 0.5);
    base.advance(1.6, &hall());
    assert!(base.is_steering());
    go(&mut base, 0.0, 0.0);
    let mut rest_s = 0.0;
    while base.is_moving() {
        assert!(base.is_steering());
        base.advance(0.01, &hall());
        rest_s += 0.01;
    }
    assert!(!base.is_steering());
    assert!(rest_s > 0.6, "{rest_s}");
}

#[test]
fn the_base_stops_before_it_changes_direction() {
    let mut base = base(TurretMode::Held);
    go(&mut base, 2.0, 0.0);
    base.advance(1.5, &hall());
    let at = base.pose().position;
    go(&mut base, 0.0, 0.5);
    while base.speed_m_s() != 0.0 {
        assert_eq!(base.steering(), 0.0);
        base.advance(0.01, &hall());
    }
    run(&mut base, &hall(), 0.01);
    // The goal is relative to the position at the time of the command.
    assert!(base.pose().position.distance(at + Point::new(0.0, 0.5)) < 1e-8);
}

#[test]
fn a_stop_command_stops_turning_wheels() {
    let mut base = base(TurretMode::Follow);
    go(&mut base, 0.0, 1.0);
    base.advance(0.5, &hall());
    assert!(base.turn_rate > 0.2);
    base.command(BaseMotion::default(), &mut Noise::new(1));
    let turning = base.pose().heading;
    let (time, sum) = run(&mut base, &hall(), 0.01);
    assert_eq!((base.turn_rate, sum.traveled_m), (0.0, 0.0));
    assert!(time > 0.4 && base.pose().heading < FRAC_PI_2);
    assert!(base.pose().heading > turning);
    // A new command while the wheels turn the other way reaches its goal.
    go(&mut base, 0.0, -1.0);
    base.advance(0.3, &hall());
    let at = base.pose();
    go(&mut base, 0.3, 0.0);
    run(&mut base, &hall(), 0.01);
    let goal = at.position + Point::unit(at.heading) * 0.3;
    assert!(base.pose().position.distance(goal) < 1e-8);
}

/// A half turn of the Nomad's wheels takes 5.5 s: 4 s at 45 °/s, and 1.5 s to accelerate and brake.
#[test]
fn wheels_that_turn_keep_turning_when_the_motion_is_shortened() {
    let mut base = base(TurretMode::Follow);
    let goal = Point::new(-1.0, 0.0);
    go(&mut base, goal.x, goal.y);
    for tenth in 1_u32..=9 {
        base.advance(0.4, &hall());
        assert!(base.is_steering() && base.speed_m_s() == 0.0);
        let left = goal * (1.0 - 0.05 * f64::from(tenth));
        let shorter = left.turned_back(Point::unit(base.pose().heading));
        go(&mut base, shorter.x, shorter.y);
    }
    let mut steering_s = 3.6;
    while base.is_steering() {
        base.advance(0.01, &hall());
        steering_s += 0.01;
    }
    assert!((5.45..5.6).contains(&steering_s), "{steering_s}");
    run(&mut base, &hall(), 0.01);
    assert!(base.odometry().distance(goal * 0.55) < 1e-8);
}

#[test]
fn a_longer_or_shorter_motion_ahead_does_not_stop_the_base() {
    let mut base = base(TurretMode::Held);
    go(&mut base, 1.0, 0.0);
    base.advance(1.0, &hall());
    let at = base.pose().position;
    go(&mut base, 1.5, 0.0);
    let done = base.advance(0.1, &hall());
    assert!(
        (done.traveled_m - 0.0508).abs() < 1e-9,
        "no braking in between"
    );
    run(&mut base, &hall(), 0.01);
    assert!(base.pose().position.distance(at + Point::new(1.5, 0.0)) < 1e-8);
    // Shorter than the braking distance of 0.508² / (2 · 0.762) m: the base brakes at once.
    go(&mut base, 1.0, 0.0);
    base.advance(1.0, &hall());
    let at = base.pose().position;
    go(&mut base, 0.05, 0.0);
    run(&mut base, &hall(), 0.01);
    let end = base.pose().position;
    assert!(end.distance(at + Point::new(0.169, 0.0)) < 0.01, "{end:?}");
}

#[test]
fn a_contact_ends_a_timed_move() {
    let mut base = base(TurretMode::Held);
    go(&mut base, 1.0, 0.0);
    let (_, sum) = run(&mut base, &wall_at(0.6), 0.01);
    assert!(sum.touched && sum.bumpers == 1 && sum.min_clearance_m == 0.0);
    assert!((base.pose().position.x - (0.6 - COLLISION_RADIUS_M)).abs() < 1e-9);
    assert!(!base.is_moving() && base.speed_m_s() == 0.0);
    // The base can move away.
    go(&mut base, -0.2, 0.0);
    assert!(!run(&mut base, &wall_at(0.6), 0.01).1.touched);
}

#[test]
fn slip_changes_the_true_position_and_not_the_odometry() {
    let mut noise = Noise::new(9);
    let (mut squares_along, mut squares_across, runs) = (0.0, 0.0, 400);
    for _ in 0..runs {
        let mut base = Base::new(Pose::default(), BaseLimits::default(), TurretMode::Held);
        base.command(
            BaseMotion {
                dx_m: 1.0,
                dy_m: 0.0,
                speed_m_s: 1.0,
            },
            &mut noise,
        );
        base.advance(10.0, &hall());
        let (odometry, truth) = (base.odometry(), base.pose().position);
        assert!((odometry.x - 1.0).abs() < 1e-8 && odometry.y == 0.0);
        squares_along += (truth.x - 1.0).powi(2);
        squares_across += truth.y.powi(2);
    }
    // Four standard errors of a standard deviation from 400 runs are 14 %.
    for squares in [squares_along, squares_across] {
        let deviation = (squares / f64::from(runs)).sqrt();
        assert!((deviation / 0.02 - 1.0).abs() < 0.14, "{deviation}");
    }
}

#[test]
fn invalid_commands_brake() {
    for (dx_m, speed_m_s) in [
        (f64::NAN, 1.0),
        (f64::INFINITY, 1.0),
        (1.0, 0.0),
        (1.0, -1.0),
        (1.0, f64::NAN),
    ] {
        let mut base = base(TurretMode::Held);
        base.command(
            BaseMotion {
                dx_m,
                dy_m: 0.0,
                speed_m_s,
            },
            &mut Noise::new(1),
        );
        base.advance(1.0, &hall());
        assert!(!base.is_moving() && base.pose() == Pose::default());
    }
}

#[test]
fn splitting_the_time_does_not_change_the_result() {
    let mut whole = base(TurretMode::Follow);
    let mut split = whole.clone();
    go(&mut whole, 0.3, 0.4);
    go(&mut split, 0.3, 0.4);
    whole.advance(2.0, &hall());
    for _ in 0..50 {
        split.advance(0.04, &hall());
    }
    assert!(whole.pose().position.distance(split.pose().position) < 1e-9);
    assert!(
        "folow"
            .parse::<TurretMode>()
            .unwrap_err()
            .to_string()
            .contains("did you mean \"follow\"?")
    );
}

/// 40 ms at once and in four steps give the same bits, except for gaps above the reported limit.
#[test]
fn strides_equal_their_steps() {
    let mut noise = Noise::new(5);
    let world = World::random(3);
    let (mut strides, mut touches) = (0, 0);
    for turret in [TurretMode::Held, TurretMode::Follow] {
        // A heading of more than half a turn is not wrapped.
        let start = Pose::new(world.start().position, 4.0);
        let mut whole = Base::new(start, BaseLimits::default(), turret);
        let mut least = f64::INFINITY;
        let mut split = whole.clone();
        for turn in 0..60_000 {
            if noise.uniform_in(0.0, 60.0) < 1.0 {
                let motion = random_motion(&mut noise);
                whole.command(motion, &mut Noise::new(turn));
                split.command(motion, &mut Noise::new(turn));
            }
            whole.limit_reported_gaps(least);
            let before = whole.clone();
            strides += u32::from(whole.stride(0.01, &world, &mut Executed::none()));
            whole = before;
            let done = whole.advance(0.04, &world);
            let steps = step_by_step(&mut split, &world);
            assert_eq!(bits(&whole), bits(&split), "{turret:?} {turn}");
            let gap_m = steps.min_clearance_m.min(least);
            assert_eq!(done.min_clearance_m.min(least), gap_m, "{turret:?} {turn}");
            let min_clearance_m = done.min_clearance_m;
            assert_eq!(
                done,
                Executed {
                    min_clearance_m,
                    ..steps
                }
            );
            least = gap_m.max(0.05);
            touches += u32::from(done.touched);
        }
    }
    assert!(strides > 40_000 && touches > 50, "{strides} {touches}");
}

/// A random motion.
fn random_motion(noise: &mut Noise) -> BaseMotion {
    let mut distance = || noise.uniform_in(-1.0, 1.0).powi(3);
    BaseMotion {
        dx_m: distance(),
        dy_m: distance(),
        speed_m_s: noise.uniform_in(0.001, 0.7),
    }
}

fn step_by_step(base: &mut Base, world: &World) -> Executed {
    let mut done = Executed::none();
    for _ in 0..STEPS_PER_STRIDE {
        base.step(0.01, world, &mut done);
    }
    base.chassis.report_gap(world, &mut done);
    done.moving = base.is_moving();
    done
}

fn bits(base: &Base) -> [u64; 8] {
    let (position, odometry) = (base.chassis.position, base.odometry());
    let steering = [base.steering(), base.turn_rate, base.ring.angle()];
    let rolling = [position.x, position.y, odometry.x, odometry.y, base.speed];
    let mut all = rolling.into_iter().chain(steering).map(f64::to_bits);
    core::array::from_fn(|_| all.next().unwrap())
}
