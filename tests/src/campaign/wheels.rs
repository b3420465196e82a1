//! The base of the campaigns: the simulated Nomad 200, which executes motions with times to live.

use amp::units::Displacement;
use amp::wire::message::{HostMessage, MotionCommand};
use amp::{controller::Progress, units::Bearing};
use arena::noise::Noise;
use arena::robot::{Base, BaseLimits, BaseMotion, TurretMode};
use arena::world::{Point, World};

/// Time between two updates of the motors, ms.
const STRIDE_MS: u64 = 10;

/// Longer than any motion here, m.
const FAR_M: f64 = 100.0;

/// The base, in the middle of an empty room.
pub(super) struct Wheels<'a> {
    world: &'a World,
    base: Base,
    noise: Noise,
    command: Option<MotionCommand>,
    /// End of the motion unless it is renewed, ms.
    until_ms: u64,
    /// The motion has not ended.
    under_way: bool,
    reported: Point,
    way_m: f64,
}

impl<'a> Wheels<'a> {
    pub(super) fn new(world: &'a World, seed: u64) -> Self {
        // Exact odometry: no link can limit the slip of wheels.
        let limits = BaseLimits {
            slip: 0.0,
            ..BaseLimits::default()
        };
        let base = Base::new(world.start(), limits, TurretMode::Held);
        Self {
            world,
            reported: base.odometry(),
            base,
            noise: Noise::new(seed),
            command: None,
            until_ms: 0,
            under_way: false,
            way_m: 0.0,
        }
    }

    /// Executes a motion: a new one, a shortened one, or the same again, which renews its time to
    /// live.
    pub(super) fn execute(&mut self, command: MotionCommand, now_ms: u64) {
        self.until_ms = now_ms + u64::from(command.ttl_ms);
        let mark = |command: MotionCommand| (command.id, command.revision);
        if self.command.map(mark) == Some(mark(command)) {
            return;
        }
        self.command = Some(command);
        self.set_off(command, 1e-3);
        self.under_way = true;
    }

    /// Extends the present motion without end: only a stop or its time to live ends it.
    pub(super) fn extend_without_end(&mut self) {
        if let Some(command) = self.command.filter(|_| self.is_ordered()) {
            let length_mm = f64::from(command.motion().displacement.length_mm());
            self.set_off(command, FAR_M / length_mm.max(1.0));
        }
    }

    /// Starts a motion, with `scale` meters per millimeter of the command.
    fn set_off(&mut self, command: MotionCommand, scale: f64) {
        self.command(BaseMotion {
            dx_m: f64::from(command.dx_mm) * scale,
            dy_m: f64::from(command.dy_mm) * scale,
            speed_m_s: f64::from(command.speed_mm_s) / 1e3,
        });
    }

    fn command(&mut self, motion: BaseMotion) {
        self.base.command(motion, &mut self.noise);
    }

    /// Advances by one millisecond.
    pub(super) fn advance_1_ms(&mut self, now_ms: u64) {
        if self.under_way && now_ms >= self.until_ms {
            self.command(BaseMotion::default());
            self.under_way = false;
        }
        if now_ms.is_multiple_of(STRIDE_MS) {
            let done = self.base.advance(STRIDE_MS as f64 / 1e3, self.world);
            self.way_m += done.traveled_m;
        }
    }

    /// Whether it has a motion that has neither ended nor expired.
    pub(super) fn is_ordered(&self) -> bool {
        let moves = |command: MotionCommand| (command.dx_mm, command.dy_mm) != (0, 0);
        self.under_way && self.command.is_some_and(moves) && self.base.is_moving()
    }

    /// Whether the wheels turn or roll.
    pub(super) fn is_moving(&self) -> bool {
        self.base.is_moving()
    }

    /// Distance rolled so far, mm.
    pub(super) fn way_mm(&self) -> f64 {
        self.way_m * 1e3
    }

    /// Its motion since the last report.
    pub(super) fn report(&mut self, at_ms: u32) -> HostMessage<16> {
        let way = (self.base.odometry() - self.reported) * 1e3;
        let moved = Displacement::saturating(libm::rint(way.x) as i32, libm::rint(way.y) as i32);
        let [dx, dy] = [moved.dx_mm, moved.dy_mm].map(f64::from);
        self.reported = self.reported + Point::new(dx, dy) * 1e-3;
        let progress = match (self.base.is_moving(), self.base.is_steering()) {
            (true, true) => Progress::Steering,
            (true, false) => Progress::Moving,
            (false, _) => Progress::Ended,
        };
        self.under_way &= progress != Progress::Ended;
        HostMessage::Odometry {
            at_ms,
            motion: self.command.map_or(0, |order| order.id),
            dx_mm: moved.dx_mm,
            dy_mm: moved.dy_mm,
            turned: Bearing::ZERO.as_turns(),
            progress,
        }
    }
}
