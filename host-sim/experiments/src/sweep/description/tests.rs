use super::*;
use sim::settings;

/// Flags that accept any value; settings as they are.
fn vocabulary() -> Vocabulary {
    Vocabulary {
        flags: ["steps", "preset"].map(str::to_owned).into(),
        check: |key, value| match key {
            "steps" | "preset" => Ok(()),
            _ => settings::set(&mut amp::config::Config::recommended(), key, value),
        },
        setup: |_| Err(BadInput::new("not asked for here")),
    }
}

fn read(text: &str) -> Result<Description, BadInput> {
    Description::read(text, "sweep.toml", "sweep", &vocabulary())
}

#[test]
fn everything_has_a_default() {
    let sweep = read("[fixed]\nsteps = 5\n").expect("a sweep");
    assert_eq!((sweep.name.as_str(), sweep.seeds), ("sweep", vec![1]));
    assert_eq!(sweep.behaviors, [Behavior::Avoid]);
    assert_eq!(sweep.worlds, [WorldSource::Builtin("paper")]);
    assert_eq!(sweep.points.count(), Some(1));
}

#[test]
fn lists_are_read_as_the_command_line_reads_them() {
    let text = "name = \"a-b_1.2\"\nworlds = [\"random:1..=3\", \"room\"]\nbehaviors = [\"nest\", \"avoid,nest\"]\n\
                seeds = \"3..=5\"\n";
    let sweep = read(text).expect("a sweep");
    assert_eq!(sweep.name, "a-b_1.2");
    assert_eq!((sweep.worlds.len(), sweep.behaviors.len()), (4, 2));
    assert_eq!(sweep.seeds, [3, 4, 5]);
    assert_eq!(read("seeds = 7").expect("a sweep").seeds, [7]);
    assert_eq!(read("seeds = [7, 2]").expect("a sweep").seeds, [7, 2]);
}

#[test]
fn points_come_as_they_stand_in_the_file() {
    let text = "[[list]]\nfar = 2.50\nfull-steps = true\n\
                [grid]\nwanted = [\"all\", \"unmet\"]\nexplore.draws = [1, 2.0]\n";
    let points = read(text).expect("a sweep").points;
    assert_eq!(
        points.keys(),
        ["wanted", "explore.draws", "far", "full-steps"]
    );
    assert_eq!(points.count(), Some(4 + 1));
    assert_eq!(points.cells(1), ["all", "2", "", ""]);
    assert_eq!(points.cells(2), ["unmet", "1", "", ""]);
    assert_eq!(points.cells(4), ["", "", "2.5", "on"]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    for (text, words) in [
        ("", "sweep.toml: the file is empty"),
        ("worlds = [\n", "sweep.toml, line"),
        (
            "seed = 1",
            "line 1: the file has no key \"seed\", did you mean \"seeds\"?",
        ),
        (
            "worlds = []",
            "worlds must be a list with at least one entry",
        ),
        (
            "worlds = [\n\"paepr\"]",
            "line 2: unknown world \"paepr\", did you mean \"paper\"?",
        ),
        ("behaviors = [\"nets\"]", "did you mean \"nest\"?"),
        ("seeds = -1", "whole number"),
        ("seeds = \"5..=4\"", "range of 1 to"),
        ("seeds = \"all\"", "1..=10"),
        ("name = \"a/b\"", "letters, digits"),
        (
            "\n[grid]\nfarr = [1]",
            "line 3: a point has no key \"farr\", did you mean \"far\"?",
        ),
        ("[grid]\nfar = 1", "far must be a list"),
        (
            "[grid]\nfar = [\"x\"]",
            "line 2: setting far cannot be \"x\"",
        ),
        (
            "[grid]\nfar = [nan]",
            "line 2: grid.far: expected a finite number",
        ),
        ("[grid]\nfar = [[1]]", "a value of far must be"),
        ("[grid]\nseed = [1]", "lists at the top"),
        (
            "[fixed]\nfar = 2\n[grid]\nfar = [1]",
            "line 4: \"far\" is in [fixed] already",
        ),
        (
            "[grid]\nexplore.draws = [1]\n\"explore.draws\" = [2]",
            "occurs twice",
        ),
        (
            "\n[random]\npoints = 20\nfar = { min = 1.0, max = 6.0 }",
            "line 2: the file has no key \"random\" (keys: name, worlds,",
        ),
        (
            "[grid]\nfar = { min = 1.0, max = 6.0 }",
            "line 2: a point has no key \"far.min\"",
        ),
        ("grid = 1", "line 1: grid: expected a table, found 1"),
        ("list = 1", "line 1: list: expected a list, found 1"),
    ] {
        let error = read(text).expect_err(text).to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}

#[test]
fn a_grid_too_large_is_refused() {
    let axis = |key: &str| format!("{key} = [{}]\n", vec!["1"; 200].join(", "));
    let text = format!("[grid]\n{}{}{}", axis("far"), axis("steps"), axis("epochs"));
    let error = read(&text).expect_err("8 million points").to_string();
    assert!(error.contains("more than 100000 points"), "{error}");
}
