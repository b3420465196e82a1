//! Sensors anywhere on a body: told where they look, or finding it by random moves.

use super::Body;
use crate::calibration::{Babble, BabbleLimits, Geometry, Solver};
use crate::config::Config;
#[cfg(feature = "store")]
use crate::config::MAX_CONFIG;
#[cfg(feature = "store")]
use crate::controller::TransferError;
use crate::controller::{
    Command, CommandRefusal, Event, Mode, Outputs, Progress, State, handle, refused, stale,
};
use crate::fixed::Mask;
use crate::places::Aim;
#[cfg(feature = "store")]
use crate::places::Places;
use crate::turret::{self, BodySpec, VirtualTurret};
use crate::units::Millis;

/// Moves until a sensor that was moved is looked for.
const MOVES_TO_FIND: u8 = 60;

/// A body with at most `BEAMS` sensors. The controller sees a ring of `SECTORS`, read off at most
/// `POINTS` points of echoes. `Event::Echo` counts the sensors; displacements are in the body's
/// frame, x ahead. Until it is told of its sensors it is a ring on a held turret.
///
/// [`Command::Calibrate`] finds where the sensors look: random moves ([`Mode::Babble`]), then ticks
/// that think ([`Mode::Calibrate`]). The random moves that follow for the maps teach that as well:
/// [`Command::Learn`] begins with it.
#[derive(Debug, Clone, PartialEq)]
pub struct MountedSensors<
    const SECTORS: usize,
    const BEAMS: usize,
    const POINTS: usize,
    const RECORDS: usize,
> {
    /// As it was told.
    told: BodySpec<BEAMS>,
    /// As it is known now.
    known: BodySpec<BEAMS>,
    turret: VirtualTurret<SECTORS, POINTS, RECORDS>,
    babble: Babble<BEAMS>,
    solver: Solver<BEAMS>,
    /// Told to calibrate, it is also to find what the base makes of its commands.
    learns_actuation: bool,
    /// It was told to calibrate, and has not learned maps since.
    listens: bool,
    /// Moves since a sensor was heard of which it is not known where it looks.
    moves_unknown: u8,
}

impl<const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    MountedSensors<SECTORS, BEAMS, POINTS, RECORDS>
{
    /// Nothing has been [told](Self::tell): a ring on a held turret.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            told: BodySpec::NONE,
            known: BodySpec::NONE,
            turret: VirtualTurret::new(),
            babble: Babble::new(),
            solver: Solver::new(),
            learns_actuation: false,
            listens: false,
            moves_unknown: 0,
        }
    }

    /// Tells what the body of a robot that stands is; what was found of another one is forgotten.
    /// Its places, if it has any, lead it to situations.
    pub fn tell(&mut self, body: &BodySpec<BEAMS>) {
        self.told.clone_from(body);
        self.known.clone_from(body);
        self.turret.restart();
        self.turret.trust_heading(body.has_compass);
        self.turret.lead_to(Some(Aim::Situation));
        self.solver.stop();
        self.babble.begin(0, 0);
        (self.listens, self.moves_unknown) = (false, 0);
    }

    /// The body as it is known.
    #[must_use]
    pub const fn known(&self) -> &BodySpec<BEAMS> {
        &self.known
    }

    /// The points, and the ring read off them.
    #[must_use]
    pub const fn turret(&self) -> &VirtualTurret<SECTORS, POINTS, RECORDS> {
        &self.turret
    }

    /// Whether it works out where sensors look: each tick is a step of that.
    #[must_use]
    pub fn is_solving(&self) -> bool {
        self.solver.is_busy()
    }

    /// The body as the random moves so far show it, at once: for pictures, too long for a tick.
    #[must_use]
    pub fn sketch(&self) -> BodySpec<BEAMS> {
        let found = Solver::solve(self.babble.calibration(), self.learns_actuation);
        self.told.with(&found)
    }

    fn calibrate<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        state: &mut State<SECTORS, NEURONS, SAMPLES>,
        at: Millis,
        (moves, seed, actuators): (u16, u64, bool),
    ) -> Outputs<SECTORS> {
        if moves == 0 {
            return refused(CommandRefusal::InvalidMoveCount { max: u16::MAX });
        }
        self.known.clone_from(&self.told);
        self.turret.restart();
        self.babble.begin(moves, seed);
        self.learns_actuation = actuators;
        self.listens = true;
        state.begin_babble(at, moves)
    }

    /// An event during the body's own random moves.
    fn babble<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        config: &Config<SECTORS>,
        state: &mut State<SECTORS, NEURONS, SAMPLES>,
        at: Millis,
        event: Event<SECTORS>,
    ) -> Outputs<SECTORS> {
        let was_moving = state.is_moving();
        let mut outputs = Outputs::NONE;
        match event {
            Event::Echo { sensor, range } => {
                if let Some(age_ms) = state.stale_ms(config, at) {
                    return stale(age_ms);
                }
                let limits = self.babble_limits(config);
                let next = self.babble.hear(&limits, sensor.into(), range, was_moving);
                let left = self.babble.moves_left();
                outputs.motion = next.map(|next| state.babble(config, at, next, left));
                if !was_moving && next.is_none() && self.babble.is_over(&limits) {
                    self.begin_to_solve();
                    return state.begin_calibration(at);
                }
            }
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => {
                self.babble.moved(moved, turned);
                if matches!(progress, Progress::Ended | Progress::Touched) {
                    state.end_babble(at, motion);
                }
            }
            Event::Command(_) | Event::Tick | Event::Alarm(_) | Event::Touched => {
                outputs = handle(config, state, at, event);
            }
        }
        if was_moving && !state.is_moving() {
            self.babble.move_ended();
        }
        outputs
    }

    fn babble_limits(&self, config: &Config<SECTORS>) -> BabbleLimits {
        let robot = &config.robot;
        let face_to_hull_mm = robot.body_radius_mm.saturating_sub(robot.face_radius_mm);
        BabbleLimits {
            enabled: self.told.enabled,
            longest_mm: robot.step_mm,
            margin_mm: face_to_hull_mm.saturating_add(self.told.babble_margin_mm),
            learns_actuation: self.learns_actuation,
        }
    }

    fn begin_to_solve(&mut self) {
        self.solver
            .begin(self.babble.calibration(), self.learns_actuation);
    }

    /// A step of the solution. With the last one it knows whether sensors were found; without any
    /// the body stays as it was known.
    fn solve(&mut self) -> Option<bool> {
        let seeks_some = self.solver.seeks_some();
        let found = self.solver.advance(self.babble.calibration())?;
        let body = if seeks_some {
            self.known.clone().with_more(&found.bearings)
        } else {
            self.told.with(&found)
        };
        let has_sensors = body.enabled != Mask::NONE;
        if has_sensors {
            self.known = body;
        }
        Some(has_sensors)
    }

    /// What all moves tell of the sensors.
    fn listen(&mut self, event: &Event<SECTORS>) {
        match *event {
            Event::Echo { sensor, .. } if !self.told.enabled.contains(sensor.into()) => {}
            Event::Echo { sensor, range } if self.listens => {
                let known = self.known.known_bearings();
                self.babble
                    .watch(sensor.into(), range, Geometry::Rough(&known));
            }
            // One that does not see far is silent nearly everywhere: that tells nothing of it.
            Event::Echo { range: None, .. } if self.told.silence_mm.is_some() => {}
            Event::Echo { sensor, range } => {
                let known = self.known.known_bearings();
                let range = range.map(|range| self.known.as_on_ring(sensor.into(), range));
                self.babble
                    .watch(sensor.into(), range, Geometry::Known(&known));
            }
            Event::Odometry { moved, turned, .. } => self.babble.moved(moved, turned),
            Event::Command(_) | Event::Tick | Event::Alarm(_) | Event::Touched => {}
        }
    }

    /// The event with its range as the other sensors would have read it.
    fn corrected(&self, event: Event<SECTORS>) -> Event<SECTORS> {
        let Event::Echo { sensor, range } = event else {
            return event;
        };
        let calibration = self.babble.calibration();
        Event::Echo {
            sensor,
            range: range.map(|range| calibration.corrected(sensor.into(), range)),
        }
    }

    /// A sensor that no longer fits is not used until it has been found where it looks now.
    fn check_sensors(&mut self) {
        let calibration = self.babble.calibration();
        if let Some(sensor) = calibration.misfit(self.known.enabled) {
            self.known.enabled = self.known.enabled.without(sensor);
            self.babble.forget(sensor);
            self.moves_unknown = 0;
        }
        let unused = self.told.enabled.and(self.known.enabled.complement());
        let heard = self.babble.calibration().alive().and(unused);
        if heard == Mask::NONE || self.solver.is_busy() {
            self.moves_unknown = 0;
            return;
        }
        self.moves_unknown += 1;
        if self.moves_unknown >= MOVES_TO_FIND {
            self.moves_unknown = 0;
            let known = self.known.known_bearings();
            self.solver.begin_with(self.babble.calibration(), &known);
        }
    }
}

impl<const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize> Default
    for MountedSensors<SECTORS, BEAMS, POINTS, RECORDS>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    Body<SECTORS> for MountedSensors<SECTORS, BEAMS, POINTS, RECORDS>
{
    const NEW: Self = Self::new();
    #[cfg(feature = "store")]
    const MAX_BYTES: usize = MAX_CONFIG;
    #[cfg(feature = "store")]
    const MAX_PLACES_BYTES: usize = Places::<SECTORS, RECORDS>::MAX_BYTES;
    #[cfg(feature = "store")]
    const PLACE_BYTES: usize = Places::<SECTORS, RECORDS>::ITEM_BYTES;

    fn handle<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        config: &Config<SECTORS>,
        state: &mut State<SECTORS, NEURONS, SAMPLES>,
        at: Millis,
        event: Event<SECTORS>,
    ) -> Outputs<SECTORS> {
        if self.told.enabled == Mask::NONE {
            return handle(config, state, at, event);
        }
        if let Event::Command(Command::Calibrate {
            moves,
            seed,
            actuators,
        }) = event
        {
            return self.calibrate(state, at, (moves, seed, actuators));
        }
        match (state.mode(), event) {
            (Mode::Babble { .. }, _) => return self.babble(config, state, at, event),
            (Mode::Calibrate, Event::Tick) => {
                let found = self.solve();
                return found.map_or(Outputs::NONE, |has_sensors| {
                    state.end_calibration(at, has_sensors)
                });
            }
            (Mode::Learn { .. }, Event::Tick) if self.solver.is_busy() => {
                self.solve();
                return Outputs::NONE;
            }
            _ => {}
        }
        if event == Event::Tick {
            self.solve();
        }
        self.listen(&event);
        let event = self.corrected(event);
        let was_moving = state.is_moving();
        let outputs = turret::handle(config, &self.known, &mut self.turret, state, at, event);
        if was_moving && !state.is_moving() && !self.listens {
            self.check_sensors();
        }
        let learns = matches!(event, Event::Command(Command::Learn));
        if self.listens && learns && outputs.refusal.is_none() {
            self.begin_to_solve();
            self.listens = false;
        }
        outputs
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> bool {
        self.turret.lead_to(aim);
        RECORDS > 0
    }

    fn set_down(&mut self) -> bool {
        let has_places = RECORDS > 0;
        if has_places {
            self.turret.set_down();
        }
        has_places
    }

    fn is_thinking(&self) -> bool {
        self.turret.is_thinking()
    }

    fn think<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        config: &Config<SECTORS>,
        state: &mut State<SECTORS, NEURONS, SAMPLES>,
        at: Millis,
    ) -> Outputs<SECTORS> {
        let was_moving = state.is_moving();
        let outputs = turret::think(config, &self.known, &mut self.turret, state, at);
        if was_moving && !state.is_moving() && !self.listens {
            self.check_sensors();
        }
        outputs
    }

    #[cfg(feature = "store")]
    fn to_bytes<'a>(&self, buffer: &'a mut [u8; MAX_CONFIG]) -> &'a [u8] {
        if self.known == BodySpec::NONE {
            return &[];
        }
        self.known.to_bytes(buffer)
    }

    #[cfg(feature = "store")]
    fn replace(&mut self, bytes: &[u8]) -> bool {
        let body = if bytes.is_empty() {
            Some(BodySpec::NONE)
        } else {
            BodySpec::from_bytes(bytes)
        };
        if let Some(body) = &body {
            self.tell(body);
        }
        body.is_some()
    }

    #[cfg(feature = "store")]
    fn places_len(&self) -> usize {
        self.turret.places().saved_len()
    }

    #[cfg(feature = "store")]
    fn read_places(&self, offset: usize, out: &mut [u8]) -> usize {
        self.turret.places().read_saved(offset, out)
    }

    #[cfg(feature = "store")]
    fn write_places(&mut self, offset: usize, bytes: &[u8]) -> Result<(), TransferError> {
        self.turret.write_places(offset, bytes)
    }
}

#[cfg(test)]
mod tests;
