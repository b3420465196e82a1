//! A goal of one's own, "something 400 mm from sensor 0", for a robot before a long wall.
use amp::config::Config;
use amp::controller::{Command, Event, Progress, State, handle};
use amp::goal::{Component, Goal};
use amp::som::Grid;
use amp::units::{Bearing, Millis, Range};

const WALL_MM: f64 = 2_000.0;

fn main() {
    // Sixteen sonars that keep their bearing: the Nomad 200 with its turret held.
    let config = Config::recommended();
    let mut state = State::<16, 16, 100>::new(Grid::rectangle(4, 4));
    // A situation's value is 0 for far and 1 for near: that of 400 mm, asked of sensor 0 alone.
    let mut components = [Component::ANY; 16];
    components[0] = Component::equal(config.encoding.value(Some(Range::from_mm(400))));
    let goal = Goal::place(components);

    let (mut x_mm, mut time_ms) = (0.0, 0);
    let mut send = |ms, event| {
        time_ms += ms;
        handle(&config, &mut state, Millis::from_ms(time_ms), event)
    };
    let range_mm = |x_mm: f64, sensor: usize| {
        let along = f64::from(config.robot.directions[sensor].x_q14) / 16_384.0;
        let to_wall = (WALL_MM - x_mm) / along - f64::from(config.robot.face_radius_mm);
        (along > 0.1).then_some(to_wall)
    };
    let (moves, seed) = (100, 1);
    let explore = Command::Explore { moves, seed };
    for (command, rings) in [
        (explore, 101),
        (Command::Learn, 0),
        (Command::Seek(goal), 60),
    ] {
        let _ = send(0, Event::Command(command));
        if command == Command::Learn {
            // It is carried back to where it began.
            x_mm = 0.0;
        }
        while command == Command::Learn && !send(1, Event::Tick).mode_changed {}
        for _ in 0..rings {
            let mut motion = None;
            for sensor in 0..16 {
                let range = range_mm(x_mm, sensor).map(|mm| Range::from_mm(mm as u16));
                let sensor = sensor as u8;
                motion = send(40, Event::Echo { sensor, range }).motion;
            }
            // Every motion is carried out as asked; sideways nothing changes.
            if let Some(motion) = motion {
                let moved = motion.displacement;
                x_mm += f64::from(moved.dx_mm);
                let _ = send(500, motion.report(moved, Bearing::ZERO, Progress::Ended));
            }
        }
    }
    let left_mm = range_mm(x_mm, 0).unwrap_or_default();
    println!("The wall is {left_mm:.0} mm from sensor 0.");
    assert!((200.0..500.0).contains(&left_mm));
}
