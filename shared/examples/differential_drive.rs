//! Two wheels and eight sensors on the body: a Khepera in a round arena learns to avoid the wall.
use amp::config::Config;
use amp::controller::{Command, Event, Progress, State, handle};
use amp::goal::Goal;
use amp::robot::RobotSpec;
use amp::units::{Bearing, Displacement, Millis, Range};
use std::f64::consts::TAU;
const ARENA_MM: f64 = 300.0;

fn main() {
    let mut config = Config::recommended().for_robot(RobotSpec::miniature());
    (config.encoding.far_mm, config.clearance_mm, config.shield) = (200, 60, None);
    let mut state = State::<8, 16, 100>::new(amp::som::Grid::rectangle(4, 4));
    let ([mut x, mut y, mut heading], mut time_ms) = ([0.0_f64; 3], 0);
    let mut send = |ms, event| {
        time_ms += ms;
        handle(&config, &mut state, Millis::from_ms(time_ms), event)
    };
    let (moves, seed) = (100, 1);
    let explore = Command::Explore { moves, seed };
    let seek = Command::Seek(Goal::avoiding(&config));
    for (command, rings) in [(explore, 101), (Command::Learn, 0), (seek, 500)] {
        let _ = send(0, Event::Command(command));
        // A tick is a bounded piece of learning. Send ticks at other times, too, every few
        // milliseconds: they end what is overdue, such as a motion that is never reported.
        while command == Command::Learn && !send(1, Event::Tick).mode_changed {}
        let (mut touches, mut way_mm) = (0, 0.0);
        for _ in 0..rings {
            let mut motion = None;
            for (sensor, axis) in config.robot.directions.into_iter().enumerate() {
                let angle = heading + f64::from(axis.y_q14).atan2(axis.x_q14.into());
                let along = x * angle.cos() + y * angle.sin();
                let wall = (ARENA_MM.powi(2) - x * x - y * y + along * along).sqrt() - along;
                let (sensor, range) = (sensor as u8, Some(Range::from_mm((wall - 27.0) as u16)));
                motion = send(5, Event::Echo { sensor, range }).motion;
            }
            let Some(motion) = motion else { continue };
            // A motion is a straight displacement in the body's present frame. These wheels turn
            // the body first, then roll; `moved` is in the frame before the turn.
            let Displacement { dx_mm, dy_mm } = motion.displacement;
            let turn = f64::from(dy_mm).atan2(dx_mm.into());
            let length = f64::from(motion.displacement.length_mm());
            heading += turn;
            let ahead = [x + length * heading.cos(), y + length * heading.sin()];
            let is_free = ahead[0].hypot(ahead[1]) < ARENA_MM - 28.0;
            let (moved, progress) = match is_free {
                true => (motion.displacement, Progress::Ended),
                false => (Displacement::ZERO, Progress::Touched),
            };
            if is_free {
                ([x, y], way_mm) = (ahead, way_mm + length);
            }
            touches += u32::from(!is_free);
            let turned = Bearing::from_turns((turn / TAU * 65_536.0) as i32 as u16);
            let _ = send(500, motion.report(moved, turned, progress));
        }
        println!("{way_mm:.0} mm, {touches} of {rings} moves touched the wall");
        assert!(touches * 100 <= rings); // A blind robot touches in 20 of 500 moves.
    }
}
