//! The same code for robots that differ in data only, and for maps of other shapes.

use amp::config::Config;
use amp::controller::{Command, Event, Mode, Outputs, Progress, State, handle};
use amp::fixed::{Mask, Weight};
use amp::goal::Goal;
use amp::robot::{RobotSpec, evenly_spaced};
use amp::scan::Encoding;
use amp::som::Update;
use amp::som::{Decay, Grid, Neighborhood, Schedule, Som};
use amp::units::{Bearing, Displacement, Millis, Range};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// A robot of any ring in a round room; its ring keeps its bearing.
struct Round<const SENSORS: usize> {
    config: Config<SENSORS>,
    state: State<SENSORS, 16, 60>,
    radius_mm: f64,
    place: [f64; 2],
    time_ms: u32,
}

impl<const SENSORS: usize> Round<SENSORS> {
    fn new(config: Config<SENSORS>, radius_mm: f64) -> Self {
        let state = State::new(Grid::rectangle(4, 4));
        Self {
            config,
            state,
            radius_mm,
            place: [0.0, 0.0],
            time_ms: 0,
        }
    }

    fn send(&mut self, event: Event<SENSORS>) -> Outputs<SENSORS> {
        handle(
            &self.config,
            &mut self.state,
            Millis::from_ms(self.time_ms),
            event,
        )
    }

    fn range(&self, sensor: usize) -> Range {
        let axis = self.config.robot.directions[sensor];
        let (ux, uy) = (
            f64::from(axis.x_q14) / 16_384.0,
            f64::from(axis.y_q14) / 16_384.0,
        );
        let along = self.place[0] * ux + self.place[1] * uy;
        let squared = self.place[0] * self.place[0] + self.place[1] * self.place[1];
        let to_wall = (along * along + self.radius_mm * self.radius_mm - squared)
            .max(0.0)
            .sqrt()
            - along;
        Range::from_mm((to_wall - f64::from(self.config.robot.face_radius_mm)).max(0.0) as u16)
    }

    /// One ring; the motion that comes of it is carried out as far as the wall allows.
    fn step(&mut self) -> Outputs<SENSORS> {
        self.time_ms += 640;
        let mut last = Outputs::NONE;
        for sensor in 0..SENSORS {
            let range = Some(self.range(sensor));
            last = self.send(Event::Echo {
                sensor: sensor as u8,
                range,
            });
        }
        if let Some(motion) = last.motion {
            let wanted = motion.displacement;
            let [x, y] = [
                self.place[0] + f64::from(wanted.dx_mm),
                self.place[1] + f64::from(wanted.dy_mm),
            ];
            let free = (x * x + y * y).sqrt()
                < self.radius_mm - f64::from(self.config.robot.body_radius_mm);
            let moved = if free { wanted } else { Displacement::ZERO };
            if free {
                self.place = [x, y];
            }
            let progress = if free {
                Progress::Ended
            } else {
                Progress::Touched
            };
            self.send(Event::Odometry {
                motion: motion.id,
                moved,
                turned: Bearing::ZERO,
                progress,
            });
        }
        last
    }

    fn explore_and_learn(&mut self) {
        self.send(Event::Command(Command::Explore { moves: 60, seed: 5 }));
        while !self.step().mode_changed {}
        self.send(Event::Command(Command::Learn));
        while !self.send(Event::Tick).mode_changed {}
        assert_eq!(self.state.mode(), &Mode::Idle);
        assert_eq!(self.state.memory().samples().len(), 60);
    }
}

#[test]
fn a_ring_of_24_leaves_the_wall() {
    let nomad = RobotSpec::nomad200();
    let robot = RobotSpec {
        directions: evenly_spaced(),
        symmetric: true,
        face_radius_mm: nomad.face_radius_mm,
        body_radius_mm: nomad.body_radius_mm,
        step_mm: nomad.step_mm,
        speed_mm_s: nomad.speed_mm_s,
        braking_mm_s2: nomad.braking_mm_s2,
        ring_period_ms: 960,
        steer_ms: 6_000,
        half_cone: nomad.half_cone,
    };
    let mut room = Round::<24>::new(Config::recommended().for_robot(robot), 3_000.0);
    room.explore_and_learn();
    let goal = Goal::nothing_within(Range::from_mm(700), room.config.encoding);
    for (place, sign) in [([2_400.0, 0.0], -1), ([-2_400.0, 0.0], 1)] {
        room.place = place;
        room.send(Event::Command(Command::Seek(goal)));
        let away = room
            .step()
            .motion
            .map(|motion| i32::from(motion.displacement.dx_mm) * sign);
        assert!(away.is_some_and(|mm| mm > 150), "{away:?}");
    }
}

#[test]
fn the_papers_miniature_robot_with_eight_sensors_runs() {
    let config = Config {
        encoding: Encoding {
            near_mm: 20,
            far_mm: 50,
        },
        clearance_mm: 50,
        shield: None,
        ..Config::recommended().for_robot(RobotSpec::miniature())
    };
    let mut room = Round::<8>::new(config, 100.0);
    room.explore_and_learn();
    let goal = Goal::nothing_within(Range::from_mm(50), room.config.encoding);
    room.send(Event::Command(Command::Seek(goal)));
    let decided = (0..50).filter(|_| room.step().decision.is_some()).count();
    assert_eq!(decided, 50);
}

/// Fig. 1a of the paper: a chain of 32 neurons over uniformly distributed points in space; each
/// comes to stand for about the same number of them, and neighbors in the chain for neighboring
/// places.
#[test]
fn a_chain_of_32_spreads_over_points_in_space() {
    const STEPS: u32 = 40_000;
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
    let mut point = || -> [Weight; 3] {
        core::array::from_fn(|_| Weight::from_bits((generator.next_u32() >> 19) as i16))
    };
    let mut map = Som::<32, 3>::new(Grid::chain(32), core::array::from_fn(|_| point()));
    let probes: Vec<_> = (0..2_000).map(|_| point()).collect();
    let before = map.quality(&probes).0;
    let rate = Schedule::from_q16(32_768, 1_311, Decay::Exponential);
    let radius = Schedule::from_q16(8 << 16, 32_768, Decay::Exponential);
    for step in 0..STEPS {
        let update = Update::from_q16(
            Neighborhood::Gaussian,
            rate.at(step, STEPS),
            radius.at(step, STEPS),
        );
        let probe = point();
        map.train_step(&probe, Mask::ALL, &update);
    }
    let (after, hits) = map.quality(&probes);
    assert!(after.topographic_error() < before.topographic_error() / 2.0);
    assert!(after.quantization_error() < before.quantization_error());
    // 62.5 points each on the average.
    assert!(
        hits.iter().all(|&hit| (20..=140).contains(&hit)),
        "{hits:?}"
    );
}
