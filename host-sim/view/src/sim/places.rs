//! The memory of places: where it leads the robot, and where it lies in the world.

use super::{Simulator, SimulatorActivity};
use crate::dto::xy;
use crate::snapshot::{PartMessage, PlacesDto, Rounded, SnapshotPart, Xy};
use crate::source::CommandRefused;
use amp::places::Aim;
use amp::units::Displacement;
use arena::world::{Point, Pose};
use sim::pilot::Pilot as _;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Where the frame of the robot's places lies in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaceFrame {
    /// Its origin and its x axis.
    pose: Pose,
    /// −1 for a robot that takes left for right.
    side: f64,
    /// It begins where random moves began. A robot that was carried does not know where that is.
    begins_at_home: bool,
    /// A robot that was carried knows with the next echo that it was: until then its places are
    /// those of before.
    is_current: bool,
}

impl PlaceFrame {
    /// A frame that begins here, for a robot that takes its front to be at `heading`, rad.
    pub(super) fn new(here: Pose, heading: f64, side: f64) -> Self {
        Self {
            pose: Pose::new(here.position, here.heading - side * heading),
            side,
            begins_at_home: false,
            is_current: false,
        }
    }

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

impl Simulator {
    /// Whether its places lead the robot to goals.
    pub(super) fn has_places(&self) -> bool {
        self.controller.inner().led_turret().is_some()
    }

    /// Places begin anew here, with random moves.
    pub(super) fn begin_places(&mut self) {
        self.frame = PlaceFrame {
            begins_at_home: true,
            is_current: true,
            ..self.frame_from_here()
        };
        self.set_down = None;
    }

    /// The robot was carried here.
    pub(super) fn carry_places(&mut self) {
        self.set_down = Some(self.frame_from_here());
        self.frame.is_current = false;
    }

    /// After an echo: if the robot was carried it knows by now.
    pub(super) fn settle_places(&mut self) {
        let was_current = std::mem::replace(&mut self.frame.is_current, true);
        let begins_anew = !was_current && self.aside().is_none();
        if let Some(frame) = self.set_down.filter(|_| begins_anew) {
            self.frame = PlaceFrame {
                is_current: true,
                ..frame
            };
            if let Err(CommandRefused(why)) = self.lead() {
                self.fail(why);
            }
        }
    }

    /// Where it perceived what is sought, and how strongly.
    fn remembered(&self) -> Vec<(Xy, Rounded)> {
        let Some(goal) = self.goal.sought() else {
            return Vec::new();
        };
        let remembered = self.controller.inner().remembered(goal);
        let remembered = remembered.into_iter();
        let placed = |(position, strength)| (xy(self.reached(position)), Rounded(strength));
        remembered.map(placed).collect()
    }

    fn frame_from_here(&self) -> PlaceFrame {
        let heading = self.heading_it_thinks();
        let robot = self.start.setup.robot.as_ref();
        let miswiring = robot.and_then(|robot| robot.miswiring());
        let side = miswiring.map_or(1.0, |wrong| wrong.side());
        PlaceFrame::new(self.body.pose(), heading, side)
    }

    /// Where the places lie that stand aside of the others, and the first of them, while the robot
    /// does not know where it was set down.
    fn aside(&self) -> Option<(PlaceFrame, Displacement, u16)> {
        let places = self.controller.inner().led_turret()?.places();
        let (began, first) = places.aside()?;
        let frame = self.set_down?;
        // It may have found out which way it faces.
        let heading = self.frame_from_here().pose.heading;
        let pose = Pose::new(frame.pose.position, heading);
        Some((PlaceFrame { pose, ..frame }, began, first))
    }

    /// Where the robot takes a position to be that it has reached, or can reach from there.
    fn reached(&self, position: Displacement) -> Point {
        match self.aside() {
            Some((frame, began, _)) => frame.to_world(position.minus(began)),
            None => self.frame.to_world(position),
        }
    }

    /// Where it takes what belongs to a place to be.
    fn placed(&self, place: u16, position: Displacement) -> Point {
        match self.aside() {
            Some((_, _, first)) if place < first => self.frame.to_world(position),
            _ => self.reached(position),
        }
    }

    /// Tells the robot where its places are to lead it. Without places it finds its way by the goal
    /// alone.
    pub(super) fn lead(&mut self) -> Result<(), CommandRefused> {
        let sought = self.goal.sought();
        let pilot = self.controller.pilot();
        let told = pilot.seek_sense(sought.filter(|_| !self.goal.is_touring()));
        told.map_err(|error| CommandRefused(error.to_string()))?;
        let aim = if self.goal.is_touring() {
            let aim = self.goal.tour_aim();
            let led = self.controller.pilot().lead_if_it_can(aim);
            return led.map_err(|error| error.to_string().into());
        } else if sought.is_some() {
            // What it senses leads it.
            self.sense();
            return Ok(());
        } else if let Some(place) = self.goal.position() {
            Aim::Position(self.frame.to_frame(place))
        } else if self.goal.is_nest() && self.frame.begins_at_home {
            Aim::Position(Displacement::ZERO)
        } else {
            Aim::Situation
        };
        let led = self.controller.pilot().lead_if_it_can(Some(aim));
        led.map_err(|error| error.to_string().into())
    }

    /// Where the goal is, if it is where the random moves began.
    pub(super) fn home(&self) -> Point {
        let nest = self.nest.map(|(_, place)| place);
        match self.goal.is_home() && self.frame.begins_at_home {
            true => self.frame.pose.position,
            false => nest.unwrap_or(self.body.pose().position),
        }
    }

    /// Bearing of the front in the robot's own frame, rad.
    fn heading_it_thinks(&self) -> f64 {
        let turret = self.controller.inner().led_turret();
        turret.map_or(0.0, |turret| {
            f64::from(turret.memory().heading().as_turns()) / 65_536.0 * TAU
        })
    }

    /// Where the robot thinks that it is, if it knows any place.
    pub(super) fn thinks(&self) -> Option<[Rounded; 3]> {
        let places = self.controller.inner().led_turret()?.places();
        if !self.frame.is_current || places.positions().len() == 0 {
            return None;
        }
        let here = self.reached(places.here());
        let heading = self.frame.pose.heading + self.frame.side * self.heading_it_thinks();
        Some([here.x, here.y, heading].map(Rounded))
    }

    /// The way that its places lead it, if they do: the next sub-goal comes first.
    pub(super) fn way(&mut self) -> Option<Vec<Xy>> {
        let stays = self.decision.is_some_and(|decision| decision.at_goal);
        let seeks = self.activity == SimulatorActivity::Seek && self.frame.is_current;
        let is_led = self.controller.pilot().cached_state().ok()?.is_led();
        if !seeks || stays || !is_led {
            return None;
        }
        let plan = self.controller.inner().led_turret()?.plan();
        Some(plan.map(|place| xy(self.reached(place))).collect())
    }

    /// The places as a part of the snapshot: the last one if nothing has changed.
    pub(super) fn places(&mut self, revision: u64) -> Option<Arc<dyn PartMessage>> {
        let places = self.places_dto()?;
        let kept = self.cache.places.take();
        let part = match kept.filter(|part| part.value == places) {
            Some(part) => part,
            None => Arc::new(SnapshotPart::new("places", 0, revision, places)),
        };
        self.cache.places = Some(Arc::clone(&part));
        Some(part)
    }

    fn places_dto(&self) -> Option<PlacesDto> {
        let places = self.controller.inner().led_turret()?.places();
        if !self.frame.is_current {
            return Some(PlacesDto::default());
        }
        let placed = |(place, position)| xy(self.placed(place, position));
        let ways = places.frontiers().map(|(place, end)| {
            let from = places.positions().nth(place.into()).unwrap_or(end);
            [(place, from), (place, end)].map(placed)
        });
        Some(PlacesDto {
            places: (0..).zip(places.positions()).map(placed).collect(),
            links: places.links().map(|(one, other)| [one, other]).collect(),
            blocked: places.blocked().map(|(one, other)| [one, other]).collect(),
            frontiers: ways.collect(),
            sensed: self.remembered(),
        })
    }
}
