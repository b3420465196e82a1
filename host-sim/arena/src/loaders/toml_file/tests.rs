use super::*;

const GOOD: &str = r#"name = "corridor"
[start]
position_m = [0, 1.5]
heading_deg = 90
[[wall]]
points_m = [[-3.0, -2.0], [5.0, -2.0], [5.0, 3.0]]
[[box]]
center_m = [1.0, 0.5]
size_m = [0.4, 0.8]
angle_deg = 180.0
[[circle]]
center_m = [2.0, -1.0]
radius_m = 0.3
"#;

fn error(text: &str) -> String {
    World::from_toml(text, "w.toml").unwrap_err().to_string()
}

#[test]
fn a_world_file_becomes_a_world() {
    let world = World::from_toml(GOOD, "w.toml").unwrap();
    assert_eq!(world.name(), "corridor");
    let start = world.start();
    assert_eq!(start.position, Point::new(0.0, 1.5));
    assert!((start.heading - core::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(world.segments().count(), 6);
    let [
        Shape::Wall { points },
        Shape::Box {
            center,
            size,
            angle,
        },
        Shape::Circle { radius, .. },
    ] = world.shapes()
    else {
        panic!("{:?}", world.shapes());
    };
    assert_eq!((points.len(), points[2]), (3, Point::new(5.0, 3.0)));
    assert_eq!(
        (*center, *size, *radius),
        (Point::new(1.0, 0.5), Point::new(0.4, 0.8), 0.3)
    );
    assert!((angle - core::f64::consts::PI).abs() < 1e-15);
}

#[test]
fn all_but_one_shape_may_be_left_out() {
    let text = "[[circle]]\ncenter_m = [0x10, 1_0]\nradius_m = 1e-1\n";
    let world = World::from_toml(text, "post").unwrap();
    assert_eq!((world.name(), world.start()), ("post", Pose::default()));
    assert_eq!(world.bounds().0.distance(Point::new(15.9, 9.9)), 0.0);
}

/// Each change to the good file, and what the sentence must say.
#[test]
fn every_mistake_is_named_with_its_line() {
    for (from, to, words) in [
        (
            "heading_deg",
            "heading",
            "line 4: start has no key \"heading\"",
        ),
        ("heading_deg", "headin_deg", "did you mean \"heading_deg\"?"),
        (
            "[[circle]]",
            "[[circel]]",
            "line 11: the file has no key \"circel\", did you mean \"circle\"?",
        ),
        (
            "radius_m",
            "radius",
            "line 13: circle has no key \"radius\", did you mean \"radius_m\"?",
        ),
        (
            "angle_deg",
            "angel_deg",
            "line 10: box has no key \"angel_deg\", did you mean \"angle_deg\"?",
        ),
        (
            "radius_m = 0.3\n",
            "",
            "line 11: circle needs the key \"radius_m\"",
        ),
        ("0.3", "0", "line 13: a circle's radius must be positive"),
        ("0.3", "-0.3", "not -0.3"),
        (
            "0.3",
            "nan",
            "line 13: circle.radius_m: expected a finite number, found NaN",
        ),
        (
            "0.3",
            "inf",
            "line 13: circle.radius_m: expected a finite number",
        ),
        ("0.3", "1e6", "line 13: a circle's radius"),
        (
            "0.3",
            "\"wide\"",
            "line 13: circle.radius_m: expected a number, found \"wide\"",
        ),
        ("[0.4, 0.8]", "[0.4, 0.0]", "line 9: a box's depth"),
        ("[0.4, 0.8]", "[-0.4, 0.8]", "line 9: a box's width"),
        (
            "[0.4, 0.8]",
            "0.4",
            "line 9: box.size_m: expected two numbers: [x, y], found 0.4",
        ),
        (
            "[1.0, 0.5]",
            "[1.0, 0.5, 0.0]",
            "line 8: box.center_m: expected two numbers: [x, y], found 3",
        ),
        ("[1.0, 0.5]", "[1.0, 2e5]", "a coordinate must lie within"),
        (
            ", [5.0, -2.0], [5.0, 3.0]",
            "",
            "line 6: a wall needs at least 2 points, not 1",
        ),
        (
            "[5.0, 3.0]",
            "[5.0]",
            "line 6: wall.points_m: expected two numbers: [x, y], found 1",
        ),
        (
            "[5.0, 3.0]",
            "[5.0, -2.0]",
            "line 6: points 2 and 3 of a wall are the same",
        ),
        (
            "[[-3.0, -2.0], [5.0, -2.0], [5.0, 3.0]]",
            "7",
            "line 6: wall.points_m: expected a list, found 7",
        ),
        (
            "[[wall]]",
            "[wall]",
            "line 5: wall: expected a list of tables: [[wall]]",
        ),
        (
            "[start]",
            "[[start]]",
            "line 2: start: expected a table, found a list",
        ),
        (
            "[[box]]",
            "[[box]]\n\"a\\n`b\" = 1",
            "line 8: box has no key \"a `b\" (keys: center_m, size_m, angle_deg)",
        ),
        (
            "0.3",
            "99999999999999999999",
            "line 13: circle.radius_m: expected a number, found 99999999999999999999",
        ),
        ("[0, 1.5]", "[1.0, 0.5]", "would start inside something"),
        ("[0, 1.5]", "[0, -1.74]", "would start inside something"),
        ("[0, 1.5]", "[0, 1e9]", "the start: a coordinate"),
        (
            "name = \"corridor\"",
            "name = 7",
            "line 1: name: expected a text, found 7",
        ),
        (
            "name = \"corridor\"",
            "name = \"\"",
            "line 1: name: expected a text that is not empty",
        ),
        ("heading_deg = 90", "heading_deg = ", "line 4"),
        (
            "heading_deg = 90",
            "heading_deg = 90\nheading_deg = 91",
            "line 5",
        ),
    ] {
        assert!(GOOD.contains(from));
        let error = error(&GOOD.replacen(from, to, 1));
        assert!(
            error.contains(words) && error.starts_with("w.toml"),
            "{error}\n  lacks {words}"
        );
        assert!(!error.contains('\n'), "one sentence: {error}");
    }
}

#[test]
fn a_file_without_a_world_is_named() {
    assert_eq!(error(""), "w.toml: the file is empty");
    assert_eq!(error(" \n\n"), "w.toml: the file is empty");
    assert!(error("name = \"x\"").contains("at least one wall, box or circle"));
    assert!(error("box = []").contains("at least one wall, box or circle"));
    assert!(error("start = 1\n").contains("line 1: start: expected a table, found 1"));
    let circle = "circle = [[[2, -1], 0.3]]";
    assert!(error(circle).contains("line 1: circle: expected a table, found a list"));
    let folder = tempfile::tempdir().unwrap();
    let load = |name: &str| {
        World::load(&folder.path().join(name))
            .unwrap_err()
            .to_string()
    };
    assert!(load("gone.toml").ends_with("gone.toml: there is no such file"));
    std::fs::write(folder.path().join("binary.toml"), [0xff, 0xfe, 0, 1]).unwrap();
    assert!(load("binary.toml").ends_with("binary.toml: is not a text file"));
    std::fs::write(folder.path().join("scan.png"), "").unwrap();
    assert!(load("scan.png").contains("a world is a .toml world file or a .yaml map"));
    std::fs::create_dir(folder.path().join("folder.toml")).unwrap();
    assert!(load("folder.toml").contains("is a folder, not a file"));
}

#[test]
fn a_damaged_file_is_an_error_or_a_world_but_never_a_panic() {
    for cut in 0..GOOD.len() {
        let _ = World::from_toml(&GOOD[..cut], "w.toml");
        for damage in ["[", "]", "=", "-", "e9", "\u{0}", "\"", "é"] {
            let text = format!("{}{damage}{}", &GOOD[..cut], &GOOD[cut + 1..]);
            let _ = World::from_toml(&text, "w.toml");
        }
    }
}

#[test]
fn a_start_outside_the_walls_is_refused() {
    let closed = "[[wall]]\npoints_m = [[-2, -2], [2, -2], [2, 2], [-2, 2], [-2, -2]]\n";
    let open = "[[wall]]\npoints_m = [[-2, -2], [2, -2]]\n";
    let post = "[[circle]]\ncenter_m = [0, -3]\nradius_m = 0.1\n";
    let starts_at = |[x, y]: [f64; 2], shapes: &str| {
        let text = format!("[start]\nposition_m = [{x}, {y}]\n{shapes}");
        let world = parse(&text, "w.toml", "w");
        world.map(drop).map_err(|error| error.to_string())
    };
    // The corner from (1, 1) to (3, 3) is not in it; what else stands there, stands outside.
    let l_shaped =
        "[[wall]]\npoints_m = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3], [0, 0]]\n";
    let crate_outside = "[[box]]\ncenter_m = [6, 6]\nsize_m = [1, 1]\n";
    let l_and_crate = format!("{l_shaped}{crate_outside}");
    let pillar = "[[wall]]\npoints_m = [[0, -1], [1, -1], [1, -2], [0, -1]]\n";
    let in_chain = format!("{pillar}[[wall]]\npoints_m = [[-3, -3], [3, -3], [3, 3], [-3, 3]]\n");
    let round: Vec<String> = (0..=36)
        .map(|tenth| Point::unit(core::f64::consts::PI / 18.0 * f64::from(tenth % 36)) * 3.0)
        .map(|point| format!("[{}, {}]", point.x, point.y))
        .collect();
    let round = format!("[[wall]]\npoints_m = [{}]\n", round.join(", "));
    for (place, shapes) in [
        ([1.0, 1.0], closed),
        ([1.0, 4.4], open),
        ([99.0, 99.0], post),
        ([0.5, 2.5], l_shaped),
        ([2.5, 0.5], &l_and_crate),
        ([0.0, 1.0], &in_chain),
        ([1.5, 2.0], &round),
    ] {
        let world = starts_at(place, shapes);
        assert!(world.is_ok(), "{place:?} {shapes} {world:?}");
    }
    for (place, shapes) in [
        ([0.0, 2.5], closed),
        ([9.0, 0.0], open),
        ([2.0, 2.0], l_shaped),
        ([2.5, 2.5], &l_and_crate),
        ([5.0, 5.0], &l_and_crate),
        ([0.0, 3.5], &in_chain),
        ([2.5, 2.5], &round),
    ] {
        let why = starts_at(place, shapes).unwrap_err();
        let named = why.starts_with("w.toml, line 2: position_m") && why.contains("outside");
        assert!(named, "{place:?} {shapes} {why}");
    }
}

const SOURCES: &str = r#"[[light]]
position_m = [1, 0]
brightness = 0.5
until_s = 60
[[light]]
position_m = [2, 0]
[[scent]]
position_m = [0, 1]
reach_m = 1.5
[[floor]]
center_m = [3, 1]
size_m = [1, 2]
angle_deg = 90
color = "green"
"#;

#[test]
fn what_else_can_be_perceived_is_read() {
    let world = World::from_toml(&[GOOD, SOURCES].concat(), "w.toml").unwrap();
    let Sources {
        lights,
        scents,
        floor,
    } = world.sources();
    assert_eq!((lights[0].brightness, lights[0].until_s), (0.5, Some(60.0)));
    assert_eq!((lights[1].brightness, lights[1].until_s), (1.0, None));
    assert_eq!(
        (scents[0].position, scents[0].reach_m),
        (Point::new(0.0, 1.0), 1.5)
    );
    assert_eq!(
        (floor[0].size, floor[0].color),
        (Point::new(1.0, 2.0), [0.1, 0.8, 0.1])
    );
    assert!((floor[0].angle - core::f64::consts::FRAC_PI_2).abs() < 1e-15);
    for (from, to, words) in [
        (
            "0.5",
            "0",
            "line 15: a light's brightness must be above 0 and at most 1, not 0",
        ),
        (
            "1.5",
            "-1",
            "line 21: a scent's reach must lie in 0.1..=100 m, not -1",
        ),
        (
            "\"green\"",
            "\"gren\"",
            "line 27: unknown color \"gren\", did you mean \"green\"?",
        ),
        (
            "[1, 2]",
            "[1, 0]",
            "line 25: a patch's depth must be positive",
        ),
        (
            "[0, 1]",
            "[0, 1e9]",
            "line 21: a coordinate must lie within",
        ),
        (
            "until_s",
            "untils",
            "light has no key \"untils\", did you mean \"until_s\"?",
        ),
        ("color = \"green\"\n", "", "floor needs the key \"color\""),
    ] {
        let changed = [GOOD, &SOURCES.replacen(from, to, 1)].concat();
        let why = error(&changed);
        assert!(why.contains(words), "{words}: {why}");
    }
}
