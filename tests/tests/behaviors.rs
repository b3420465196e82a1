//! Every behavior from the same 100 random moves runs in every world and meets its requirement.

use amp::config::Config;
use amp::controller::{Event, Motion, Outputs};
use amp::units::{Displacement, Millis};
use arena::robot::{COLLISION_RADIUS_M, TurretMode};
use arena::sonar::SonarModel;
use arena::world::World;
use experiments::behaviors::{BehaviorTrial, run_all};
use experiments::scenes::{BehaviorScene, SCENES};
use serde_json::Value;
use sim::behavior::Behavior;
use sim::episode::{Body, EpisodeReport, run};
use sim::pilot::Pilot;
use tests::{Program, host_sim};

/// The JSON object of one line from `run --json`.
fn line(program: &Program, flags: &str) -> Value {
    let text = program.ok(&format!("run --json {flags}"));
    assert_eq!(text.lines().count(), 1, "{text}");
    serde_json::from_str(&text).expect("a JSON object")
}

fn figure(line: &Value, key: &str) -> f64 {
    line[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key}: {line}"))
}

#[test]
fn every_behavior_runs_in_every_world() {
    let program = host_sim!();
    let names = Behavior::NAMES
        .into_iter()
        .chain(["avoid-right,wall-right,nest", "wall-left,follow"]);
    for name in names {
        for world in ["paper", "room", "corridor", "office", "posts", "random:3"] {
            let line = line(
                &program,
                &format!("--world {world} --behavior {name} --steps 40"),
            );
            assert_eq!(line["behavior"], name);
            assert_eq!(line["contacts"], 0, "{line}");
            let steps = figure(&line, "steps");
            // A chain ends when its last goal is reached.
            assert!(steps == 40.0 || name.contains(','), "{line}");
            assert!(figure(&line, "success") >= 0.0, "{line}");
            assert!(!line["success_unit"].as_str().unwrap_or_default().is_empty());
        }
    }
}

/// A built-in goal and one of a file are the same data.
#[test]
fn the_goal_of_a_behavior_does_the_same_from_a_file() {
    let program = host_sim!();
    for name in ["avoid", "avoid-right", "wall-left", "wall-right", "follow"] {
        let file = format!("{name}.toml");
        let text = program.ok(&format!("goal {name}"));
        std::fs::write(program.folder().join(&file), &text).expect("a file");
        let flags = format!("--world office --behavior {name} --steps 200");
        let own = line(&program, &flags);
        let mut of_file = line(&program, &format!("{flags} --goal {file}"));
        assert_eq!(of_file["behavior"], format!("{name} by {file}"));
        of_file["behavior"] = name.into();
        assert_eq!(of_file, own);
        // Sought as a situation, it is the same goal again.
        let again = program.ok(&format!("goal seek:{file}"));
        let goal = |text: &str| text.split_once("frame").expect("a frame").1.to_owned();
        assert_eq!(goal(&again), goal(&text));
    }
    // Another goal does something else, by the measure of the behavior.
    let flags = "--world office --behavior wall-left --steps 200";
    let left = line(&program, flags);
    let wrong = line(&program, &format!("{flags} --goal wall-right.toml"));
    assert_eq!(wrong["success_unit"], left["success_unit"]);
    assert!(figure(&wrong, "success") > 0.3, "{wrong}");
    assert!(figure(&left, "success") < 0.2, "{left}");
}

/// A wall is followed for 100 decisions before the next goal: until then the chain equals its first
/// part.
#[test]
fn a_chain_begins_as_its_first_part() {
    let program = host_sim!();
    let run = |behavior: &str| {
        let flags = format!("--world paper --behavior {behavior} --steps 90");
        let line = line(&program, &flags);
        ["steps", "distance_m", "coverage_m2", "time_s", "contacts"].map(|key| figure(&line, key))
    };
    assert_eq!(run("wall-left,wall-right"), run("wall-left"));
}

#[test]
fn a_captured_place_is_found_again() {
    let program = host_sim!();
    for (number, at) in ["1.5,1", "-1,0.5,0", "0,-1.2"].iter().enumerate() {
        let file = format!("place-{number}.toml");
        let said = program.ok(&format!("capture --world room --at {at} --out {file}"));
        assert!(said.contains(&format!("seek:{file}")), "{said}");
        let line = line(
            &program,
            &format!("--world room --behavior seek:{file} --shield off"),
        );
        assert_eq!(figure(&line, "success"), 1.0, "{line}");
        assert!(figure(&line, "distance_m") >= 0.7, "{line}");
    }
    let names: Vec<_> = program.files("").into_iter().map(|file| file.0).collect();
    assert_eq!(names, ["place-0.toml", "place-1.toml", "place-2.toml"]);
}

/// It goes there by the command that `capture` prints.
#[test]
fn a_body_finds_the_place_that_it_was_shown() {
    let program = host_sim!();
    let robot = "--robot turtlebot3 --ranges nomad";
    for at in ["1.5,1", "-1,0.5", "0,-1.2", "1,-0.8", "-1.3,-1"] {
        let said = program.ok(&format!(
            "capture {robot} --world room --at {at} --out place.toml"
        ));
        let command = said.split_once("Go there: host-sim run ").expect(&said).1;
        assert!(command.starts_with(robot), "{command}");
        let line = line(&program, &format!("{} --shield off", command.trim_end()));
        assert_eq!(figure(&line, "success"), 1.0, "{line}");
        assert!(figure(&line, "distance_m") >= 0.7, "{line}");
    }
}

#[test]
fn home_is_as_far_as_the_shortest_way_and_not_much_farther() {
    let program = host_sim!();
    let home = line(
        &program,
        "--world office --behavior home --tour 150 --shield off",
    );
    assert_eq!(figure(&home, "success"), 1.0, "{home}");
    let (way_m, shortest_m) = (figure(&home, "distance_m"), figure(&home, "shortest_m"));
    assert!(shortest_m > 2.0, "{home}");
    assert!((0.95..1.5).contains(&(way_m / shortest_m)), "{home}");
    let avoid = line(&program, "--world office --behavior avoid --steps 5");
    assert!(avoid["shortest_m"].is_null(), "{avoid}");
}

#[test]
fn the_list_names_every_behavior() {
    let program = host_sim!();
    let list = program.ok("behaviors --only wall --out pictures");
    assert!(list.contains("wall-left") && list.contains("follows a wall on its right"));
    assert!(list.contains("maps alone") && list.contains("with shield"));
    let files = program.files("pictures");
    for name in [
        "behaviors.svg",
        "behaviors.png",
        "wall-right-plain-room/path.png",
    ] {
        assert!(files.iter().any(|(file, _)| file == name), "{name}");
    }
}

/// All episodes of a scene.
fn reports(
    scene: &BehaviorScene,
    shield: bool,
    [worlds, seeds]: [u32; 2],
    explore_moves: u16,
) -> Vec<EpisodeReport> {
    let mut config = Config::recommended();
    if !shield {
        config.shield = None;
    }
    let trial = BehaviorTrial {
        robot: None,
        first: 101,
        worlds,
        seeds,
        explore_moves,
        preset: "default",
        config,
        turret: TurretMode::Held,
        sonar: SonarModel::Ideal,
    };
    let reports = run_all(scene, &trial, |world, setup| {
        Ok(run(world, setup, |_, _, _| {})?.report)
    });
    reports.expect("every episode runs").concat()
}

fn scene(behavior: &str, place: &str) -> &'static BehaviorScene {
    let mut scenes = SCENES.iter();
    let found = scenes.find(|scene| scene.behavior == behavior && scene.place == place);
    found.unwrap_or_else(|| panic!("{behavior} in {place}"))
}

fn mean(reports: &[EpisodeReport], figure: impl Fn(&EpisodeReport) -> f64) -> f64 {
    reports.iter().map(figure).sum::<f64>() / reports.len() as f64
}

#[test]
fn a_wall_is_followed_at_its_distance() {
    for behavior in ["wall-right", "wall-left"] {
        for place in ["plain room", "five boxes", "corridor"] {
            let scene = scene(behavior, place);
            let bare = reports(scene, false, [10, 3], 100);
            let error = mean(&bare, |report| report.success);
            assert!(error <= 0.12, "{behavior} in {place}: {error} m");
            // It moves all the time: 1000 steps of 0.25 m.
            assert!(bare.iter().all(|report| report.distance_m > 200.0));
            assert!(mean(&bare, |report| f64::from(report.contacts)) <= 10.0);
            let shielded = reports(scene, true, [10, 1], 100);
            assert!(shielded.iter().all(|report| report.contacts == 0));
            assert!(mean(&shielded, |report| report.success) <= 0.20);
        }
    }
}

#[test]
fn the_nest_and_a_place_that_was_shown_are_found() {
    for behavior in ["nest", "seek"] {
        for (place, least) in [("4 m × 4 m", 98), ("six boxes", 80)] {
            let bare = reports(scene(behavior, place), false, [10, 10], 100);
            let found = bare.iter().filter(|report| report.success == 1.0).count();
            println!("{behavior} in {place}: {found} of 100");
            assert!(found >= least, "{behavior} in {place}: {found} of 100");
        }
    }
}

#[test]
fn a_robot_that_knows_nothing_finds_no_nest() {
    // A sample without rotations has no information across its direction.
    let mut config = Config::recommended();
    config.learning.augment_rotations = false;
    config.planning.wander = None;
    config.online = None;
    let trial = BehaviorTrial {
        robot: None,
        first: 101,
        worlds: 10,
        seeds: 5,
        explore_moves: 1,
        preset: "default",
        config,
        turret: TurretMode::Held,
        sonar: SonarModel::Ideal,
    };
    let found = run_all(scene("nest", "4 m × 4 m"), &trial, |world, setup| {
        Ok(run(world, setup, |_, _, _| {})?.report.success)
    });
    let found: f64 = found.expect("every episode runs").concat().iter().sum();
    assert!(found <= 15.0, "{found} of 50");
}

#[test]
fn obstacles_are_passed_on_the_asked_side() {
    let bare = reports(scene("avoid-right", "one obstacle"), false, [10, 3], 100);
    assert!(mean(&bare, |report| report.success) >= 0.9);
    assert!(mean(&bare, |report| report.distance_m) > 200.0);
}

#[test]
fn a_leader_is_kept_and_not_touched() {
    for place in ["plain room", "five boxes"] {
        let bare = reports(scene("follow", place), false, [10, 3], 100);
        let kept = mean(&bare, |report| report.success);
        assert!(kept >= 0.85, "{place}: {kept}");
        // The leader moves 45 m in 300 s at most: a robot that follows it has moved far, too.
        assert!(mean(&bare, |report| report.distance_m) > 15.0);
    }
}

/// Drives straight ahead, whatever its sonars report.
struct Ram;

impl Pilot for Ram {
    fn handle(&mut self, _: Millis, event: Event<16>) -> Outputs<16> {
        let motion = matches!(event, Event::Echo { sensor: 15, .. }).then(|| Motion {
            id: 1,
            displacement: Displacement::saturating(250, 0),
            speed_mm_s: 500,
        });
        Outputs {
            motion,
            ..Outputs::NONE
        }
    }
}

#[test]
fn touching_the_leader_is_a_contact() {
    let world = World::builtin("room").expect("a built-in world");
    let mut body = Body::new(&world, SonarModel::Ideal, TurretMode::Held, 1);
    let start = world.start().position;
    let free = world.sweep(start, start + arena::world::Point::new(1.5, 0.0), 0.3);
    assert!(!free.touched(), "nothing but the leader is in the way");
    body.add_leader();
    let moved: Vec<_> = (0..30)
        .map_while(|_| body.advance(&mut Ram).moved)
        .take_while(|moved| moved.from.distance(start) < 1.2)
        .collect();
    let touch = moved.iter().find(|moved| moved.touched).expect("a contact");
    let gap = touch.to.distance(body.leader().expect("the leader"));
    assert!(gap > 2.0 * COLLISION_RADIUS_M - 0.01, "{gap}");
}
