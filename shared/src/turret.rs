//! A virtual turret: whatever sensors a body has, the controller sees a ring that keeps its bearing
//! in the world.
//!
//! [`handle`] stands between the body and [`controller::handle`]. Echoes
//! and odometry come in the body's frame; the points they leave are read off as a ring of sectors.
//! Sectors that nobody has seen are masked out. Motions go out in the body's frame.
//!
//! A body that turns before it goes listens on the way: if something nearer than thought shows up
//! where it is about to go, it decides again. A guard ends motions short of any point.

use crate::config::Config;
use crate::controller::{self, Event, Mode, Motion, Outputs, Progress, State};
use crate::fixed::Mask;
use crate::points::{Beam, PointLimits, PointMemory};
use crate::units::{Bearing, Displacement, Millis, Range};
use serde::{Deserialize, Serialize};

/// Where a sensor stands on the body and looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Mount {
    /// Position: x ahead, y to the left of the body's center.
    pub position: Displacement,
    /// Direction, from the body's front.
    pub axis: Bearing,
}

/// A body with `BEAMS` sensors, at most 32.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BodySpec<const BEAMS: usize> {
    /// Its sensors.
    pub mounts: [Mount; BEAMS],
    /// Sensors that exist and are used.
    pub enabled: Mask,
    /// How long points last.
    pub points: PointLimits,
    /// How far a sensor that hears nothing sees free space, millimeters from its face; `None` = it
    /// tells nothing: the echo of a sonar may have gone astray on a smooth wall.
    pub silence_mm: Option<u16>,
    /// Distance that the guard keeps between body and points, millimeters; `None` = no guard.
    pub guard_mm: Option<u16>,
}

/// New decisions in a row before one is carried out whatever shows up.
const MAX_LOOKS: u8 = 3;
/// The body counts as turned towards its way within this angle: 7.5°.
const TURNED: u16 = 65_536_u32.div_ceil(48) as u16;
/// A motion is not shortened by less, millimeters.
const ROUNDING_MM: u16 = 3;

/// What the robot knows of its surroundings and its motion, in the frame of the start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VirtualTurret<const SECTORS: usize, const POINTS: usize> {
    memory: PointMemory<POINTS>,
    /// Sensors heard since the last motion ended, or since the last decision.
    fresh: Mask,
    /// The ring of the last decision.
    thought: [Option<Range>; SECTORS],
    motion: Option<MotionLeft>,
    /// New decisions in a row.
    looks: u8,
}

/// The motion under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct MotionLeft {
    id: u16,
    speed_mm_s: u16,
    /// Displacement still to go.
    left: Displacement,
    is_rolling: bool,
}

impl<const SECTORS: usize, const POINTS: usize> Default for VirtualTurret<SECTORS, POINTS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SECTORS: usize, const POINTS: usize> VirtualTurret<SECTORS, POINTS> {
    /// Nothing seen yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            memory: PointMemory::new(),
            fresh: Mask::NONE,
            thought: [None; SECTORS],
            motion: None,
            looks: 0,
        }
    }

    /// The points.
    #[must_use]
    pub const fn memory(&self) -> &PointMemory<POINTS> {
        &self.memory
    }

    /// The ring of the last decision.
    #[must_use]
    pub const fn ring(&self) -> &[Option<Range>; SECTORS] {
        &self.thought
    }

    /// Forgets what was seen: the robot may have been carried elsewhere.
    pub fn forget(&mut self) {
        self.memory.forget();
        self.fresh = Mask::NONE;
        self.thought = [None; SECTORS];
        self.motion = None;
        self.looks = 0;
    }

    /// Whether a sector within 75° of the way is near, and clearly nearer than thought.
    fn is_surprised(
        &self,
        limits: &PointLimits,
        way: Displacement,
        ring: &[Option<Range>; SECTORS],
    ) -> bool {
        const DEGREES_75: i32 = 65_536 * 75 / 360;
        let near_mm = limits.near_mm.saturating_add(limits.near_mm / 5);
        let nearer_mm = limits.beyond_mm / 3;
        let bearing = way.bearing();
        let mm = |range: Option<Range>| range.map_or(u16::MAX, Range::as_mm);
        let sectors = ring.iter().zip(&self.thought).enumerate();
        let mut ahead = sectors.filter(|(sector, _)| {
            let offset = Bearing::of_place(*sector, SECTORS).minus(bearing);
            i32::from(offset.as_signed_turns()).abs() < DEGREES_75
        });
        ahead.any(|(_, (now, thought))| {
            let now = mm(*now);
            now < near_mm && now < mm(*thought).saturating_sub(nearer_mm)
        })
    }

    /// Whether a robot that has just turned towards its way sees something that it did not know.
    /// Random moves are not reconsidered.
    fn must_decide_again(
        &self,
        limits: &PointLimits,
        mode: &Mode<SECTORS>,
        ring: &[Option<Range>; SECTORS],
    ) -> bool {
        let seeks = matches!(mode, Mode::Seek { .. });
        let motion = self.motion.filter(|motion| self.faces_way(motion));
        motion.is_some_and(|motion| {
            seeks && self.looks < MAX_LOOKS && self.is_surprised(limits, motion.left, ring)
        })
    }

    /// Whether the body faces its way and has not begun to roll.
    fn faces_way(&self, motion: &MotionLeft) -> bool {
        let offset = motion.left.bearing().minus(self.memory.heading());
        !motion.is_rolling && offset.as_signed_turns().unsigned_abs() <= TURNED
    }

    /// A motion in the body's frame, as far as the guard allows.
    fn send<const BEAMS: usize>(
        &mut self,
        body_radius_mm: u16,
        body: &BodySpec<BEAMS>,
        motion: Motion,
    ) -> Motion {
        let mut left = motion.displacement;
        if let Some(margin_mm) = body.guard_mm {
            let radius_mm = body_radius_mm.saturating_add(margin_mm);
            let free_mm = self.memory.free_mm(left, radius_mm);
            if free_mm < left.length_mm() {
                left = left.with_length(free_mm);
            }
        }
        self.motion = Some(MotionLeft {
            id: motion.id,
            speed_mm_s: motion.speed_mm_s,
            left,
            is_rolling: false,
        });
        self.in_body_frame(motion, left)
    }

    fn in_body_frame(&self, motion: Motion, left: Displacement) -> Motion {
        let back = self.memory.heading().direction().mirrored();
        Motion {
            displacement: left.rotated(back),
            ..motion
        }
    }

    /// What is left of the motion under way, in the body's frame, if the points ask for less than
    /// was ordered.
    fn shorten<const BEAMS: usize>(
        &mut self,
        body_radius_mm: u16,
        body: &BodySpec<BEAMS>,
    ) -> Option<Motion> {
        let margin_mm = body.guard_mm?;
        let under_way = self.motion?;
        let radius_mm = body_radius_mm.saturating_add(margin_mm);
        let free_mm = self.memory.free_mm(under_way.left, radius_mm);
        if under_way.left.length_mm().saturating_sub(free_mm) <= ROUNDING_MM {
            return None;
        }
        let left = under_way.left.with_length(free_mm);
        self.motion = Some(MotionLeft { left, ..under_way });
        let motion = Motion {
            id: under_way.id,
            displacement: left,
            speed_mm_s: under_way.speed_mm_s,
        };
        Some(self.in_body_frame(motion, left))
    }

    /// Takes a report of the base; returns the displacement in the frame of the start.
    fn moved(
        &mut self,
        limits: &PointLimits,
        moved: Displacement,
        turned: Bearing,
        progress: Progress,
    ) -> Displacement {
        let in_frame = moved.rotated(self.memory.heading().direction());
        self.memory.moved(limits, moved, turned);
        if let Some(motion) = &mut self.motion {
            motion.left = motion.left.minus(in_frame);
            motion.is_rolling |= progress == Progress::Moving;
        }
        in_frame
    }
}

/// Handles one event of a body whose sensors stand anywhere. `Event::Echo` counts the body's
/// sensors; displacements are in the body's frame: x ahead. The configuration should have no
/// shield and no fault detection: both assume a ring on the robot itself.
#[must_use]
pub fn handle<
    const SECTORS: usize,
    const NEURONS: usize,
    const SAMPLES: usize,
    const BEAMS: usize,
    const POINTS: usize,
>(
    config: &Config<SECTORS>,
    body: &BodySpec<BEAMS>,
    turret: &mut VirtualTurret<SECTORS, POINTS>,
    state: &mut State<SECTORS, NEURONS, SAMPLES>,
    at: Millis,
    event: Event<SECTORS>,
) -> Outputs<SECTORS> {
    match event {
        Event::Echo { sensor, range } => {
            let Some(mount) = body.mounts.get(usize::from(sensor)) else {
                return Outputs::NONE;
            };
            if !body.enabled.contains(sensor.into()) {
                return Outputs::NONE;
            }
            let seen = range.or(body.silence_mm.map(Range::from_mm));
            if let Some(seen) = seen {
                let beam = Beam {
                    mount: mount.position,
                    axis: mount.axis,
                    range: seen,
                    is_echo: range.is_some(),
                };
                turret.memory.hear(&body.points, &beam);
            }
            turret.fresh = turret.fresh.with(sensor.into());
            heard(config, body, turret, state, at)
        }
        Event::Odometry {
            motion,
            moved,
            turned,
            progress,
        } => {
            let moved = turret.moved(&body.points, moved, turned, progress);
            let event = Event::Odometry {
                motion,
                moved,
                turned: Bearing::ZERO,
                progress,
            };
            let was_moving = state.is_moving();
            let outputs = controller::handle(config, state, at, event);
            if was_moving && !state.is_moving() {
                turret.motion = None;
                turret.fresh = Mask::NONE;
            }
            outputs
        }
        Event::Command(_) | Event::Tick | Event::Alarm(_) | Event::Touched => {
            controller::handle(config, state, at, event)
        }
    }
}

/// Something was heard: under way the guard looks at it, at rest a complete ring is a decision.
fn heard<
    const SECTORS: usize,
    const NEURONS: usize,
    const SAMPLES: usize,
    const BEAMS: usize,
    const POINTS: usize,
>(
    config: &Config<SECTORS>,
    body: &BodySpec<BEAMS>,
    turret: &mut VirtualTurret<SECTORS, POINTS>,
    state: &mut State<SECTORS, NEURONS, SAMPLES>,
    at: Millis,
) -> Outputs<SECTORS> {
    let is_heard = |beam: usize| !body.enabled.contains(beam) || turret.fresh.contains(beam);
    let is_complete = (0..BEAMS).all(is_heard);
    if !state.is_moving() {
        if !is_complete {
            return Outputs::NONE;
        }
        turret.looks = 0;
        return decide(config, body, turret, state, at);
    }
    if is_complete {
        turret.fresh = Mask::NONE;
        let (ring, _) = turret.memory.ring(&body.points);
        if turret.must_decide_again(&body.points, state.mode(), &ring) {
            turret.looks = turret.looks.saturating_add(1);
            state.abandon_motion(at);
            return decide(config, body, turret, state, at);
        }
        // The controller stops a robot whose ring falls silent during a motion.
        for sector in state.enabled(config).indices(SECTORS) {
            let range = ring.get(sector).copied().flatten();
            let sensor = sector as u8;
            let _ = controller::handle(config, state, at, Event::Echo { sensor, range });
        }
    }
    Outputs {
        motion: turret.shorten(config.robot.body_radius_mm, body),
        ..Outputs::NONE
    }
}

/// Gives the controller the ring of sectors; its motion goes out in the body's frame.
fn decide<
    const SECTORS: usize,
    const NEURONS: usize,
    const SAMPLES: usize,
    const BEAMS: usize,
    const POINTS: usize,
>(
    config: &Config<SECTORS>,
    body: &BodySpec<BEAMS>,
    turret: &mut VirtualTurret<SECTORS, POINTS>,
    state: &mut State<SECTORS, NEURONS, SAMPLES>,
    at: Millis,
) -> Outputs<SECTORS> {
    let (ring, known) = turret.memory.ring(&body.points);
    turret.thought = ring;
    turret.fresh = Mask::NONE;
    state.set_visible(known);
    let mut outputs = Outputs::NONE;
    for (sector, range) in ring.into_iter().enumerate() {
        if known.contains(sector) {
            let sensor = sector as u8;
            outputs = controller::handle(config, state, at, Event::Echo { sensor, range });
        }
    }
    if let Some(motion) = outputs.motion {
        outputs.motion = Some(turret.send(config.robot.body_radius_mm, body, motion));
    }
    outputs
}

#[cfg(test)]
mod tests;
