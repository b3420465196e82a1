use super::*;
use crate::nomad::{COLLISION_RADIUS_M, FACE_RADIUS_M};
use crate::robot::BaseLimits;
use crate::sonar::{FIRING_ORDER, RING_PERIOD_S, RingGeometry, SonarConfig};

const GOOD: &str = r#"name = "two-eyes"
drive = "differential"
radius_m = 0.25
max_speed_m_s = 0.75
max_turn_deg_s = 90.0
range_m = [0.15, 5.0]
cone_deg = 30.0
period_ms = 320
wheel_slip = 0.02
heading_drift_deg_m = 1.0
firing_order = [2, 0, 1]
[[sensor]]
bearing_deg = 90.0
position_m = [0.1, 0.2]
[[sensor]]
bearing_deg = -90.0
position_m = [0.1, -0.2]
kind = "infrared"
[[sensor]]
bearing_deg = 180
position_m = [-0.5, 0]
kind = "laser"
"#;

fn error(text: &str) -> String {
    let error = RobotModel::from_toml(text, "r.toml").unwrap_err();
    error.to_string()
}

#[test]
fn a_robot_file_becomes_a_robot() {
    let robot = RobotModel::from_toml(GOOD, "r.toml").unwrap();
    assert_eq!(
        (robot.name.as_str(), robot.drive, robot.radius_m),
        ("two-eyes", DriveKind::Differential, 0.25)
    );
    assert_eq!((robot.max_speed_m_s, robot.range_m), (0.75, [0.15, 5.0]));
    assert!((robot.max_turn_rad_s - core::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!((robot.half_cone_rad - core::f64::consts::PI / 12.0).abs() < 1e-15);
    assert_eq!((robot.period_s, robot.wheel_slip), (0.32, 0.02));
    assert!((robot.heading_drift - core::f64::consts::PI / 180.0).abs() < 1e-15);
    assert_eq!(robot.firing_order, Some(vec![2, 0, 1]));
    let kinds: Vec<_> = robot.sensors.iter().map(|sensor| sensor.kind).collect();
    assert_eq!(
        kinds,
        [SensorKind::Sonar, SensorKind::Infrared, SensorKind::Laser]
    );
    let [left, _, back] = robot.sensors.as_slice() else {
        panic!("{:?}", robot.sensors);
    };
    assert_eq!(left.position, Point::new(0.1, 0.2));
    assert!((left.bearing_rad - core::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(back.bearing_rad, core::f64::consts::PI);
}

#[test]
fn slip_drift_and_firing_order_may_be_left_out() {
    let mut text = GOOD.to_owned();
    for key in ["wheel_slip", "heading_drift_deg_m", "firing_order"] {
        let kept = text.lines().filter(|line| !line.starts_with(key));
        text = kept.collect::<Vec<_>>().join("\n");
    }
    let robot = RobotModel::from_toml(&text, "r.toml").unwrap();
    assert_eq!((robot.wheel_slip, robot.heading_drift), (0.0, 0.0));
    assert_eq!(robot.firing_order, None);
}

/// Each change to the good file, and the sentence after `r.toml, line `.
const MISTAKES: &[(&str, &str, &str)] = &[
    (
        "name = \"two-eyes\"",
        "name = \" \"",
        "1: name: expected a text that is not empty",
    ),
    (
        "name = \"two-eyes\"",
        "",
        "1: the file needs the key \"name\"",
    ),
    (
        "differential",
        "diferential",
        "2: drive: unknown drive \"diferential\", did you mean \"differential\"? \
         (known: synchro, differential, holonomic)",
    ),
    (
        "radius_m = 0.25",
        "radius_m = 0",
        "3: radius_m: must be above 0 and at most 10, not 0",
    ),
    (
        "radius_m = 0.25",
        "radius_m = nan",
        "3: radius_m: expected a finite number, found NaN",
    ),
    (
        "radius_m = 0.25",
        "radius = 0.25",
        "3: the file has no key \"radius\", did you mean \"radius_m\"? (keys: name, drive, \
         radius_m, max_speed_m_s, max_turn_deg_s, range_m, cone_deg, period_ms, wheel_slip, \
         heading_drift_deg_m, firing_order, sensor)",
    ),
    (
        "0.75",
        "-0.75",
        "4: max_speed_m_s: must be above 0 and at most 20, not -0.75",
    ),
    (
        "0.75",
        "\"fast\"",
        "4: max_speed_m_s: expected a number, found \"fast\"",
    ),
    (
        "90.0\nrange",
        "3601\nrange",
        "5: max_turn_deg_s: must be above 0 and at most 3600, not 3601",
    ),
    (
        "[0.15, 5.0]",
        "[5.0, 0.15]",
        "6: range_m: must be [shortest, longest] with 0 <= shortest < longest <= 1000, \
         not [5, 0.15]",
    ),
    (
        "[0.15, 5.0]",
        "[-0.15, 5.0]",
        "6: range_m: must be [shortest, longest] with 0 <= shortest < longest <= 1000, \
         not [-0.15, 5]",
    ),
    (
        "[0.15, 5.0]",
        "[0.15, inf]",
        "6: range_m: expected a finite number, found inf",
    ),
    (
        "cone_deg = 30.0",
        "cone_deg = 0.0",
        "7: cone_deg: must be above 0 and at most 180, not 0",
    ),
    (
        "cone_deg = 30.0",
        "cone_deg = 181",
        "7: cone_deg: must be above 0 and at most 180, not 181",
    ),
    (
        "period_ms = 320",
        "period_ms = 0",
        "8: period_ms: must be above 0 and at most 10000, not 0",
    ),
    (
        "period_ms = 320\n",
        "",
        "1: the file needs the key \"period_ms\"",
    ),
    ("0.02", "1.5", "9: wheel_slip: must be from 0 to 1, not 1.5"),
    (
        "heading_drift_deg_m = 1.0",
        "heading_drift_deg_m = -1.0",
        "10: heading_drift_deg_m: must be from 0 to 90, not -1",
    ),
    (
        "[2, 0, 1]",
        "[2, 0, 3]",
        "11: firing_order: there is no sensor 3, the last one is 2",
    ),
    (
        "[2, 0, 1]",
        "[2, 0, 2]",
        "11: firing_order: sensor 2 appears twice",
    ),
    (
        "[2, 0, 1]",
        "[2, 0]",
        "11: firing_order: sensor 1 is missing",
    ),
    ("[2, 0, 1]", "[]", "11: firing_order: sensor 0 is missing"),
    (
        "[2, 0, 1]",
        "[2, 0, -1]",
        "11: firing_order: expected a whole number from 0 to 255, found -1",
    ),
    (
        "[2, 0, 1]",
        "\"front first\"",
        "11: firing_order: expected a list, found \"front first\"",
    ),
    (
        "bearing_deg = 90.0\n",
        "",
        "12: sensor needs the key \"bearing_deg\"",
    ),
    (
        "bearing_deg = 90.0",
        "bearing_deg = 361",
        "13: sensor.bearing_deg: must be from -360 to 360, not 361",
    ),
    (
        "bearing_deg = 90.0",
        "angle_deg = 90.0",
        "13: sensor has no key \"angle_deg\" (keys: bearing_deg, position_m, kind)",
    ),
    (
        "[0.1, 0.2]",
        "[0.3, 0.41]",
        "14: sensor.position_m: sensor 0 is 0.508 m from the center, \
         more than 2 times radius_m = 0.25",
    ),
    (
        "infrared",
        "infrarot",
        "18: sensor.kind: unknown sensor kind \"infrarot\", did you mean \"infrared\"? \
         (known: sonar, infrared, laser)",
    ),
];

#[test]
fn every_mistake_is_named_with_its_line_and_key() {
    for (from, to, sentence) in MISTAKES {
        assert!(GOOD.contains(from), "{from}");
        let error = error(&GOOD.replacen(from, to, 1));
        assert_eq!(error, format!("r.toml, line {sentence}"), "{from} -> {to}");
    }
}

#[test]
fn a_robot_has_between_1_and_32_sensors() {
    let (head, sensor) = GOOD.split_once("firing_order").unwrap();
    let (_, sensor) = sensor.split_once("[[sensor]]").unwrap();
    let (sensor, _) = sensor.split_once("[[sensor]]").unwrap();
    let with = |count: usize| head.to_owned() + &format!("[[sensor]]{sensor}").repeat(count);
    assert_eq!(
        error(&format!("{head}sensor = []")),
        "r.toml, line 11: sensor: a robot needs at least one sensor"
    );
    assert_eq!(
        error(&format!("{head}sensor = 7")),
        "r.toml, line 11: sensor: expected a list, found 7"
    );
    assert_eq!(
        error(head),
        "r.toml, line 1: the file needs the key \"sensor\""
    );
    let most = RobotModel::from_toml(&with(MAX_SENSORS), "r.toml").unwrap();
    assert_eq!(most.sensors.len(), MAX_SENSORS);
    assert_eq!(
        error(&with(34)),
        "r.toml, line 108: sensor: a robot has at most 32 sensors, not 34"
    );
}

#[test]
fn a_missing_or_unreadable_file_is_named() {
    assert_eq!(error(""), "r.toml: the file is empty");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gone.toml");
    let load = |path: &Path| RobotModel::load(path).unwrap_err().to_string();
    assert!(load(&path).ends_with("gone.toml: there is no such file"));
    assert!(load(folder.path()).ends_with("is a folder, not a file"));
    std::fs::write(&path, "name = 7").unwrap();
    let sentence = "gone.toml, line 1: name: expected a text, found 7";
    assert!(load(&path).ends_with(sentence));
}

#[test]
fn a_damaged_file_is_an_error_or_a_robot_but_never_a_panic() {
    for cut in 0..GOOD.len() {
        let _ = RobotModel::from_toml(&GOOD[..cut], "r.toml");
        for damage in ["[", "]", "=", "-", "e9", "\u{0}", "\"", "é"] {
            let text = format!("{}{damage}{}", &GOOD[..cut], &GOOD[cut + 1..]);
            let _ = RobotModel::from_toml(&text, "r.toml");
        }
    }
}

#[test]
fn names_of_drives_and_sensor_kinds_are_read_back() {
    for name in DriveKind::NAMES {
        assert_eq!(name.parse::<DriveKind>().unwrap().name(), name);
    }
    for name in SensorKind::NAMES {
        assert_eq!(name.parse::<SensorKind>().unwrap().name(), name);
    }
}

#[test]
fn every_built_in_robot_has_its_own_name_and_sensors_on_the_body() {
    for name in RobotModel::builtin_names() {
        let robot = RobotModel::builtin(name).unwrap();
        assert_eq!(robot.name, name);
        for sensor in &robot.sensors {
            let distance = sensor.position.length();
            assert!(distance <= robot.radius_m, "{name} {sensor:?}");
        }
    }
    let counts = RobotModel::builtin_names().into_iter().map(|name| {
        let robot = RobotModel::builtin(name).unwrap();
        (name, robot.drive, robot.sensors.len())
    });
    use DriveKind::{Differential, Holonomic, Synchro};
    assert_eq!(
        counts.collect::<Vec<_>>(),
        [
            ("nomad200", Synchro, 16),
            ("p3dx", Differential, 16),
            ("p3dx-front", Differential, 8),
            ("p3at", Differential, 16),
            ("epuck2", Differential, 8),
            ("thymio2", Differential, 7),
            ("khepera", Differential, 8),
            ("crazyflie", Holonomic, 4),
            ("turtlebot3", Differential, 16),
            ("lidar16", Holonomic, 16),
            ("one-beam", Differential, 1),
        ]
    );
}

#[test]
fn every_built_in_robot_is_symmetric() {
    for name in RobotModel::builtin_names() {
        let robot = RobotModel::builtin(name).unwrap();
        for sensor in &robot.sensors {
            let mirrored = robot.sensors.iter().any(|other| {
                let turned = other.bearing_rad + sensor.bearing_rad;
                let apart = Point::new(
                    other.position.x - sensor.position.x,
                    other.position.y + sensor.position.y,
                );
                crate::world::wrap_angle(turned).abs() < 0.01 && apart.length() < 1e-9
            });
            assert!(mirrored, "{name} {sensor:?}");
        }
    }
}

#[test]
fn the_nomad_200_equals_the_simulated_one() {
    let robot = RobotModel::builtin("nomad200").unwrap();
    let (limits, config) = (BaseLimits::default(), SonarConfig::nomad());
    let ring = RingGeometry::default();
    let close = |number: f64, expected: f64| (number - expected).abs() < 1e-12;
    assert_eq!(robot.radius_m, COLLISION_RADIUS_M);
    assert_eq!(robot.max_speed_m_s, limits.speed_m_s);
    assert!(close(robot.max_turn_rad_s, limits.turn_rate_rad_s));
    assert!(close(robot.range_m[0], config.min_range_m));
    assert!(close(robot.range_m[1], config.max_range_m));
    assert!(close(robot.half_cone_rad, config.half_angle_rad));
    assert!(close(robot.period_s, RING_PERIOD_S));
    assert_eq!((robot.wheel_slip, robot.heading_drift), (limits.slip, 0.0));
    assert_eq!(robot.firing_order, Some(FIRING_ORDER.to_vec()));
    assert_eq!(robot.sensors.len(), ring.count);
    for (number, sensor) in robot.sensors.iter().enumerate() {
        let bearing = ring.bearing(number);
        assert!(close(sensor.bearing_rad, bearing), "{number}");
        assert_eq!(sensor.kind, SensorKind::Sonar);
        let face = Point::unit(bearing) * FACE_RADIUS_M;
        assert!(sensor.position.distance(face) < 1e-6, "{number}");
    }
}

#[test]
fn a_robot_is_found_by_name_or_file() {
    assert_eq!(RobotModel::find("p3dx").unwrap().name, "p3dx");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p3dx");
    std::fs::write(&path, GOOD).unwrap();
    let found = RobotModel::find(path.to_str().unwrap()).unwrap();
    assert_eq!(found.name, "two-eyes");
    let find = |text: &str| RobotModel::find(text).unwrap_err().to_string();
    let known = "nomad200, p3dx, p3dx-front, p3at, epuck2, thymio2, khepera, crazyflie, \
                 turtlebot3, lidar16, one-beam";
    assert_eq!(
        find("nomad20"),
        format!(
            "unknown robot \"nomad20\", did you mean \"nomad200\"? (a file, or one of: {known})"
        )
    );
    assert_eq!(
        find(""),
        format!("unknown robot \"\" (a file, or one of: {known})")
    );
    assert_eq!(find("gone.toml"), "gone.toml: there is no such robot file");
    assert_eq!(find("./p3dx"), "./p3dx: there is no such robot file");
    assert_eq!(
        RobotModel::builtin("kephera").unwrap_err().to_string(),
        format!("unknown robot \"kephera\", did you mean \"khepera\"? (known: {known})")
    );
}
