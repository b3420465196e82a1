//! The ring of Polaroid sonars: geometry, firing order and readings.
//!
//! There are three models ([`SonarModel`]), each with its parameters ([`SonarConfig`]): *ideal* is
//! exact, *nomad* is a ring without faults, *harsh* has every disturbance. A reading is a range in
//! meters, or `None` if the ring reports 255 in: no echo within that range.

use crate::caster::{ConeShape, LobeView, SonarLobe};
use crate::direction::CachedDirection;
use crate::noise::Noise;
use crate::robot_model::{SensorKind, SensorMount};
use crate::world::{LastWorld, Point, Pose, World};

mod config;
mod disturbance;
mod fault;
mod geometry;
mod hearing;
mod inches;
mod light;

pub use config::{SonarConfig, SonarModel};
use fault::ActiveFaults;
pub use fault::{FaultKind, TransducerFault};
pub use geometry::RingGeometry;
pub(crate) use hearing::Hearing;
use inches::whole_inches;
pub use inches::{M_PER_INCH, MAX_READING_IN, reading_in};
use light::Light;

pub use crate::nomad::FACE_RADIUS_M;

/// The Nomad drivers' firing order: front first, then from side to side (CARMEN, MissionLab).
pub const FIRING_ORDER: [usize; 16] = [0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8];

/// Time from one firing to the next, s: an echo from 255 in takes 37.7 ms, and the Nomad counts in
/// units of 4 ms.
pub const FIRING_SLOT_S: f64 = 0.040;

/// Time in which all 16 transducers fire once, s.
pub const RING_PERIOD_S: f64 = 0.640;

/// Speed of sound at 20 °C, m/s.
pub const SOUND_M_S: f64 = 343.2;

/// An earlier ping that may still reverberate.
#[derive(Debug, Clone, Copy)]
struct EarlierPing {
    time_s: f64,
    echo_m: f64,
}

/// First echo of a transducer.
#[derive(Debug, Clone, Copy, Default)]
struct FirstEcho {
    /// Pose of the robot and the transducer at this echo; `None` = not valid in the current world.
    from: Option<(Pose, Transducer)>,
    range_m: Option<f64>,
}

/// Position and axis of a transducer, relative to the turret's center and heading.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Transducer {
    face: Point,
    axis: Point,
    /// The noise of a sensor that measures by light; `None` = a sonar.
    light: Option<Light>,
}

/// Transducers on a turret or a body.
#[derive(Debug, Clone)]
pub struct Ring {
    transducers: Vec<Transducer>,
    /// Distance of all faces from the center along their axes, m; `None` for other positions.
    face_radius_m: Option<f64>,
    config: SonarConfig,
    model: SonarModel,
    cone: ConeShape,
    /// Surfaces in the lobe of each transducer.
    lobes: Vec<LobeView>,
    hearing: Hearing,
    /// The smallest reading, in.
    min_in: f64,
    world: LastWorld,
    heading: CachedDirection,
    /// Last echo of each transducer.
    echoes: Vec<FirstEcho>,
    dead: Option<usize>,
    faults: ActiveFaults,
    earlier: Option<EarlierPing>,
}

impl Ring {
    /// A Nomad ring of a predefined model. `noise` selects the dead transducer, if there is one.
    #[must_use]
    pub fn new(model: SonarModel, noise: &mut Noise) -> Self {
        Self::with_config(model, RingGeometry::default(), model.config(), noise)
    }

    /// A ring with its own geometry and parameters. Readings are exact for [`SonarModel::Ideal`],
    /// otherwise simulated. Parameters outside their range are clamped.
    #[must_use]
    pub fn with_config(
        model: SonarModel,
        geometry: RingGeometry,
        config: SonarConfig,
        noise: &mut Noise,
    ) -> Self {
        let geometry = RingGeometry {
            count: geometry.count.max(1),
            ..geometry
        };
        let bearings = (0..geometry.count).map(|sensor| geometry.bearing(sensor));
        let transducers = bearings.map(|bearing| {
            let axis = Point::unit(bearing);
            Transducer {
                face: axis * geometry.face_radius_m,
                axis,
                light: None,
            }
        });
        let ring = Self::of_transducers(transducers.collect(), model, config, noise);
        Self {
            face_radius_m: Some(geometry.face_radius_m),
            ..ring
        }
    }

    /// Sensors of any kind anywhere on a body.
    #[must_use]
    pub fn with_mounts(
        model: SonarModel,
        mounts: &[SensorMount],
        config: SonarConfig,
        noise: &mut Noise,
    ) -> Self {
        let transducers = mounts.iter().map(|mount| Transducer {
            face: mount.position,
            axis: Point::unit(mount.bearing_rad),
            light: match mount.kind {
                SensorKind::Sonar => None,
                SensorKind::Infrared => Some(Light::INFRARED),
                SensorKind::Laser => Some(Light::LASER),
            },
        });
        Self::of_transducers(transducers.collect(), model, config, noise)
    }

    fn of_transducers(
        transducers: Vec<Transducer>,
        model: SonarModel,
        config: SonarConfig,
        noise: &mut Noise,
    ) -> Self {
        let count = transducers.len();
        let half_angle = config.half_angle_rad.clamp(1e-3, 1.5);
        Self {
            face_radius_m: None,
            cone: ConeShape::new(half_angle),
            lobes: vec![LobeView::default(); count],
            hearing: Hearing::new(&config, half_angle),
            min_in: whole_inches(config.min_range_m),
            world: LastWorld::default(),
            heading: CachedDirection::new(0.0),
            echoes: vec![FirstEcho::default(); count],
            dead: config.one_dead.then(|| noise.index(count)),
            faults: ActiveFaults::default(),
            earlier: None,
            transducers,
            config,
            model,
        }
    }

    /// The same ring with these faults.
    #[must_use]
    pub fn with_faults(mut self, faults: &[TransducerFault]) -> Self {
        self.faults = ActiveFaults::new(faults);
        self
    }

    /// Parameters of the model.
    #[must_use]
    pub fn config(&self) -> &SonarConfig {
        &self.config
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> SonarModel {
        self.model
    }

    /// The dead transducer, if there is one.
    #[must_use]
    pub fn dead(&self) -> Option<usize> {
        self.dead
    }

    /// The exact ranges of all transducers at once at `time_s`, m, for any model, changed by the
    /// faults.
    pub fn scan_with_faults(
        &mut self,
        world: &World,
        pose: &Pose,
        time_s: f64,
        out: &mut [Option<f64>; 16],
        noise: &mut Noise,
    ) {
        self.faults.set_time(time_s);
        self.scan(world, pose, out);
        let heading = self.heading_vector(pose.heading);
        for (sensor, range) in out.iter_mut().enumerate() {
            let turned = self.faults.turn_of(sensor);
            if let Some(transducer) = turned.and_then(|_| self.transducer(sensor)) {
                *range = self.exact_range(world, pose, &transducer, heading);
            }
        }
        let exact = *out;
        for (sensor, range) in out.iter_mut().enumerate() {
            let fired = self.faults.wired_to(sensor);
            let exact = exact.get(fired).copied().flatten();
            *range = self.faults.reported(sensor, exact, noise);
        }
    }

    /// The exact ranges of all transducers at once, m, for any model: `out[i]` is that of
    /// transducer i. `None` beyond the maximum range.
    pub fn scan(&mut self, world: &World, pose: &Pose, out: &mut [Option<f64>]) {
        let reach = self.config.max_range_m;
        let heading = self.heading_vector(pose.heading);
        let Some(face_radius_m) = self.face_radius_m else {
            for (transducer, out) in self.transducers.iter().zip(out) {
                *out = self.exact_range(world, pose, transducer, heading);
            }
            return;
        };
        let view = world.view(pose.position, face_radius_m, reach);
        for (transducer, out) in self.transducers.iter().zip(out) {
            let range = view.nearest_in_cone(transducer.axis.turned(heading), self.cone);
            *out = (range <= reach).then_some(range);
        }
    }

    /// A transducer as it sits now.
    fn transducer(&self, sensor: usize) -> Option<Transducer> {
        let transducer = *self.transducers.get(sensor)?;
        let turn = self.faults.turn_of(sensor).map(Point::unit);
        Some(turn.map_or(transducer, |turn| Transducer {
            face: transducer.face.turned(turn),
            axis: transducer.axis.turned(turn),
            ..transducer
        }))
    }

    fn exact_range(
        &self,
        world: &World,
        pose: &Pose,
        transducer: &Transducer,
        heading: Point,
    ) -> Option<f64> {
        let axis = transducer.axis.turned(heading);
        let reach = self.config.max_range_m;
        let range = match self.face_radius_m {
            Some(radius) => {
                let view = world.view(pose.position, radius, reach);
                view.nearest_in_cone(axis, self.cone)
            }
            None => {
                let face = pose.position + transducer.face.turned(heading);
                world
                    .view(face, 0.0, reach)
                    .nearest_in_cone(axis, self.cone)
            }
        };
        (range <= reach).then_some(range)
    }

    /// Fires one transducer at `time_s` with the robot at `pose`. `None` for a `sensor` that does
    /// not exist.
    pub fn ping(
        &mut self,
        world: &World,
        pose: &Pose,
        sensor: usize,
        time_s: f64,
        noise: &mut Noise,
    ) -> Option<f64> {
        self.faults.set_time(time_s);
        let fired = self.faults.wired_to(sensor);
        let reading = self.reading(world, pose, fired, time_s, noise);
        self.faults.reported(sensor, reading, noise)
    }

    /// The reading of a transducer without faults.
    fn reading(
        &mut self,
        world: &World,
        pose: &Pose,
        sensor: usize,
        time_s: f64,
        noise: &mut Noise,
    ) -> Option<f64> {
        let transducer = self.transducer(sensor)?;
        let heading = self.heading_vector(pose.heading);
        match transducer.light {
            _ if self.model == SonarModel::Ideal => {
                self.exact_range(world, pose, &transducer, heading)
            }
            Some(_) if self.dead == Some(sensor) => None,
            Some(light) => {
                let exact = self.exact_range(world, pose, &transducer, heading);
                light.reading(exact, &self.config, noise)
            }
            None => {
                let echo = self.echo(world, pose, sensor, transducer);
                self.disturbed(echo, sensor, time_s, noise)
            }
        }
    }

    /// The reading of a sonar for its first echo.
    fn disturbed(
        &mut self,
        echo: Option<f64>,
        sensor: usize,
        time_s: f64,
        noise: &mut Noise,
    ) -> Option<f64> {
        let echo_or_crosstalk = self.with_crosstalk(echo, time_s, noise);
        if self.dead == Some(sensor) {
            return None;
        }
        self.earlier = echo
            .map(|echo_m| EarlierPing { time_s, echo_m })
            .or(self.earlier);
        self.with_noise(echo_or_crosstalk, noise)
    }

    /// The first echo of a transducer. Reuses the last one if neither robot nor world moved.
    fn echo(
        &mut self,
        world: &World,
        pose: &Pose,
        sensor: usize,
        transducer: Transducer,
    ) -> Option<f64> {
        if !self.world.is_same(world) {
            self.echoes.iter_mut().for_each(|echo| echo.from = None);
        }
        let last = self.echoes.get(sensor)?;
        if last.from == Some((*pose, transducer)) {
            return last.range_m;
        }
        let heading = self.heading_vector(pose.heading);
        let axis = transducer.axis.turned(heading);
        let face = match self.face_radius_m {
            Some(radius) => axis * radius,
            None => transducer.face.turned(heading),
        };
        let lobe = SonarLobe {
            tip: pose.position + face,
            axis,
            cone: self.cone,
            reach_m: self.config.max_range_m,
        };
        let view = self.lobes.get_mut(sensor)?;
        world.aim(view, &lobe);
        let range_m = self.hearing.first_echo(world, view, &self.config);
        if let Some(echo) = self.echoes.get_mut(sensor) {
            *echo = FirstEcho {
                from: Some((*pose, transducer)),
                range_m,
            };
        }
        range_m
    }

    /// The unit vector along a heading in rad; computed only if the heading changed.
    fn heading_vector(&mut self, heading: f64) -> Point {
        self.heading.set(heading);
        self.heading.unit()
    }
}

#[cfg(test)]
mod tests;
