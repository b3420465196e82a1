//! Every kind of world runs, and its JSON line has all documented fields.

use serde_json::Value;
use tests::host_sim;

const TOML: &str = "name = \"hall\"\n[start]\nposition_m = [0.0, 0.0]\nheading_deg = 30.0\n\
    [[wall]]\npoints_m = [[-3, -2], [5, -2], [5, 2], [-3, 2], [-3, -2]]\n\
    [[box]]\ncenter_m = [2, 1]\nsize_m = [0.4, 0.4]\nangle_deg = 20\n\
    [[circle]]\ncenter_m = [2.0, -1.0]\nradius_m = 0.3\n";

const YAML: &str = "image: floor.pgm\nresolution: 0.5\norigin: [-4.0, -3.0, 0.0]\nnegate: 0\n\
    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

/// An image of 14 × 10 free cells within walls.
fn floor() -> Vec<u8> {
    let mut image = b"P5\n16 12\n255\n".to_vec();
    for cell in 0..16 * 12 {
        let (column, row) = (cell % 16, cell / 16);
        let wall = column == 0 || column == 15 || row == 0 || row == 11;
        image.push(if wall { 0 } else { 254 });
    }
    image
}

/// The same as a PNG image.
fn floor_png() -> Vec<u8> {
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"16\" height=\"12\">\
               <rect width=\"16\" height=\"12\" fill=\"#000000\"/>\
               <rect x=\"1\" y=\"1\" width=\"14\" height=\"10\" fill=\"#fefefe\"/></svg>";
    plots::png::render(svg, 1.0).expect("a bitmap")
}

/// The documented keys, in order, and their type: text, count or number.
const KEYS: [(&str, char); 16] = [
    ("world", 't'),
    ("behavior", 't'),
    ("seed", 'n'),
    ("explore_moves", 'n'),
    ("explore_contacts", 'n'),
    ("steps", 'n'),
    ("contacts", 'n'),
    ("touched_by", 'n'),
    ("distance_m", 'f'),
    ("min_clearance_m", 'f'),
    ("coverage_m2", 'f'),
    ("goal_steps", 'n'),
    ("shield_stops", 'n'),
    ("time_s", 'f'),
    ("success", 'f'),
    ("success_unit", 't'),
];

fn check(line: &str, world: &str) {
    let object: Value = serde_json::from_str(line).expect(line);
    let mut after = 0;
    for (key, kind) in KEYS {
        let at = line.find(&format!("\"{key}\":"));
        let at = at.unwrap_or_else(|| panic!("{key} is missing: {line}"));
        assert!(at >= after, "{key} out of order: {line}");
        after = at;
        let value = &object[key];
        let sane = match kind {
            't' => value.as_str().is_some_and(|text| !text.is_empty()),
            'n' => value.is_u64(),
            _ => value.as_f64().is_some_and(|figure| figure >= 0.0),
        };
        assert!(sane, "{key}: {value}");
    }
    assert_eq!(object["world"], world);
    assert_eq!(object["seed"], 5);
    assert_eq!(object["explore_moves"], 40);
    assert_eq!(object["steps"], 30);
    let count = |key: &str| object[key].as_u64().expect(key);
    assert!(count("goal_steps") <= 30 && count("contacts") <= 30);
    // A step is 0.25 m; whole millimeters and the slip of the wheels may add a little.
    assert!(object["distance_m"].as_f64() <= Some(30.0 * 0.25 * 1.05));
    assert!(object["success"].as_f64() <= Some(1.0));
    assert!(object["time_s"].as_f64() > Some(30.0 * 0.6));
}

#[test]
fn every_kind_of_world_runs() {
    let program = host_sim!();
    program.put("hall.toml", TOML);
    program.put("folder/b.toml", TOML.replace("hall", "second"));
    program.put("folder/a.yaml", YAML);
    program.put("folder/floor.pgm", floor());
    program.put("folder/notes.txt", "not a world");
    for (named, worlds) in [
        ("hall.toml", &["hall"][..]),
        ("folder", &["a", "second"]),
        ("folder/a.yaml", &["a"]),
        ("random:3..=4", &["random:3", "random:4"]),
        ("paper", &["paper"]),
        ("room", &["room"]),
        ("corridor", &["corridor"]),
        ("office", &["office"]),
        ("posts", &["posts"]),
    ] {
        for sonar in ["ideal", "nomad"] {
            let lines = program.ok(&format!(
                "run --world {named} --sonar {sonar} --explore 40 --steps 30 --seed 5 --json"
            ));
            assert_eq!(lines.lines().count(), worlds.len(), "{named}: {lines}");
            for (line, world) in lines.lines().zip(worlds) {
                check(line, world);
            }
        }
    }
}

#[test]
fn a_map_is_the_same_as_pgm_and_as_png() {
    let program = host_sim!();
    for (folder, name, image) in [
        ("pgm", "floor.pgm", floor()),
        ("png", "floor.png", floor_png()),
    ] {
        program.put(
            &format!("{folder}/lab.yaml"),
            YAML.replace("floor.pgm", name),
        );
        program.put(&format!("{folder}/{name}"), image);
    }
    let run = |folder: &str| {
        program.ok(&format!(
            "run --world {folder}/lab.yaml --explore 40 --steps 30 --json"
        ))
    };
    assert_eq!(run("png"), run("pgm"));
}

#[test]
fn worlds_can_be_mixed_and_keep_their_order() {
    let program = host_sim!();
    program.put("hall.toml", TOML);
    let table = program.ok("run --world random:2 --world hall.toml --world room --steps 5");
    let at = |name: &str| {
        table
            .find(name)
            .unwrap_or_else(|| panic!("{name}: {table}"))
    };
    assert!(at("random:2") < at("hall") && at("hall") < at("room") && at("room") < at("mean"));
}

#[test]
fn each_world_gets_its_own_pictures() {
    let program = host_sim!();
    let _ = program.ok("run --world random:1..=2 --explore 20 --steps 5 --out pictures");
    let files = program.files("pictures");
    for room in ["0001-random-1", "0002-random-2"] {
        for file in ["index.html", "path.svg", "path.png"] {
            let name = format!("{room}/{file}");
            assert!(files.iter().any(|(other, _)| *other == name), "{name}");
        }
    }
}
