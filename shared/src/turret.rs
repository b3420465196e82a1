//! A virtual turret: whatever sensors a body has, the controller sees a ring that keeps its bearing
//! in the world.
//!
//! [`handle`] stands between the body and [`controller::handle`](crate::controller::handle). Echoes
//! and odometry come in the body's frame; the points they leave are read off as a ring of sectors.
//! Sectors that nobody has seen are masked out. Motions go out in the body's frame.
//!
//! A body that turns before it goes listens on the way: if something nearer than thought shows up
//! where it is about to go, it decides again. A body with few sensors looks around before it
//! decides. A guard ends motions short of what was heard.

use crate::actuation::{Actuation, Odometer};
use crate::config::Config;
use crate::controller::{Event, Motion, Outputs, Progress, stale};
use crate::fixed::Mask;
use crate::places::{Aim, Leg, Places};
use crate::points::{Beam, PointMemory};
use crate::units::{Bearing, Displacement, Millis, Range};

mod body_spec;
mod glance;
mod guard;
mod lead;
mod replan;
mod ring_controller;

pub use body_spec::{BodySpec, Guard, Mount};
use guard::Hull;
pub use ring_controller::RingController;

/// As far as this a sonar that hears nothing would have heard what another one heard.
const SILENT: Range = Range::from_mm(6_000);

/// What the robot knows of its surroundings and its motion, in the frame of the start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VirtualTurret<const SECTORS: usize, const POINTS: usize, const RECORDS: usize> {
    memory: PointMemory<POINTS>,
    places: Places<SECTORS, RECORDS>,
    /// Where it is to be led while it pursues a goal, if it is; zeros at first.
    aim: Aim,
    is_led: bool,
    odometer: Odometer,
    /// Sensors heard since the last motion ended, or since the last decision.
    fresh: Mask,
    /// All sensors were heard while the base rolled.
    heard_all: bool,
    /// When a sensor was heard last.
    heard_at: Millis,
    /// It was carried since.
    was_set_down: bool,
    /// The ring of the last decision.
    last_ring: [Option<Range>; SECTORS],
    /// Its sectors that are known.
    known: Mask,
    /// What is left of the motion under way, in the frame of the start.
    motion: Option<Motion>,
    /// Where that motion was to go at first, in the same frame.
    course: Bearing,
    /// Whether it has begun to roll.
    is_rolling: bool,
    /// New decisions in a row.
    replans: u8,
    /// Since when it has been looking around.
    glance_since: Option<Millis>,
    /// Turns made of the look around in an unknown place.
    first_looks: u8,
    /// That look is over.
    knows_place: bool,
    /// Glances since the last decision.
    glances: u8,
    /// The controller's last motion.
    last_motion_id: u16,
    hull: Hull,
    /// Decisions in a row for which the guard allowed none.
    closed: u8,
}

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize> Default
    for VirtualTurret<SECTORS, POINTS, RECORDS>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// Nothing seen yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            memory: PointMemory::new(),
            places: Places::new(),
            aim: Aim::Position(Displacement::ZERO),
            is_led: false,
            odometer: Odometer::NEW,
            fresh: Mask::NONE,
            heard_all: false,
            heard_at: Millis::from_ms(0),
            was_set_down: false,
            last_ring: [None; SECTORS],
            known: Mask::NONE,
            motion: None,
            course: Bearing::ZERO,
            is_rolling: false,
            replans: 0,
            glance_since: None,
            first_looks: 0,
            knows_place: false,
            glances: 0,
            last_motion_id: 0,
            hull: Hull::NEW,
            closed: 0,
        }
    }

    /// Nothing seen, in place: the points are too many for the stack of a microcontroller.
    pub fn restart(&mut self) {
        self.memory.restart();
        self.places.forget();
        self.odometer = Odometer::NEW;
        (self.fresh, self.heard_at) = (Mask::NONE, Millis::from_ms(0));
        (self.was_set_down, self.heard_all) = (false, false);
        (self.last_ring, self.known) = ([None; SECTORS], Mask::NONE);
        (self.motion, self.course) = (None, Bearing::ZERO);
        (self.is_rolling, self.replans, self.knows_place) = (false, 0, false);
        (self.glance_since, self.glances, self.first_looks) = (None, 0, 0);
        (self.last_motion_id, self.hull, self.closed) = (0, Hull::NEW, 0);
    }

    /// The points.
    #[must_use]
    pub const fn memory(&self) -> &PointMemory<POINTS> {
        &self.memory
    }

    /// The ring of the last decision.
    #[must_use]
    pub const fn ring(&self) -> &[Option<Range>; SECTORS] {
        &self.last_ring
    }
}

/// Handles one event of a body whose sensors stand anywhere. `Event::Echo` counts the body's
/// sensors; displacements are in the body's frame: x ahead. The configuration should have no
/// shield and no fault detection: both assume a ring on the robot itself.
#[must_use]
pub fn handle<
    const SECTORS: usize,
    const BEAMS: usize,
    const POINTS: usize,
    const RECORDS: usize,
>(
    config: &Config<SECTORS>,
    body: &BodySpec<BEAMS>,
    turret: &mut VirtualTurret<SECTORS, POINTS, RECORDS>,
    controller: &mut impl RingController<SECTORS>,
    at: Millis,
    event: Event<SECTORS>,
) -> Outputs<SECTORS> {
    let mut robot = Robot {
        config,
        body,
        turret,
        controller,
        at,
    };
    let was_moving = robot.controller.is_moving();
    let outputs = match event {
        Event::Echo { sensor, range } => robot.echo(sensor, range),
        Event::Odometry {
            motion,
            moved,
            turned,
            progress,
        } => {
            let moved = robot.moved(moved, turned, progress);
            robot.glanced(progress);
            robot.control(Event::Odometry {
                motion,
                moved,
                turned: Bearing::ZERO,
                progress,
            })
        }
        Event::Command(command) => robot.command(command),
        Event::Tick | Event::Alarm(_) | Event::Touched => robot.control(event),
    };
    robot.settle(was_moving, &outputs);
    outputs
}

/// A slice of the thinking that a decision takes, to be called between events while the turret
/// [`is_thinking`](VirtualTurret::is_thinking). The decision comes with the last slice. A robot
/// that is stopped, commanded or alarmed thinks no more.
#[must_use]
pub fn think<
    const SECTORS: usize,
    const BEAMS: usize,
    const POINTS: usize,
    const RECORDS: usize,
>(
    config: &Config<SECTORS>,
    body: &BodySpec<BEAMS>,
    turret: &mut VirtualTurret<SECTORS, POINTS, RECORDS>,
    controller: &mut impl RingController<SECTORS>,
    at: Millis,
) -> Outputs<SECTORS> {
    if !turret.is_thinking() {
        return Outputs::NONE;
    }
    let mut robot = Robot {
        config,
        body,
        turret,
        controller,
        at,
    };
    let was_moving = robot.controller.is_moving();
    let outputs = robot.think();
    robot.settle(was_moving, &outputs);
    outputs
}

/// All that an event concerns.
struct Robot<
    'a,
    C,
    const SECTORS: usize,
    const BEAMS: usize,
    const POINTS: usize,
    const RECORDS: usize,
> {
    config: &'a Config<SECTORS>,
    body: &'a BodySpec<BEAMS>,
    turret: &'a mut VirtualTurret<SECTORS, POINTS, RECORDS>,
    controller: &'a mut C,
    at: Millis,
}

impl<C, const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    Robot<'_, C, SECTORS, BEAMS, POINTS, RECORDS>
where
    C: RingController<SECTORS>,
{
    fn control(&mut self, event: Event<SECTORS>) -> Outputs<SECTORS> {
        self.controller.handle_ring(self.config, self.at, event)
    }

    /// After an event: a motion is over, or a mode in which it was to decide.
    fn settle(&mut self, was_moving: bool, outputs: &Outputs<SECTORS>) {
        let has_stopped = was_moving && !self.controller.is_moving();
        if has_stopped {
            self.turret.motion = None;
            self.turret.fresh = self.turret.heard_on_way(outputs);
        }
        if has_stopped || outputs.mode_changed {
            self.turret.places.stop_thinking();
        }
    }

    /// A sensor was heard: under way the guard looks at it, at rest a complete ring is a decision.
    fn echo(&mut self, sensor: u8, range: Option<Range>) -> Outputs<SECTORS> {
        let Some(mount) = self.body.mounts.get(usize::from(sensor)) else {
            return Outputs::NONE;
        };
        if let Some(age_ms) = self.controller.stale_ms(self.config, self.at) {
            return stale(age_ms);
        }
        if !self.body.enabled.contains(sensor.into()) {
            return Outputs::NONE;
        }
        self.remember(*mount, range);
        self.turret.fresh = self.turret.fresh.with(sensor.into());
        let fresh = self.turret.fresh;
        let is_complete = self.body.enabled.indices(BEAMS).all(|s| fresh.contains(s));
        match (self.controller.is_moving(), is_complete) {
            (false, false) => Outputs::NONE,
            (false, true) if self.turret.is_thinking() => Outputs::NONE,
            (false, true) if self.turret.is_glancing(self.at, self.config.robot.steer_ms) => {
                self.turret.fresh = Mask::NONE;
                Outputs::NONE
            }
            (false, true) => self.look_and_decide(),
            (true, false) => self.shorten(),
            (true, true) => self.ring_under_way(),
        }
    }

    /// Adds what a sensor heard to the points.
    fn remember(&mut self, mount: Mount, range: Option<Range>) {
        self.turret.hear_at(self.at);
        let seen = range.or(self.body.silence());
        let beam = Beam {
            mount: mount.position,
            axis: mount.axis,
            range: seen.unwrap_or(SILENT),
            is_echo: range.is_some(),
        };
        let ray = self.turret.memory.ray(&beam);
        if seen.is_some() {
            self.hear_near(&ray, &beam);
            (self.turret.memory).hear_along(&self.body.points, &ray, beam.is_echo);
        } else if self.looks_for_position() {
            self.hear_nothing(&ray);
        }
    }

    /// A decision of a robot that stands, or a look around before it.
    fn look_and_decide(&mut self) -> Outputs<SECTORS> {
        if let Some(motion) = self.glance() {
            return Outputs {
                motion: Some(motion),
                ..Outputs::NONE
            };
        }
        self.turret.replans = 0;
        self.decide()
    }

    /// Reads off the ring to decide on. With a memory of places the robot thinks first; on its way
    /// it still heeds its guard.
    fn decide(&mut self) -> Outputs<SECTORS> {
        let (ring, mut known) = self.turret.memory.ring(&self.body.points);
        // Where nothing is heard it is open: who waited for an echo would wait for ever.
        if known == Mask::NONE {
            known = Mask::ALL;
        }
        (self.turret.last_ring, self.turret.known) = (ring, known);
        self.turret.fresh = Mask::NONE;
        // A robot without places has no code for them.
        if RECORDS == 0 {
            return self.decide_on(None);
        }
        self.begin_to_think();
        self.shorten()
    }

    /// Gives the controller the ring of sectors; its motion goes out in the body's frame.
    fn decide_on(&mut self, leg: Option<Leg>) -> Outputs<SECTORS> {
        if self.controller.is_moving() {
            self.controller.abandon_motion(self.at);
        }
        let (ring, known) = (self.turret.last_ring, self.turret.known);
        (self.turret.fresh, self.turret.heard_all) = (Mask::NONE, false);
        self.controller.set_visible(known);
        self.controller.lead(leg);
        let mut outputs = Outputs::NONE;
        for (sector, range) in ring.into_iter().enumerate() {
            if known.contains(sector) {
                let sensor = sector as u8;
                outputs = self.control(Event::Echo { sensor, range });
            }
        }
        if let Some(wanted) = outputs.motion {
            if let Some(glance) = self.glance_along(wanted.displacement.bearing()) {
                outputs.motion = Some(glance);
                return outputs;
            }
            self.turret.glances = 0;
            let motion = Motion {
                displacement: self.guarded_or_detour(wanted.displacement),
                ..wanted
            };
            self.turret.motion = Some(motion);
            self.turret.course = motion.displacement.bearing();
            self.turret.last_motion_id = motion.id;
            self.turret.is_rolling = false;
            outputs.motion = Some(self.turret.to_base(&self.body.actuation, motion));
        }
        outputs
    }

    /// Takes a report of the base; returns the displacement in the frame of the start.
    fn moved(&mut self, moved: Displacement, turned: Bearing, progress: Progress) -> Displacement {
        let turret = &mut *self.turret;
        let (moved, turned) = turret.odometer.correct(&self.body.actuation, moved, turned);
        let in_frame = moved.rotated(turret.memory.heading().direction());
        turret.memory.moved(&self.body.points, moved, turned);
        turret.places.moved(in_frame);
        if progress == Progress::Touched {
            turret.touched();
        }
        if let Some(motion) = &mut turret.motion {
            motion.displacement = motion.displacement.minus(in_frame);
            turret.is_rolling |= progress == Progress::Moving;
        }
        in_frame
    }
}

#[cfg(test)]
pub(crate) mod tests;
