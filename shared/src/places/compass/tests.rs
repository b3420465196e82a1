use super::*;

fn degrees(angle: f64) -> Bearing {
    Bearing::from_turns((angle / 360.0 * 65_536.0).round() as i32 as u16)
}

fn as_degrees(turns: i16) -> f64 {
    f64::from(turns) * 360.0 / 65_536.0
}

/// A robot among walls whose odometry errs.
#[derive(Default)]
struct Drifting {
    compass: Option<Compass>,
    /// Farther to the left than its odometry tells.
    error_deg: f64,
    corrected: i16,
}

impl Drifting {
    /// Goes on by 0.25 m and hears walls whose normals are these.
    fn goes(&mut self, drift_deg: f64, normals_deg: &[f64]) -> f64 {
        self.error_deg += drift_deg;
        let compass = self.compass.get_or_insert(Compass::NEW);
        let mut walls = WallDirections::NONE;
        for normal in normals_deg {
            let seen = normal - self.error_deg + as_degrees(self.corrected);
            walls.add(degrees(seen).plus(compass.frame()), 100);
        }
        let turn = compass.update(250, &walls);
        self.corrected += turn.as_signed_turns();
        (self.error_deg - as_degrees(self.corrected)).abs()
    }
}

#[test]
fn a_heading_that_drifts_far_is_known_by_the_walls() {
    for drift in [-0.05, 0.05] {
        let mut robot = Drifting::default();
        for _ in 0..20 {
            robot.goes(0.0, &[10.0, 100.0]);
        }
        // 30° in all, beyond what is compared at a time.
        for step in 0..600 {
            let error = robot.goes(drift, &[10.0, -80.0]);
            assert!(error < 2.8, "{step}: {error}");
        }
    }
}

#[test]
fn without_walls_the_heading_is_that_of_the_odometry() {
    let mut robot = Drifting::default();
    for _ in 0..200 {
        robot.goes(0.1, &[]);
    }
    assert_eq!(robot.corrected, 0);
}

/// Something askew now and then, and no wall in between.
#[test]
fn a_few_things_askew_turn_it_little() {
    let mut robot = Drifting::default();
    for _ in 0..40 {
        robot.goes(0.0, &[0.0, 0.0, 0.0]);
    }
    for _ in 0..4 {
        robot.goes(0.0, &[8.0]);
    }
    assert!(robot.goes(0.0, &[0.0]) < 1.5);
}

#[test]
fn it_hears_walls_for_days() {
    let mut robot = Drifting::default();
    // Weights that only grow are more than 32 bits after 430 000.
    for _ in 0..450_000 {
        robot.goes(0.0, &[0.0; 100]);
    }
    robot.goes(4.0, &[0.0; 100]);
    let errors = (0..10).map(|_| robot.goes(0.0, &[0.0; 100]));
    assert!(errors.last() < Some(2.0));
}

#[test]
fn walls_tell_a_robot_that_was_turned_which_way_it_faces_but_for_right_angles() {
    for turned in [-170.0, -44.0, -20.0, 0.0, 3.0, 31.0, 44.0, 100.0] {
        let mut robot = Drifting::default();
        for _ in 0..20 {
            robot.goes(0.0, &[10.0, 100.0]);
        }
        let compass = robot.compass.as_mut().expect("it has gone");
        compass.forget_heading();
        assert_eq!(compass.align(), None);
        let known = compass.known;
        robot.error_deg = turned;
        let mut turns = (0..20).map(|_| {
            robot.goes(0.0, &[10.0, -80.0]);
            let compass = robot.compass.as_mut().expect("it has gone");
            // As long as it faces anywhere it learns nothing of walls.
            assert!(compass.is_aligned() || compass.known == known);
            compass.align()
        });
        let turn = turns.find_map(|turn| turn).expect("it hears walls");
        let left = (turned - as_degrees(turn.as_signed_turns())) / 90.0;
        assert!((left - left.round()).abs() < 0.03, "{turned}: {turn:?}");
        robot.corrected += turn.as_signed_turns();
        for _ in 0..10 {
            robot.goes(0.0, &[10.0, -80.0]);
        }
        let left = (turned - as_degrees(robot.corrected)) / 90.0;
        assert!((left - left.round()).abs() < 0.02, "{turned}: {left}");
    }
}

#[test]
fn without_walls_it_may_face_anywhere() {
    let mut robot = Drifting::default();
    robot.goes(0.0, &[10.0]);
    robot
        .compass
        .as_mut()
        .expect("it has gone")
        .forget_heading();
    for _ in 0..50 {
        robot.goes(0.0, &[]);
    }
    let mut compass = robot.compass.expect("it has gone");
    assert!(compass.align().is_none() && !compass.is_aligned());
}

/// Things askew are heard from two positions, walls from more.
#[test]
fn what_is_heard_twice_does_not_tell_a_heading() {
    let mut robot = Drifting::default();
    for _ in 0..20 {
        robot.goes(0.0, &[10.0, 100.0]);
    }
    robot
        .compass
        .as_mut()
        .expect("it has gone")
        .forget_heading();
    let mut aligned = (0..10).map(|_| {
        robot.goes(0.0, &[40.0]);
        let compass = robot.compass.as_mut().expect("it has gone");
        compass.align().is_some()
    });
    assert!((3..8).contains(&aligned.position(|is_aligned| is_aligned).unwrap_or(10)));
}
