//! Where a robot's places lie in the world.

use super::dto::xy;
use super::known_places::PlacesDto;
use super::snapshot::{Rounded, Xy};
use amp::places::BELIEVED;
use amp::units::Displacement;
use arena::world::{Point, Pose};
use sim::turret_pilot::SimTurret;
use std::f64::consts::TAU;

/// Where the frame of the robot's places lies in the world.
#[derive(Debug, Clone, Copy)]
struct PlaceFrame {
    /// Its origin and its x axis.
    pose: Pose,
    /// −1 for a robot that takes left for right.
    side: f64,
}

impl PlaceFrame {
    fn to_world(self, position: Displacement) -> Point {
        let [x, y] = [position.dx_mm, position.dy_mm].map(|mm| f64::from(mm) / 1e3);
        let way = Point::new(x, self.side * y);
        self.pose.position + way.turned(Point::unit(self.pose.heading))
    }

    /// Places farther than 32 m are not in the frame.
    fn to_frame(self, place: Point) -> Displacement {
        let way = (place - self.pose.position).turned_back(Point::unit(self.pose.heading));
        let mm = |m: f64| libm::round(m * 1e3) as i32;
        Displacement::saturating(mm(way.x), mm(self.side * way.y))
    }
}

/// The frame of the places, and that of a robot that was set down elsewhere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaceFrames {
    frame: PlaceFrame,
    /// Where the robot was set down, and its places began anew or stand aside.
    set_down: Option<PlaceFrame>,
    /// The frame begins where random moves began. A robot that was carried does not know where
    /// that is.
    begins_at_home: bool,
    /// A robot that was carried knows with the next echo that it was: until then its places are
    /// those of before.
    is_current: bool,
}

impl PlaceFrames {
    /// Of a robot that has no places yet; `side` is −1 if it takes left for right.
    pub fn new(pose: Pose, side: f64) -> Self {
        Self {
            frame: PlaceFrame { pose, side },
            set_down: None,
            begins_at_home: false,
            is_current: false,
        }
    }

    /// Places begin anew with random moves of a robot that takes its front to be at `heading`, rad,
    /// in its own frame.
    pub fn begin(&mut self, pose: Pose, heading: f64) {
        *self = Self {
            frame: self.frame_here(pose, heading),
            set_down: None,
            begins_at_home: true,
            is_current: true,
        };
    }

    /// The robot was carried, it is not known yet where to.
    pub fn lose(&mut self) {
        self.is_current = false;
    }

    /// The robot was carried here.
    pub fn carry(&mut self, pose: Pose, heading: f64) {
        self.set_down = Some(self.frame_here(pose, heading));
        self.lose();
    }

    /// After an echo: if the robot was carried it knows by now. Returns whether its places begin
    /// anew where it was set down.
    pub fn settle(&mut self, turret: &SimTurret) -> bool {
        let was_current = std::mem::replace(&mut self.is_current, true);
        let begins_anew = !was_current && turret.places().aside().is_none();
        match self.set_down.filter(|_| begins_anew) {
            Some(frame) => (self.frame, self.begins_at_home) = (frame, false),
            None => return false,
        }
        true
    }

    /// Whether the places are those of where the robot is now.
    pub fn is_current(&self) -> bool {
        self.is_current
    }

    /// Where the random moves began, if the frame begins there.
    pub fn home(&self) -> Option<Point> {
        self.begins_at_home.then_some(self.frame.pose.position)
    }

    /// A place of the world in the frame.
    pub fn to_frame(self, place: Point) -> Displacement {
        self.frame.to_frame(place)
    }

    fn frame_here(&self, pose: Pose, heading: f64) -> PlaceFrame {
        let side = self.frame.side;
        let pose = Pose::new(pose.position, pose.heading - side * heading);
        PlaceFrame { pose, side }
    }

    /// The places of a robot that is in this pose, and then takes its front to be at `heading`,
    /// rad, in its own frame.
    pub fn seen<'p>(&'p self, turret: &'p SimTurret, pose: Pose, heading: f64) -> SeenPlaces<'p> {
        let front = self.frame_here(pose, heading).pose.heading;
        SeenPlaces {
            frames: self,
            turret,
            front,
        }
    }
}

/// Bearing of the front in the robot's own frame, rad.
pub(crate) fn heading(turret: &SimTurret) -> f64 {
    f64::from(turret.memory().heading().as_turns()) / 65_536.0 * TAU
}

/// The places of a robot, in the world.
#[derive(Clone, Copy)]
pub(crate) struct SeenPlaces<'p> {
    frames: &'p PlaceFrames,
    turret: &'p SimTurret,
    /// Heading of its own frame in the world, as it knows it by now, rad.
    front: f64,
}

impl SeenPlaces<'_> {
    /// Where the places lie that stand aside of the others, and the first of them, while the robot
    /// does not know where it was set down.
    fn aside(&self) -> Option<(PlaceFrame, Displacement, u16)> {
        let (began, first) = self.turret.places().aside()?;
        let frame = self.frames.set_down?;
        // It may have found out which way it faces.
        let pose = Pose::new(frame.pose.position, self.front);
        Some((PlaceFrame { pose, ..frame }, began, first))
    }

    /// Where the robot takes a position to be that it has reached, or can reach from there.
    pub fn reached(&self, position: Displacement) -> Point {
        match self.aside() {
            Some((frame, began, _)) => frame.to_world(position.minus(began)),
            None => self.frames.frame.to_world(position),
        }
    }

    /// Where it takes what belongs to a place to be.
    fn placed(&self, place: u16, position: Displacement) -> Point {
        match self.aside() {
            Some((_, _, first)) if place < first => self.frames.frame.to_world(position),
            _ => self.reached(position),
        }
    }

    /// Where the robot thinks that it is, if it knows any place.
    pub fn thinks(&self) -> Option<[Rounded; 3]> {
        let places = self.turret.places();
        if !self.frames.is_current || places.positions().len() == 0 {
            return None;
        }
        let here = self.reached(places.here());
        let PlaceFrame { pose, side } = self.frames.frame;
        let heading = pose.heading + side * heading(self.turret);
        Some([here.x, here.y, heading].map(Rounded))
    }

    /// The way on which its places lead it: the next sub-goal comes first.
    pub fn way(&self) -> Vec<Xy> {
        let plan = self.turret.plan();
        plan.map(|place| xy(self.reached(place))).collect()
    }

    /// Where it may be, and how much speaks for that.
    fn guesses(&self) -> impl Iterator<Item = (Xy, Rounded)> {
        self.turret.places().guesses().map(|(position, score)| {
            let place = self.frames.frame.to_world(position);
            let strength = (f64::from(score) / f64::from(BELIEVED)).clamp(0.0, 1.0);
            (xy(place), Rounded(strength))
        })
    }

    /// All that the page shows; `remembered` is where it perceived what is sought in another
    /// modality, and how strongly.
    pub fn dto(&self, remembered: &[(Displacement, f64)]) -> PlacesDto {
        let places = self.turret.places();
        if !self.frames.is_current {
            return PlacesDto::default();
        }
        let placed = |(place, position)| xy(self.placed(place, position));
        let ways = places.frontiers().map(|(place, end)| {
            let from = places.positions().nth(place.into()).unwrap_or(end);
            [(place, from), (place, end)].map(placed)
        });
        let sensed = remembered.iter();
        let sensed =
            sensed.map(|(position, strength)| (xy(self.reached(*position)), Rounded(*strength)));
        PlacesDto {
            places: (0..).zip(places.positions()).map(placed).collect(),
            links: places.links().map(|(one, other)| [one, other]).collect(),
            blocked: places.blocked().map(|(one, other)| [one, other]).collect(),
            frontiers: ways.collect(),
            sensed: sensed.collect(),
            guesses: self.guesses().collect(),
        }
    }
}
