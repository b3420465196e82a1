//! What the ring hears limits how far and how fast the robot may go.
//!
//! An echo says: the nearest surface within the transducer's lobe lies somewhere on an arc around its face. The shield
//! keeps some arcs of every transducer, moves them along as the robot moves (odometry), and lets a displacement end
//! where the body would come within a margin of the part of any arc that lies most in the way. A direction that no echo
//! covers is closed. The speed is such that the robot can stop within the distance left, at the given deceleration.
//!
//! An arc does not expire. Each of its points stays until newer echoes [contradict](cone) it: they come from farther away
//! through a cone that contains the point. Silence in another direction, or from a turned ring, contradicts nothing: a
//! corner may have left the lobe for the gap beside it.
//!
//! Arcs keep the bearing that the ring had at the start. Only new echoes and ways are rotated, so errors of rotation do not
//! add up.
//!
//! What it cannot know: a thing thinner than the gap between two lobes. At the Nomad's faces the gap is 9 cm wide; the
//! corner of a box can stand 4.5 cm inside it, which the margin covers.

use crate::config::Config;
use crate::fixed::{Mask, isqrt};
use crate::scan::Echo;
use crate::units::{Bearing, Direction, Displacement, Millis, Range};
use cone::{CONTRADICTIONS, Cone};
use glance::Glance;
use serde::{Deserialize, Serialize};

mod cone;
mod glance;

/// Places per transducer whose echo is kept.
pub const KEPT: usize = 4;

/// How careful to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shielding {
    /// Distance to keep between body and anything heard, millimetres.
    pub margin_mm: u16,
    /// Half the opening of a transducer's lobe.
    pub half_lobe: Bearing,
    /// Arcs kept per transducer, 1 … [`KEPT`]. The newest replaces the farthest.
    pub places: u8,
    /// Echoes whose faces were less than this apart, with the same axis, come through one cone, millimeters: the newer
    /// replaces the older or contradicts all of it. Small, as a near corner leaves the lobe within a few centimeters.
    pub spacing_mm: u16,
    /// A direction is open only while the transducers that look there have been heard within this time,
    /// milliseconds.
    pub fresh_ms: u32,
    /// A transducer that was silent for longer than this may have been carried elsewhere: its arcs are dropped when it
    /// is heard again, milliseconds. While it is heard, arcs do not expire.
    pub forget_ms: u32,
    /// Displacements that would be shorter than this are not begun, millimetres.
    pub least_mm: u16,
    /// The shortest range the ring can report, millimetres: a reading this short may be anything nearer, and counts
    /// as 0.
    pub least_range_mm: u16,
    /// Highest speed of things that may come towards the robot, millimetres per second: every echo loses this much range
    /// per second of its age.
    pub approach_mm_s: u16,
}

impl Shielding {
    /// For the Nomad's ring: lobes of ±15°, at least 6 in, a margin of 90 mm.
    #[must_use]
    pub const fn nomad200() -> Self {
        Self {
            margin_mm: 90,
            half_lobe: Bearing::from_turns(2_731),
            places: 4,
            spacing_mm: 2,
            fresh_ms: 2_000,
            forget_ms: 600_000,
            least_mm: 10,
            least_range_mm: 153,
            approach_mm_s: 0,
        }
    }
}

/// Points of an arc that are tested, evenly spaced from end to end: 5° of 30°. Where the lobes of two neighbors leave a gap
/// wider than the margin covers, a point lies in it.
const POINTS: usize = 7;

/// What a transducer heard at one place, in the shield's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Arc {
    /// Where it looked.
    axis: Direction,
    /// Range heard; `None` = no arc.
    range: Option<Range>,
    /// Contradictions of each point, two bits each.
    contradictions: u16,
    at: Millis,
}

impl Arc {
    /// No arc.
    const NONE: Self = Self {
        axis: Direction { x_q14: 0, y_q14: 0 },
        range: None,
        contradictions: 0,
        at: Millis::from_ms(0),
    };

    /// One of its points, millimeters.
    fn point(&self, lobe: &Lobe, face: Displacement, range_mm: i32, point: usize) -> (i32, i32) {
        let (ax, ay) = (i32::from(self.axis.x_q14), i32::from(self.axis.y_q14));
        let towards = lobe.towards(point);
        out(face, range_mm, towards.rotate(ax, ay))
    }

    /// Its middle, millimeters.
    fn middle(&self, face: Displacement, range_mm: i32) -> (i32, i32) {
        let axis = (i32::from(self.axis.x_q14), i32::from(self.axis.y_q14));
        out(face, range_mm, axis)
    }

    /// How often a point was contradicted.
    const fn contradicted(&self, point: usize) -> u8 {
        (self.contradictions >> (2 * point)) as u8 & 3
    }

    /// Whether a point still counts.
    const fn stands(&self, point: usize) -> bool {
        self.contradicted(point) < CONTRADICTIONS
    }

    /// Counts a contradiction of a point; drops the arc when no point is left.
    fn contradict(&mut self, point: usize) {
        if self.stands(point) {
            self.contradictions = self.contradictions.wrapping_add(1 << (2 * point));
        }
        if (0..POINTS).all(|point| !self.stands(point)) {
            *self = Self::NONE;
        }
    }

    /// Square of the middle's distance from the robot; the greatest for no arc.
    fn distance_squared(&self, face: Displacement) -> u64 {
        let Some(range) = self.range else {
            return u64::MAX;
        };
        let range = i32::from(range.as_mm());
        let middle = |face: i16, axis_q14: i16| {
            i64::from(face) + (i64::from(range) * i64::from(axis_q14) >> 14)
        };
        let x = middle(face.dx_mm, self.axis.x_q14).unsigned_abs();
        let y = middle(face.dy_mm, self.axis.y_q14).unsigned_abs();
        x * x + y * y
    }
}

/// What was heard lately.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shield<const SENSORS: usize> {
    /// Where the transducer's face was at each arc: apart from them, as these alone change with every move.
    faces: [[Displacement; KEPT]; SENSORS],
    /// In no order.
    arcs: [[Arc; KEPT]; SENSORS],
    /// When each transducer was heard last, if ever.
    heard_at: [Millis; SENSORS],
    heard: Mask,
    /// How far the ring has turned from the shield's frame.
    turned: Bearing,
    /// The lobe of the last echo.
    lobe: Option<Lobe>,
}

impl<const SENSORS: usize> Default for Shield<SENSORS> {
    fn default() -> Self {
        Self::new()
    }
}

/// What is allowed of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Allowed {
    /// Distance along the displacement, millimetres.
    pub distance_mm: u16,
    /// Speed, millimetres per second.
    pub speed_mm_s: u16,
}

impl<const SENSORS: usize> Shield<SENSORS> {
    /// Nothing heard yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            faces: [[Displacement::ZERO; KEPT]; SENSORS],
            arcs: [[Arc::NONE; KEPT]; SENSORS],
            heard_at: [Millis::from_ms(0); SENSORS],
            heard: Mask::NONE,
            turned: Bearing::ZERO,
            lobe: None,
        }
    }

    /// Forgets everything heard.
    pub fn forget(&mut self) {
        self.faces.as_flattened_mut().fill(Displacement::ZERO);
        self.arcs.as_flattened_mut().fill(Arc::NONE);
        self.heard = Mask::NONE;
        self.turned = Bearing::ZERO;
    }

    /// Takes an echo of a transducer.
    pub fn hear(&mut self, config: &Config<SENSORS>, sensor: usize, echo: Echo) {
        let (Some(shielding), Some(axis)) = (&config.shield, config.robot.directions.get(sensor))
        else {
            return;
        };
        let axis = self.into_frame(*axis);
        let (x_mm, y_mm) = axis.times(i32::from(config.robot.face_radius_mm));
        let cone = Cone::new(Displacement::saturating(x_mm, y_mm), axis, echo);
        let lobe = match self.lobe {
            Some(lobe) if lobe.half == shielding.half_lobe => lobe,
            _ => Lobe::of(shielding.half_lobe),
        };
        self.lobe = Some(lobe);
        self.drop_if_silent(shielding, sensor, echo.at);
        self.replace_same(shielding, sensor, &cone);
        self.look(&lobe, sensor, &cone, shielding.spacing_mm);
        if echo.range.is_some() {
            self.insert(shielding, sensor, &cone, echo);
        }
    }

    /// Drops the arcs of a transducer that was silent for long.
    fn drop_if_silent(&mut self, shielding: &Shielding, sensor: usize, now: Millis) {
        let is_silent = self.since_heard(sensor, now) > Some(shielding.forget_ms);
        if let Some(at) = self.heard_at.get_mut(sensor) {
            *at = now;
            self.heard = self.heard.with(sensor);
        }
        if is_silent && let Some(arcs) = self.arcs.get_mut(sensor) {
            *arcs = [Arc::NONE; KEPT];
        }
    }

    /// Time since a transducer was heard, milliseconds; `None` = never heard.
    fn since_heard(&self, sensor: usize, now: Millis) -> Option<u32> {
        let at = self.heard_at.get(sensor)?;
        self.heard.contains(sensor).then(|| now.since(*at))
    }

    /// Replaces or contradicts what was heard through the same cone.
    fn replace_same(&mut self, shielding: &Shielding, sensor: usize, cone: &Cone) {
        let (Some(faces), Some(arcs)) = (self.faces.get(sensor), self.arcs.get_mut(sensor)) else {
            return;
        };
        for (face, arc) in faces.iter().zip(arcs) {
            let Some(range) = arc.range else { continue };
            if !cone.is_same(*face, arc, shielding.spacing_mm) {
                continue;
            }
            if cone.is_beyond(i32::from(range.as_mm())) {
                (0..POINTS).for_each(|point| arc.contradict(point));
            } else {
                *arc = Arc::NONE;
            }
        }
    }

    /// Counts what the echo contradicts of all other cones.
    fn look(&mut self, lobe: &Lobe, sensor: usize, cone: &Cone, spacing_mm: u16) {
        let faces = self.faces.as_flattened().iter();
        let own = sensor * KEPT..(sensor + 1) * KEPT;
        for (place, (face, arc)) in faces.zip(self.arcs.as_flattened_mut()).enumerate() {
            let Some(range) = arc.range else { continue };
            if own.contains(&place) && cone.is_same(*face, arc, spacing_mm) {
                continue;
            }
            cone.look_at(lobe, *face, arc, i32::from(range.as_mm()));
        }
    }

    /// Keeps an arc; the farthest makes room.
    fn insert(&mut self, shielding: &Shielding, sensor: usize, cone: &Cone, echo: Echo) {
        let (Some(faces), Some(arcs)) = (self.faces.get_mut(sensor), self.arcs.get_mut(sensor))
        else {
            return;
        };
        let places = usize::from(shielding.places).clamp(1, KEPT);
        let slots = faces.iter_mut().zip(arcs).take(places);
        let farthest = slots.max_by_key(|(face, arc)| arc.distance_squared(**face));
        if let Some((face, arc)) = farthest {
            *face = cone.face;
            *arc = Arc {
                axis: cone.axis,
                range: echo.range,
                contradictions: 0,
                at: echo.at,
            };
        }
    }

    /// The robot has moved and then its ring has turned: what was heard stays where it is in the world.
    pub fn moved(&mut self, by: Displacement, turned: Bearing) {
        if by != Displacement::ZERO {
            let by = self.way_into_frame(by);
            for face in self.faces.as_flattened_mut() {
                *face = face.minus(by);
            }
        }
        self.turned = self.turned.plus(turned);
    }

    /// A way in the ring's frame, in the shield's.
    fn way_into_frame(&self, way: Displacement) -> Displacement {
        if self.turned == Bearing::ZERO {
            return way;
        }
        way.rotated(self.turned.direction())
    }

    /// A direction in the ring's frame, in the shield's.
    fn into_frame(&self, axis: Direction) -> Direction {
        if self.turned == Bearing::ZERO {
            return axis;
        }
        let (x, y) = (self.turned.direction()).rotate(axis.x_q14.into(), axis.y_q14.into());
        Direction {
            x_q14: x as i16,
            y_q14: y as i16,
        }
    }

    /// Whether what a transducer has just heard, and heard before, surely does not shorten a motion.
    fn passes(
        &self,
        config: &Config<SENSORS>,
        wanted: Displacement,
        now: Millis,
        sensor: usize,
    ) -> bool {
        let Some(shielding) = &config.shield else {
            return true;
        };
        let (Some(lobe), Some(faces), Some(arcs)) =
            (&self.lobe, self.faces.get(sensor), self.arcs.get(sensor))
        else {
            return false;
        };
        // Heard right now is heard lately.
        if self.since_heard(sensor, now) != Some(0) {
            return false;
        }
        let wanted = self.way_into_frame(wanted);
        let Some(glance) = Glance::along(config, shielding, lobe, wanted) else {
            return false;
        };
        for (face, arc) in faces.iter().zip(arcs) {
            if !glance.passes(*face, arc) {
                return false;
            }
        }
        true
    }

    /// How far and how fast the robot may go along `wanted`, by everything heard lately.
    #[must_use]
    pub fn allow(&self, config: &Config<SENSORS>, wanted: Displacement, now: Millis) -> Allowed {
        self.allow_by(config, wanted, now, Mask::ALL)
    }

    /// As [`allow`](Self::allow), by what the transducers in `among` heard: enough for a motion that the others have
    /// allowed already.
    #[must_use]
    pub fn allow_by(
        &self,
        config: &Config<SENSORS>,
        wanted: Displacement,
        now: Millis,
        among: Mask,
    ) -> Allowed {
        self.allow_along(config, wanted, wanted.length_mm(), now, among)
    }

    /// What is left of a motion that was allowed, by what a transducer has just heard and heard before; `None` = all of it.
    #[must_use]
    #[inline(never)]
    pub fn shorten(
        &self,
        config: &Config<SENSORS>,
        wanted: Displacement,
        now: Millis,
        sensor: usize,
    ) -> Option<Allowed> {
        if self.passes(config, wanted, now, sensor) {
            return None;
        }
        let length = wanted.length_mm();
        let heard = Mask::NONE.with(sensor);
        let allowed = self.allow_along(config, wanted, length, now, heard);
        (allowed.distance_mm < length).then_some(allowed)
    }

    /// As [`allow_by`](Self::allow_by) along a displacement of this length.
    fn allow_along(
        &self,
        config: &Config<SENSORS>,
        wanted: Displacement,
        length: u16,
        now: Millis,
        among: Mask,
    ) -> Allowed {
        let Some(shielding) = &config.shield else {
            return Allowed {
                distance_mm: length,
                speed_mm_s: config.robot.speed_mm_s,
            };
        };
        let length = i32::from(length);
        let lobe = self.lobe.filter(|lobe| lobe.half == shielding.half_lobe);
        let lobe = lobe.unwrap_or_else(|| Lobe::of(shielding.half_lobe));
        let mut way = Way::new(config, shielding, lobe, wanted, length, now);
        if self.turned != Bearing::ZERO {
            way.direction = self.into_frame(way.direction);
        }
        let free = self.free_distance(
            config,
            &way,
            length.saturating_add(braking_distance(config)),
            among,
        );
        let distance = free.min(length);
        let begun = distance >= i32::from(shielding.least_mm).min(length);
        Allowed {
            distance_mm: if begun { distance as u16 } else { 0 },
            speed_mm_s: stopping_speed(config, free),
        }
    }

    /// Distance along the way until something heard comes within the margin, at most `limit`.
    fn free_distance(
        &self,
        config: &Config<SENSORS>,
        way: &Way<'_>,
        limit: i32,
        among: Mask,
    ) -> i32 {
        // Who stands meets nothing.
        if way.direction == Direction::default() {
            return limit;
        }
        if !config.believed.and(among).covers(SENSORS) {
            return self.free_by_some(config, way, limit, among);
        }
        let mut axes = config.robot.directions.iter().enumerate();
        if axes.any(|(sensor, axis)| self.is_stale(way, sensor, *axis)) {
            return 0;
        }
        way.until_any(self.faces.as_flattened(), self.arcs.as_flattened(), limit)
    }

    /// The same where not all are asked; apart, so that it costs nothing where all are.
    #[inline(never)]
    fn free_by_some(
        &self,
        config: &Config<SENSORS>,
        way: &Way<'_>,
        limit: i32,
        among: Mask,
    ) -> i32 {
        if among == Mask::ALL && way.is_blind(config) {
            return 0;
        }
        let asked = config.believed.and(among);
        let axis = |sensor: usize| config.robot.directions.get(sensor);
        let is_stale =
            |sensor: usize| axis(sensor).is_some_and(|axis| self.is_stale(way, sensor, *axis));
        if asked.indices(SENSORS).any(is_stale) {
            return 0;
        }
        asked.indices(SENSORS).fold(limit, |distance, sensor| {
            self.until_any(way, sensor, distance)
        })
    }

    /// Distance until the body would come within the margin of an arc of this transducer; `limit` where it would not.
    fn until_any(&self, way: &Way<'_>, sensor: usize, limit: i32) -> i32 {
        let faces = self.faces.get(sensor).map_or(&[][..], |faces| faces);
        let arcs = self.arcs.get(sensor).map_or(&[][..], |arcs| arcs);
        way.until_any(faces, arcs, limit)
    }

    /// Whether the transducer looks where the robot would go and was not heard lately.
    fn is_stale(&self, way: &Way<'_>, sensor: usize, axis: Direction) -> bool {
        way.is_covered_by(axis)
            && self
                .since_heard(sensor, way.now)
                .is_none_or(|ms| ms > way.shielding.fresh_ms)
    }
}

/// What lies at a range from a face, in a direction of Q14, millimeters.
fn out(face: Displacement, range_mm: i32, (x_q14, y_q14): (i32, i32)) -> (i32, i32) {
    let x = i32::from(face.dx_mm).saturating_add(range_mm.saturating_mul(x_q14) >> 14);
    let y = i32::from(face.dy_mm).saturating_add(range_mm.saturating_mul(y_q14) >> 14);
    (x, y)
}

/// Distance in which the robot stops from its highest speed, millimetres.
fn braking_distance<const SENSORS: usize>(config: &Config<SENSORS>) -> i32 {
    let speed = i32::from(config.robot.speed_mm_s);
    speed.saturating_mul(speed) / (2 * i32::from(config.robot.braking_mm_s2.max(1)))
}

/// The highest speed from which the robot stops within `distance`, at most its limit.
fn stopping_speed<const SENSORS: usize>(config: &Config<SENSORS>, distance: i32) -> u16 {
    let squared = 2 * i64::from(distance) * i64::from(config.robot.braking_mm_s2);
    let limit = config.robot.speed_mm_s;
    if squared >= i64::from(limit) * i64::from(limit) {
        return limit;
    }
    isqrt(squared.max(0).unsigned_abs()) as u16
}

/// The opening of a transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Lobe {
    half: Bearing,
    /// Towards the points of an arc left of its middle, relative to the axis: the last is the edge.
    left: [Direction; POINTS / 2],
    /// No edge is farther from the axis than this, measured in any direction, Q14.
    spread_q14: u32,
}

impl Lobe {
    #[inline(never)]
    fn of(half: Bearing) -> Self {
        let left = core::array::from_fn(|point| {
            let turns = i32::from(half.as_turns()) * (point as i32 + 1) / (POINTS as i32 / 2);
            Bearing::from_turns(turns as u16).direction()
        });
        // Each is below 2¹⁷; two more for the edges' rounding.
        let chord = |edge: Direction| {
            let (x, y) = (i32::from(edge.x_q14), i32::from(edge.y_q14));
            (1_i32 << 14)
                .wrapping_sub(x)
                .unsigned_abs()
                .wrapping_add(y.unsigned_abs())
        };
        let spread = left.into_iter().map(chord).max().unwrap_or(0);
        let spread = spread.wrapping_add(2);
        Self {
            half,
            left,
            spread_q14: spread.wrapping_add(spread >> 4),
        }
    }

    /// Towards a point of an arc, relative to the axis: from the right end to the left.
    fn towards(&self, point: usize) -> Direction {
        const MIDDLE: usize = POINTS / 2;
        let left = |steps: usize| self.left.get(steps.wrapping_sub(1)).copied();
        let towards = if point < MIDDLE {
            left(MIDDLE.wrapping_sub(point)).map(Direction::mirrored)
        } else {
            left(point.wrapping_sub(MIDDLE))
        };
        towards.unwrap_or(Direction {
            x_q14: 1 << 14,
            y_q14: 0,
        })
    }

    /// Its left edge.
    fn edge(&self) -> Direction {
        self.towards(POINTS - 1)
    }
}

/// Axes turned many times may have grown by rounding: while their square is less than this, 9/8 of what it should be,
/// [`Way::is_aside`] holds.
const LONGEST_AXIS_Q28: i32 = 9 << 25;

/// Of a range longer than this nothing is certain: products leave 32 bits.
const CERTAIN_MOST_MM: u32 = 1 << 15;

/// The amount of a number, one less for those below 0: a single instruction on the chip.
const fn magnitude(value: i32) -> i32 {
    value ^ (value >> 31)
}

/// The way ahead.
struct Way<'a> {
    shielding: &'a Shielding,
    /// In the shield's frame.
    direction: Direction,
    /// In the ring's.
    in_ring: Direction,
    lobe: Lobe,
    /// No end of an arc is farther from its middle than this share of its range, measured along the way or across it; at
    /// most 16 bits, four times its range.
    spread_q14: u32,
    /// Body and margin.
    reach_mm: i32,
    /// What lies farther from the robot than this and the way's length is surely not met.
    certain_mm: i32,
    /// Only of a longer range it can be certain that the arc is aside.
    certain_least_mm: u32,
    now: Millis,
}

impl<'a> Way<'a> {
    fn new<const SENSORS: usize>(
        config: &Config<SENSORS>,
        shielding: &'a Shielding,
        lobe: Lobe,
        wanted: Displacement,
        length: i32,
        now: Millis,
    ) -> Self {
        let unit = |mm: i16| crate::fixed::div_round(i32::from(mm) << 14, length.max(1)) as i16;
        let direction = Direction {
            x_q14: unit(wanted.dx_mm),
            y_q14: unit(wanted.dy_mm),
        };
        // The direction is too long by its divisor's rounding.
        let spread = lobe.spread_q14;
        let excess = spread.checked_div(length.unsigned_abs()).unwrap_or(spread);
        let spread = spread.wrapping_add(excess).wrapping_add(2);
        let reach_mm = i32::from(config.robot.body_radius_mm) + i32::from(shielding.margin_mm);
        let least_mm = shielding.least_range_mm;
        let approaches = shielding.approach_mm_s > 0;
        Self {
            shielding,
            direction,
            in_ring: direction,
            lobe,
            spread_q14: spread.min(u32::from(u16::MAX)),
            reach_mm,
            certain_mm: if approaches {
                i32::MAX
            } else {
                reach_mm.max(i32::from(least_mm))
            },
            certain_least_mm: if approaches {
                u32::MAX
            } else {
                u32::from(least_mm)
            },
            now,
        }
    }

    /// Whether the way leads along the gap of a transducer that is not believed: a post there stays unheard all the way. It
    /// reaches to 30° from its axis, somewhat beyond those of the neighbours of 16: the robot is wider than the gap.
    fn is_blind<const SENSORS: usize>(&self, config: &Config<SENSORS>) -> bool {
        const COS_30_Q14: i32 = 14_189;
        let mut ring = config.robot.directions.iter().enumerate();
        ring.any(|(sensor, axis)| {
            let (x, y) = (i32::from(axis.x_q14), i32::from(axis.y_q14));
            !config.believed.contains(sensor) && self.in_ring.along(x, y) > COS_30_Q14
        })
    }

    /// Whether the transducer looks where the robot would go.
    fn is_covered_by(&self, axis: Direction) -> bool {
        const COS_45_Q14: i32 = 11_585;
        let (x, y) = (i32::from(axis.x_q14), i32::from(axis.y_q14));
        self.in_ring.along(x, y) > COS_45_Q14
    }

    /// Distance until the body would come within the margin of an arc; `limit` where it would not before that.
    #[inline(never)]
    fn until_any(&self, faces: &[Displacement], arcs: &[Arc], limit: i32) -> i32 {
        let mut distance = limit;
        let mut near = self.near(limit);
        for (face, arc) in faces.iter().zip(arcs) {
            // Nothing on an arc is met while its face is nearer than its range is long: most are far off.
            let (x, y) = (i32::from(face.dx_mm), i32::from(face.dy_mm));
            let nearness = Range::nearness(arc.range);
            let slack = magnitude(x).wrapping_add(magnitude(y));
            if i32::from(nearness) >= near.wrapping_sub(slack)
                && !self.is_aside(*face, arc, u32::from(!nearness), distance)
                && let Some(range) = arc.range
            {
                distance = self.until(*face, arc, i32::from(range.as_mm()), distance);
                near = self.near(distance);
            }
        }
        distance
    }

    /// What lies farther from the robot than this is not met before `limit`, as of [`Range::nearness`]; with what two
    /// magnitudes lack.
    fn near(&self, limit: i32) -> i32 {
        let near = limit.saturating_add(self.certain_mm);
        // Not below -2³¹ + 2¹⁶.
        i32::from(u16::MAX).wrapping_sub(near).wrapping_sub(2)
    }

    /// Distance until the body would come within the margin of the arc; `limit` where it would not before that. Apart
    /// from the loop over all arcs, whose values then stay in registers.
    #[inline(never)]
    fn until(&self, face: Displacement, arc: &Arc, mut range: i32, limit: i32) -> i32 {
        let least = i32::from(self.shielding.least_range_mm);
        let mut nearest = limit;
        if range <= least {
            // It may be anywhere between the face and the shortest range.
            let (x, y) = (i32::from(face.dx_mm), i32::from(face.dy_mm));
            nearest = self.until_point(x, y, nearest);
            range = least;
        }
        let approach = u32::from(self.shielding.approach_mm_s);
        if approach > 0 {
            let aged = self.now.since(arc.at).saturating_mul(approach) / 1_000;
            range = range.saturating_sub(aged.min(65_535) as i32).max(0);
        }
        for point in (0..POINTS).filter(|point| arc.stands(*point)) {
            let (x, y) = arc.point(&self.lobe, face, range, point);
            nearest = nearest.min(self.until_point(x, y, nearest));
        }
        nearest
    }

    /// Whether an arc surely changes nothing: all of it lies behind, beside the way or beyond its end. Spares most arcs
    /// their ends.
    #[inline(always)]
    fn is_aside(&self, face: Displacement, arc: &Arc, range: u32, limit: i32) -> bool {
        if range <= self.certain_least_mm || range > CERTAIN_MOST_MM {
            return false;
        }
        let (fx, fy) = (i32::from(face.dx_mm), i32::from(face.dy_mm));
        let (ax, ay) = (i32::from(arc.axis.x_q14), i32::from(arc.axis.y_q14));
        let out = |axis_q14: i32| (range as i32).wrapping_mul(axis_q14) >> 14;
        let spread = range.wrapping_mul(self.spread_q14) >> 14;
        // Roundings of less than 8 in all.
        let spread = (spread as i32).wrapping_add(16);
        // The middle, at most 46 341 + 34 816 away; its products with a direction no longer than √2 fit.
        let (x, y) = (fx.wrapping_add(out(ax)), fy.wrapping_add(out(ay)));
        let along = self.direction.along(x, y);
        let is_aside = along.wrapping_add(spread) <= 0
            || {
                let across = self.direction.along(y, x.wrapping_neg());
                across.wrapping_abs().wrapping_sub(spread) >= self.reach_mm
            }
            || along.wrapping_sub(spread).wrapping_sub(limit) >= self.reach_mm;
        is_aside && ax.wrapping_mul(ax).wrapping_add(ay.wrapping_mul(ay)) < LONGEST_AXIS_Q28
    }

    /// Distance until the body would come within the margin of a point.
    fn until_point(&self, x_mm: i32, y_mm: i32, limit: i32) -> i32 {
        // A point farther than 16 m is out of any step's reach, and its products would leave 32 bits.
        if x_mm.saturating_abs().max(y_mm.saturating_abs()) > 16_000 {
            return limit;
        }
        let along = self.direction.along(x_mm, y_mm);
        let across = self.direction.along(y_mm, x_mm.wrapping_neg());
        let reach = self.reach_mm;
        if along <= 0 || across.saturating_abs() >= reach {
            return limit;
        }
        let squared = reach
            .wrapping_mul(reach)
            .wrapping_sub(across.wrapping_mul(across))
            .max(0);
        // Most points lie beyond the limit: that is seen without a root.
        let beyond = along.wrapping_sub(limit);
        if beyond >= 0 && beyond.saturating_mul(beyond) >= squared {
            return limit;
        }
        let half_chord = isqrt(u64::from(squared.unsigned_abs()));
        along.wrapping_sub(half_chord as i32).max(0).min(limit)
    }
}

#[cfg(test)]
mod tests;
