use super::disturbance::noisy_inches;
use super::*;
use crate::world::Shape;
use core::f64::consts::PI;

fn world(shapes: Vec<Shape>) -> World {
    // A start far away is always legal; the tests place the robot elsewhere.
    let start = Pose::new(Point::new(500.0, 0.0), 0.0);
    World::new("test", start, shapes).unwrap()
}

fn wall(points: &[(f64, f64)]) -> Shape {
    Shape::Wall {
        points: points.iter().map(|&(x, y)| Point::new(x, y)).collect(),
    }
}

fn post(x: f64, y: f64, radius: f64) -> Shape {
    Shape::Circle {
        center: Point::new(x, y),
        radius,
    }
}

/// A wall at 2 m whose normal is `degrees` from the axis of sonar 0; it extends `half` m to either
/// side.
fn oblique(degrees: f64, half: f64) -> Shape {
    let along = Point::unit((90.0 + degrees) * PI / 180.0);
    let (a, b) = (along * -half, along * half);
    wall(&[(2.0 + a.x, a.y), (2.0 + b.x, b.y)])
}

/// Parameters of a model without randomness.
fn deterministic(model: SonarModel) -> SonarConfig {
    SonarConfig {
        sigma_m: 0.0,
        sigma_share: 0.0,
        missed: 0.0,
        random: 0.0,
        crosstalk: 0.0,
        one_dead: false,
        ..model.config()
    }
}

fn ring(model: SonarModel, config: SonarConfig) -> Ring {
    Ring::with_config(model, RingGeometry::default(), config, &mut Noise::new(1))
}

/// Reading of sonar 0 at the origin, in.
fn ping(world: &World, config: SonarConfig) -> u8 {
    let mut ring = ring(SonarModel::Harsh, config);
    reading_in(ring.ping(world, &Pose::default(), 0, 0.0, &mut Noise::new(2)))
}

/// Whole inches from the face of sonar 0 to something `distance` m from the center.
fn inches(distance: f64) -> u8 {
    reading_in(Some(distance - 0.2305))
}

#[test]
fn sonar_four_is_on_the_left_and_the_front_fires_first() {
    let geometry = RingGeometry::default();
    assert!((geometry.bearing(4) - PI / 2.0).abs() < 1e-15);
    let mut order = geometry.firing_order();
    assert_eq!(order, FIRING_ORDER);
    order.sort_unstable();
    assert!(order.iter().copied().eq(0..16));
    assert!((FIRING_SLOT_S * 16.0 - RING_PERIOD_S).abs() < 1e-12);
    // An echo from 255 in is back before the next firing.
    let way_m = 2.0 * f64::from(MAX_READING_IN) * M_PER_INCH;
    assert!(way_m / SOUND_M_S < FIRING_SLOT_S);
    let eight = RingGeometry {
        count: 8,
        ..geometry
    };
    assert_eq!(eight.firing_order(), [0, 1, 7, 2, 6, 3, 5, 4]);
}

#[test]
fn a_scan_is_exact_and_ends_at_255_inches() {
    let world = world(vec![
        wall(&[(0.0, 1.0), (0.5, 1.0)]),
        wall(&[(0.0, -6.7), (0.5, -6.7)]),
        wall(&[(-6.8, 0.0), (-6.8, 9.0)]),
    ]);
    let mut ring = Ring::new(SonarModel::Ideal, &mut Noise::new(1));
    let mut out = [None; 16];
    ring.scan(&world, &Pose::default(), &mut out);
    assert!((out[4].unwrap() - (1.0 - 0.2305)).abs() < 1e-6);
    assert!((out[12].unwrap() - (6.7 - 0.2305)).abs() < 1e-5);
    assert_eq!((out[8], out[0]), (None, None));
    // A turned turret turns the readings, and one ping is the scan's.
    let pose = Pose::new(Point::default(), -PI / 2.0);
    ring.scan(&world, &pose, &mut out);
    assert!((out[8].unwrap() - (1.0 - 0.2305)).abs() < 1e-6);
    for (sensor, range) in out.iter().enumerate() {
        assert_eq!(
            ring.ping(&world, &pose, sensor, 0.0, &mut Noise::new(1)),
            *range
        );
    }
    assert_eq!(ring.ping(&world, &pose, 16, 0.0, &mut Noise::new(1)), None);
}

#[test]
fn a_wall_returns_an_echo_only_near_its_normal() {
    let config = deterministic(SonarModel::Nomad);
    assert_eq!(ping(&world(vec![oblique(0.0, 5.0)]), config), inches(2.0));
    // The wall's normal 30° off the axis: the lobe's edge meets it at 15°, the foot is outside.
    let degrees = |d: f64| d * PI / 180.0;
    let expected = (2.0 - 0.2305) * libm::cos(degrees(30.0)) / libm::cos(degrees(15.0));
    assert_eq!(
        ping(&world(vec![oblique(30.0, 8.0)]), config),
        reading_in(Some(expected))
    );
    // At 39° the lobe's edge hits it at 24°; at 41° there is no echo.
    assert!(ping(&world(vec![oblique(39.0, 8.0)]), config) < MAX_READING_IN);
    assert_eq!(
        ping(&world(vec![oblique(41.0, 8.0)]), config),
        MAX_READING_IN
    );
    assert_eq!(
        ping(&world(vec![oblique(-41.0, 8.0)]), config),
        MAX_READING_IN
    );
    // With a larger maximum incidence there is an echo.
    assert!(
        ping(
            &world(vec![oblique(41.0, 8.0)]),
            SonarConfig {
                max_incidence_rad: 1.5,
                ..config
            }
        ) < 100
    );
}

#[test]
fn corners_edges_and_posts_return_an_echo_at_any_angle() {
    let config = deterministic(SonarModel::Nomad);
    // The free end of a wall seen under 60°.
    let end = world(vec![wall(&[(2.0, 0.1), (4.0, 3.5641)])]);
    assert_eq!(
        ping(&end, config),
        reading_in(Some(Point::new(2.0 - 0.2305, 0.1).length()))
    );
    // A box seen at its edge: both faces are at 45°, the edge between them returns the echo.
    let turned = Shape::Box {
        center: Point::new(3.0, 0.0),
        size: Point::new(1.0, 1.0),
        angle: PI / 4.0,
    };
    assert_eq!(
        ping(&world(vec![turned]), config),
        inches(3.0 - 0.5f64.sqrt())
    );
    assert_eq!(
        ping(&world(vec![post(3.0, 0.4, 0.02)]), config),
        reading_in(Some(Point::new(3.0 - 0.2305, 0.4).length() - 0.02))
    );
    // Outside the lobe of ±15° there is no echo.
    assert_eq!(
        ping(&world(vec![post(3.0, 0.9, 0.02)]), config),
        MAX_READING_IN
    );
}

#[test]
fn hidden_surfaces_return_no_echo() {
    let config = deterministic(SonarModel::Nomad);
    // A wall too oblique for an echo hides the post and the wall behind it.
    let screen = oblique(60.0, 4.0);
    let behind = [post(5.0, 0.0, 0.05), wall(&[(6.0, -3.0), (6.0, 3.0)])];
    let mut shapes = behind.to_vec();
    assert_eq!(ping(&world(shapes.clone()), config), inches(4.95));
    shapes.push(screen);
    assert_eq!(ping(&world(shapes), config), MAX_READING_IN);
    // It also hides the end of a wall.
    let end = wall(&[(5.0, 0.0), (8.0, 8.0)]);
    assert_eq!(ping(&world(vec![end.clone()]), config), inches(5.0));
    assert_eq!(
        ping(&world(vec![end, oblique(60.0, 4.0)]), config),
        MAX_READING_IN
    );
    // A post behind a nearer wall returns no echo, even if the wall's echo is blanked.
    let near = [wall(&[(0.5, -3.0), (0.5, 3.0)]), post(2.0, 0.0, 0.05)];
    assert_eq!(ping(&world(near.to_vec()), config), inches(0.5));
    assert_eq!(
        ping(&world(near.to_vec()), deterministic(SonarModel::Harsh)),
        MAX_READING_IN
    );
}

#[test]
fn readings_are_whole_inches_with_the_expected_noise() {
    let world = world(vec![wall(&[(4.2305, -3.0), (4.2305, 3.0)])]);
    let mut noise = Noise::new(3);
    let mut ring = Ring::new(SonarModel::Nomad, &mut noise);
    let pings = 20_000;
    let (mut missed, mut random, mut sum, mut squares, mut near) = (0, 0, 0.0, 0.0, 0.0);
    for _ in 0..pings {
        let Some(range) = ring.ping(&world, &Pose::default(), 0, 0.0, &mut noise) else {
            missed += 1;
            continue;
        };
        let inches = range / M_PER_INCH;
        let whole = libm::rint(inches);
        assert!((inches - whole).abs() < 1e-9 && (6.0..255.0).contains(&whole));
        let error = range - 4.0;
        if error.abs() > 0.25 {
            random += 1;
        } else {
            sum += error;
            squares += error * error;
            near += 1.0;
        }
    }
    // Four standard deviations of the counts around 1 % and around 0.5 % of the rest.
    assert!((143..=257).contains(&missed), "{missed}");
    assert!((54..=136).contains(&random), "{random}");
    let (mean, deviation) = (sum / near, (squares / near).sqrt());
    // 1 % of 4 m, plus the rounding's 25.4 mm / √12.
    let expected = (0.04f64.powi(2) + M_PER_INCH.powi(2) / 12.0).sqrt();
    assert!(
        mean.abs() < 0.002 && (deviation / expected - 1.0).abs() < 0.03,
        "{mean} {deviation}"
    );
}

#[test]
fn nearer_than_six_inches_reads_six() {
    let near = world(vec![wall(&[(0.29, -3.0), (0.29, 3.0)])]);
    assert_eq!(ping(&near, deterministic(SonarModel::Nomad)), 6);
}

#[test]
fn a_blanked_echo_is_replaced_by_the_next_one() {
    let config = deterministic(SonarModel::Harsh);
    let far = wall(&[(3.0, -3.0), (3.0, 3.0)]);
    let at = |x: f64| world(vec![post(x, 0.0, 0.02), far.clone()]);
    assert_eq!(
        ping(&at(0.2305 + 0.02 + 0.44), config),
        reading_in(Some(0.44))
    );
    assert_eq!(ping(&at(0.2305 + 0.02 + 0.42), config), inches(3.0));
    assert_eq!(
        ping(&at(0.2305 + 0.02 + 0.42), deterministic(SonarModel::Nomad)),
        reading_in(Some(0.42))
    );
}

#[test]
fn an_oblique_face_reflects_the_beam() {
    // A face at 45°, wider than the lobe, reflects the beam of sonar 0 to a wall 3 m on the right.
    let world = world(vec![oblique(45.0, 1.2), wall(&[(-1.0, -3.0), (5.0, -3.0)])]);
    assert_eq!(
        ping(&world, deterministic(SonarModel::Nomad)),
        MAX_READING_IN
    );
    let way = 2.0 - 0.2305 + 3.0;
    assert_eq!(
        ping(&world, deterministic(SonarModel::Harsh)),
        reading_in(Some(way))
    );
}

#[test]
fn reverberation_gives_short_readings_only_after_an_echo() {
    let config = SonarConfig {
        crosstalk: 1.0,
        ..deterministic(SonarModel::Harsh)
    };
    let world = world(vec![wall(&[(2.2305, -3.0), (2.2305, 3.0)])]);
    let mut noise = Noise::new(1);
    let mut ring = ring(SonarModel::Harsh, config);
    let pose = Pose::default();
    assert_eq!(
        reading_in(ring.ping(&world, &pose, 8, 0.0, &mut noise)),
        MAX_READING_IN
    );
    let first = ring.ping(&world, &pose, 0, 0.04, &mut noise);
    assert_eq!(
        first.map(|r| reading_in(Some(r))),
        Some(reading_in(Some(2.0)))
    );
    // Four times over 2 m is 8 m; in 40 ms sound travels 6.864 m of it.
    let false_echo = ring.ping(&world, &pose, 8, 0.08, &mut noise);
    assert_eq!(
        reading_in(false_echo),
        reading_in(Some(8.0 - 0.02 * SOUND_M_S))
    );
    // Much later there is no reverberation.
    assert_eq!(ring.ping(&world, &pose, 8, 0.80, &mut noise), None);
}

#[test]
fn the_seed_selects_the_dead_transducer_of_a_harsh_ring() {
    let world = world(vec![
        post(0.0, 0.0, 0.01),
        wall(&[
            (-2.0, -2.0),
            (2.0, -2.0),
            (2.0, 2.0),
            (-2.0, 2.0),
            (-2.0, -2.0),
        ]),
    ]);
    let mut dead = [false; 16];
    for seed in 0..100 {
        let mut noise = Noise::new(seed);
        let mut ring = Ring::new(SonarModel::Harsh, &mut noise);
        let index = ring.dead().unwrap();
        dead[index] = true;
        for _ in 0..5 {
            assert_eq!(
                ring.ping(&world, &Pose::default(), index, 0.0, &mut noise),
                None
            );
        }
        assert_eq!(Ring::new(SonarModel::Nomad, &mut noise).dead(), None);
    }
    assert!(dead.iter().filter(|&&d| d).count() > 12);
}

#[test]
fn models_parse_from_their_names() {
    for name in SonarModel::NAMES {
        assert_eq!(name.parse::<SonarModel>().unwrap().name(), name);
    }
    let error = "nomda".parse::<SonarModel>().unwrap_err().to_string();
    assert!(error.contains("did you mean \"nomad\"?"), "{error}");
}

#[test]
fn the_byte_on_the_wire() {
    assert_eq!(reading_in(None), 255);
    assert_eq!(reading_in(Some(17.0 * M_PER_INCH)), 17);
    assert_eq!(reading_in(Some(100.0)), 255);
    assert_eq!(reading_in(Some(-1.0)), 0);
}

/// Compares an FNV-1a hash of many readings: they must not depend on the machine.
#[test]
fn readings_have_the_same_bits_everywhere() {
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    let mut add = |range: Option<f64>| {
        for byte in range.unwrap_or(-1.0).to_bits().to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    };
    for seed in 0..20 {
        let world = World::random(seed);
        let mut noise = Noise::new(seed);
        let pose = Pose::new(Point::new(0.1, -0.2), 0.1 * seed as f64);
        let mut out = [None; 16];
        Ring::new(SonarModel::Ideal, &mut noise).scan(&world, &pose, &mut out);
        out.into_iter().for_each(&mut add);
        for model in [SonarModel::Nomad, SonarModel::Harsh] {
            let mut ring = Ring::new(model, &mut noise);
            for (slot, sensor) in FIRING_ORDER.into_iter().enumerate() {
                let time_s = FIRING_SLOT_S * slot as f64;
                add(ring.ping(&world, &pose, sensor, time_s, &mut noise));
            }
        }
    }
    assert_eq!(hash, 0x547b_8f0b_e8d7_0bb4);
}

#[test]
fn readings_equal_those_with_exact_noise() {
    let (mut noise, mut exact_needed) = (Noise::new(3), 0);
    for _ in 0..100_000 {
        let sigma = noise.uniform_in(0.0, 0.1);
        let deviate = noise.normal_deviate();
        // Half of the ranges are next to a rounding limit.
        let limit = noise.uniform_in(0.0, 255.0).floor() + 0.5 + noise.uniform_in(-1e-6, 1e-6);
        let range = if noise.chance(0.5) {
            limit * M_PER_INCH - deviate.exact() * sigma
        } else {
            noise.uniform_in(0.0, 6.5)
        };
        let exact = libm::rint((range + deviate.exact() * sigma) / M_PER_INCH);
        assert_eq!(noisy_inches(range, sigma, deviate), exact);
        let approximate = (range + deviate.approximate() * sigma) / M_PER_INCH;
        exact_needed += u32::from(libm::rint(approximate) != exact);
    }
    // The approximation alone would give other readings.
    assert!(exact_needed > 1_000, "{exact_needed}");
    let deviate = noise.normal_deviate();
    assert!(noisy_inches(f64::NAN, 0.1, deviate).is_nan());
    assert_eq!(noisy_inches(f64::INFINITY, 0.1, deviate), f64::INFINITY);
}

/// Readings of one sensor of each kind 50 mm in front of a wall that it meets at `degrees`, mm.
fn by_kind(kind: SensorKind, degrees: f64) -> Vec<Option<f64>> {
    let mount = SensorMount {
        bearing_rad: 0.0,
        position: Point::default(),
        kind,
    };
    let config = SonarConfig {
        max_range_m: 0.07,
        min_range_m: 0.0,
        ..SonarConfig::nomad()
    };
    let mut noise = Noise::new(1);
    let mut ring = Ring::with_mounts(SonarModel::Nomad, &[mount], config, &mut noise);
    let world = world(vec![oblique(degrees, 1.0)]);
    // The surface within the lobe nearest to the sensor is 50 mm away.
    let nearest = libm::cos((degrees.abs() - 15.0).max(0.0) * PI / 180.0);
    let x = 2.0 - 0.05 * nearest / libm::cos(degrees * PI / 180.0);
    let pose = Pose::new(Point::new(x, 0.0), 0.0);
    let readings = (0..2_000).map(|_| ring.ping(&world, &pose, 0, 0.0, &mut noise));
    readings.map(|m| m.map(|m| m * 1e3)).collect()
}

/// A smooth wall is a mirror for sound, not for light.
#[test]
fn light_returns_from_an_oblique_wall_with_the_noise_of_its_kind() {
    let echoes = by_kind(SensorKind::Sonar, 60.0);
    let strays = echoes.iter().flatten().count();
    assert!(strays < 40, "{strays}");
    for (kind, sigma_mm) in [(SensorKind::Infrared, 1.5), (SensorKind::Laser, 5.0)] {
        let readings: Vec<f64> = by_kind(kind, 60.0).into_iter().flatten().collect();
        assert!(readings.len() > 1_990, "{kind:?}: {}", readings.len());
        let count = readings.len() as f64;
        let mean = readings.iter().sum::<f64>() / count;
        let variance = readings.iter().map(|mm| (mm - mean).powi(2)).sum::<f64>() / count;
        assert!((mean - 50.0).abs() < 0.5, "{kind:?}: {mean}");
        assert!(
            (variance.sqrt() - sigma_mm).abs() < 0.2,
            "{kind:?}: {variance}"
        );
    }
}

/// In a corridor along x the transducers ahead and to the left read different ranges, and one that
/// is turned by 90° to the left reads what the other does, exact and noisy, standing.
#[test]
fn a_turned_transducer_looks_elsewhere_from_its_time_on() {
    let corridor = Shape::room(Point::new(4.0, 1.5));
    let world = World::new("corridor", Pose::default(), vec![corridor]).unwrap();
    let pose = Pose::default();
    for model in [SonarModel::Ideal, SonarModel::Nomad] {
        let mut noise = Noise::new(1);
        let fault = "turned:0:90@10".parse().unwrap();
        let mut ring = Ring::new(model, &mut noise).with_faults(&[fault]);
        let mut readings = |time_s| {
            if model == SonarModel::Nomad {
                // A ping may be missed.
                let mut ping = |sensor| ring.ping(&world, &pose, sensor, time_s, &mut noise);
                return [0, 4].map(|sensor| (0..20).find_map(|_| ping(sensor)).unwrap());
            }
            let mut ranges = [None; 16];
            ring.scan_with_faults(&world, &pose, time_s, &mut ranges, &mut noise);
            [0, 4].map(|sensor| ranges[sensor].unwrap())
        };
        let [ahead, left] = readings(9.0);
        assert!(ahead > left + 2.0, "{model:?}: {ahead} {left}");
        let [turned, left] = readings(10.0);
        assert!((turned - left).abs() < 0.1, "{model:?}: {turned} {left}");
    }
}
