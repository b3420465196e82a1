//! The last phase of an episode: one behaviour, or several one after the other.

use super::drive::{Driver, Failure, Setup};
use super::tally::Tally;
use crate::pilot::Pilot;
use crate::scenes::{Behavior, CHAIN_HOLDS};
use crate::world::Point;
use amp::config::Config;
use amp::controller::{Command, Event};
use amp::scan::Situation;

/// Carrying the robot takes so long that its shield has forgotten what it heard before, s.
const CARRIED_S: f64 = 601.0;

impl Driver<'_> {
    /// Sets the scene of a behaviour: the robot elsewhere, a leader ahead of it.
    pub(super) fn set_scene(&mut self, behavior: &Behavior) {
        let nest = match behavior {
            Behavior::Seek(captured) => captured.place_mm.map(place),
            _ => None,
        };
        let nest = nest.unwrap_or(self.world.start().position);
        if behavior.is_set_down_elsewhere() {
            self.body.wait(CARRIED_S);
            self.body.set_down_elsewhere(nest);
        }
        if behavior.has_leader() {
            self.body.add_leader();
        }
        self.measure_from(nest);
    }

    /// Pursues the behaviour's goals for `setup.steps` decisions in all.
    pub(super) fn pursue(
        &mut self,
        pilot: &mut impl Pilot,
        setup: &Setup,
        nest: &Situation<16>,
        mut progress: impl FnMut(u32),
    ) -> Result<(), Failure> {
        let parts = setup.behavior.parts();
        for (index, part) in parts.iter().enumerate() {
            self.behavior = part.clone();
            tell(self, pilot, part, &setup.config, nest)?;
            let begun = self.tally.clone();
            let last = index + 1 == parts.len();
            // One decision at a time only where a next part waits.
            while !is_reached(part, &begun, &self.tally) || (last && parts.len() == 1) {
                let until = if parts.len() == 1 {
                    setup.steps
                } else {
                    (self.tally.steps + 1).min(setup.steps)
                };
                self.drive(pilot, until, &mut progress)?;
                if self.tally.steps >= setup.steps {
                    break;
                }
            }
            if !is_reached(part, &begun, &self.tally) {
                break;
            }
            self.measure.reached += u32::from(!matches!(part, Behavior::Nest) || self.measure.at_nest());
        }
        Ok(())
    }
}

fn tell(
    driver: &Driver<'_>,
    pilot: &mut impl Pilot,
    part: &Behavior,
    config: &Config<16>,
    nest: &Situation<16>,
) -> Result<(), Failure> {
    let command = Command::Seek(part.goal(config, nest));
    let outputs = pilot.handle(driver.body.now(), Event::Command(command));
    outputs
        .refusal
        .map_or(Ok(()), |refusal| Err(Failure::Refused(refusal)))
}

/// A place is reached when its goal holds; a way when its goal has held for a while.
fn is_reached(part: &Behavior, begun: &Tally, now: &Tally) -> bool {
    let held = now.goal_steps.saturating_sub(begun.goal_steps);
    match part {
        Behavior::Nest | Behavior::Seek(_) => held > 0,
        Behavior::WallLeft | Behavior::WallRight => {
            now.steps.saturating_sub(begun.steps) >= CHAIN_HOLDS * 5
        }
        _ => held >= CHAIN_HOLDS,
    }
}

fn place(millimeters: [i32; 2]) -> Point {
    let [x, y] = millimeters.map(|mm| f64::from(mm) / 1e3);
    Point::new(x, y)
}
