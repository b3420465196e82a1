//! A device with a memory of places, on the page.

use super::places::{places, saved, start};
use super::*;
use sim::turret_pilot::SimBody;

/// A simulator of a P3-DX in the office whose controller is in this process or in a device.
fn simulator(behavior: &Behavior, is_remote: bool) -> Simulator {
    let start = start(SonarModel::Nomad, behavior.clone());
    let place = if is_remote {
        let device = InProcessNode::<16, SimBody>::of_body(start.setup.config.clone());
        ControllerPlace::Link(Box::new(Session::new(device)), "a device".to_owned())
    } else {
        ControllerPlace::Host
    };
    Simulator::new(start, place, None).unwrap()
}

/// All that is shown but the maps, which are read from a device only now and then.
fn shown(simulator: &mut Simulator) -> serde_json::Value {
    let places = places(simulator);
    let mut now = serde_json::to_value(simulator.snapshot().now).unwrap();
    for of_the_maps in ["plan", "link"] {
        now[of_the_maps].take();
    }
    serde_json::json!({"places": places, "now": now})
}

/// The same robot with both.
struct Pair {
    both: [Simulator; 2],
    /// Decisions in which places led it.
    led: u32,
}

impl Pair {
    fn execute(&mut self, command: &PageCommand) {
        for simulator in &mut self.both {
            simulator.execute(command).unwrap();
        }
    }

    fn seek(&mut self, name: &str, tour: u32, decisions: usize) {
        self.execute(&PageCommand::Behavior {
            name: name.to_owned(),
            tour: Some(tour),
        });
        self.execute(&PageCommand::Seek);
        self.drive(decisions);
    }

    fn drive(&mut self, decisions: usize) {
        for _ in 0..decisions {
            let [here, there] = self.both.each_mut().map(|simulator| {
                decide(simulator, 1);
                shown(simulator)
            });
            assert_eq!(here["now"], there["now"]);
            assert_eq!(here["places"], there["places"]);
            self.led += u32::from(there["now"]["way"].is_array());
        }
    }
}

/// It is sent home, to a position and to a scent, is carried, and starts anew.
#[test]
fn a_device_is_led_and_shown_as_the_controller_in_this_process() {
    let home = Behavior::Home { tour: Tour::of(30) };
    let both = [false, true].map(|is_remote| simulator(&home, is_remote));
    let mut pair = Pair { both, led: 0 };
    pair.both.iter_mut().for_each(educate);
    assert!(pair.both.iter().all(|one| one.abilities().places));
    pair.seek("home", 30, 35);
    pair.execute(&PageCommand::GoalPosition { x: 1.0, y: 1.0 });
    pair.drive(5);
    pair.seek("scent:strongest", 20, 25);
    pair.execute(&PageCommand::Stop);
    // What the host perceived for the device is saved as well.
    let senses = pair.both.each_mut().map(|simulator| {
        let file = saved(simulator);
        let (_, senses) = file.rsplit_once("414d504d").unwrap();
        senses.to_owned()
    });
    assert_eq!(senses[0], senses[1]);
    assert!(senses[0].len() > 500, "{}", senses[0].len());
    pair.execute(&PageCommand::MoveRobot { x: 1.0, y: 0.5 });
    pair.seek("nest", 0, 10);
    assert!(pair.led > 50, "led {} times", pair.led);
    pair.execute(&PageCommand::Reset(Reset::default()));
    pair.both.iter_mut().for_each(educate);
    pair.seek("home", 10, 5);
}
