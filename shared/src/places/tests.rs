use super::*;
use crate::goal::Goal;
use crate::memory;
use crate::points::{Beam, PointLimits, PointMemory};
use crate::scan::Encoding;
use crate::units::{Bearing, Range};
use core::task::Poll;

mod blocked;
mod everywhere;
mod locate;
mod lost;
mod narrow;
mod reading;
mod relocate;
mod saved;
mod spacing;
mod turned;

const LIMITS: PlaceLimits = PlaceLimits::NOMAD;
const BODY_MM: f64 = 269.0;
const FACE_MM: f64 = 231.0;
/// That of [`Walker::view`].
const ENCODING: Encoding = Encoding {
    near_mm: 0,
    far_mm: 4_500,
};

/// Walls between two points, millimeters.
type Walls = [[f64; 4]];

/// Two rooms of 2 m × 4 m; the wall between them ends 1.2 m before the upper one.
const TWO_ROOMS: [[f64; 4]; 5] = [
    [-2_000.0, -2_000.0, 2_000.0, -2_000.0],
    [2_000.0, -2_000.0, 2_000.0, 2_000.0],
    [2_000.0, 2_000.0, -2_000.0, 2_000.0],
    [-2_000.0, 2_000.0, -2_000.0, -2_000.0],
    [0.0, -2_000.0, 0.0, 800.0],
];

/// A robot that goes where it is led, in a straight line.
struct Walker<'a, const RECORDS: usize = 256> {
    walls: &'a Walls,
    start: (f64, f64),
    points: PointMemory<256>,
    places: Places<16, RECORDS>,
    goal: Goal<16>,
    way_mm: f64,
    /// It may be led against a wall, and stands then: so often.
    stops: bool,
    stopped: u32,
    /// Ways or places that it thinks of at a time.
    slice: u16,
}

impl<'a, const RECORDS: usize> Walker<'a, RECORDS> {
    fn new(walls: &'a Walls, start: (f64, f64)) -> Self {
        Self {
            walls,
            start,
            points: PointMemory::new(),
            places: Places::new(),
            goal: perceived(&[255; 16]),
            way_mm: 0.0,
            stops: false,
            stopped: 0,
            slice: u16::MAX,
        }
    }

    fn position(&self) -> (f64, f64) {
        let here = self.places.here();
        (
            self.start.0 + f64::from(here.dx_mm),
            self.start.1 + f64::from(here.dy_mm),
        )
    }

    fn clearance_mm(&self) -> f64 {
        let (x, y) = self.position();
        let distances = self.walls.iter().map(|[ax, ay, bx, by]| {
            let (ux, uy) = (bx - ax, by - ay);
            let along = ((x - ax) * ux + (y - ay) * uy) / (ux * ux + uy * uy);
            let along = along.clamp(0.0, 1.0);
            libm::hypot(x - ax - along * ux, y - ay - along * uy)
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    fn would_touch(&mut self, step: Displacement) -> bool {
        let here = self.places.here;
        self.places.here = here.plus(step);
        let touches = self.clearance_mm() <= BODY_MM;
        self.places.here = here;
        touches
    }

    /// Distance to the nearest wall along a ray from the center.
    fn ray_mm(&self, angle: f64) -> f64 {
        let (x, y) = self.position();
        let (dx, dy) = (libm::cos(angle), libm::sin(angle));
        let distances = self.walls.iter().filter_map(|[ax, ay, bx, by]| {
            let (ux, uy) = (bx - ax, by - ay);
            let cross = dx * uy - dy * ux;
            let far = ((ax - x) * uy - (ay - y) * ux) / cross;
            let along = ((ax - x) * dy - (ay - y) * dx) / cross;
            (cross.abs() > 1e-9 && far > 0.0 && (0.0..=1.0).contains(&along)).then_some(far)
        });
        distances.fold(10_000.0, f64::min)
    }

    fn hear(&mut self) {
        for sensor in 0..16 {
            let axis = Bearing::of_place(sensor, 16);
            let middle = sensor as f64 * core::f64::consts::TAU / 16.0;
            let cone = (-5..=5).map(|part| self.ray_mm(middle + f64::from(part) * 0.0436));
            let nearest = cone.fold(f64::INFINITY, f64::min);
            let beam = Beam {
                mount: Displacement::along(axis, FACE_MM as i32),
                axis,
                range: Range::from_mm((nearest - FACE_MM).max(0.0) as u16),
                is_echo: true,
            };
            self.points.hear(&PointLimits::NOMAD, &beam);
        }
    }

    fn look(&mut self) {
        self.hear();
        assert_eq!(self.think(Purpose::Perceive), None);
    }

    fn think(&mut self, purpose: Purpose) -> Option<Leg> {
        let view = self.view();
        let (places, points) = (&mut self.places, &self.points);
        think(places, points, view, purpose, &self.goal, self.slice)
    }

    /// What a ring perceives there: 254 at its face, 0 from 4.5 m on.
    fn view(&self) -> [u8; 16] {
        core::array::from_fn(|sensor| {
            let away_mm = self.ray_mm(sensor as f64 * core::f64::consts::TAU / 16.0) - FACE_MM;
            (254.0 * (1.0 - away_mm / 4_500.0)).max(0.0) as u8
        })
    }

    /// A decision and its step; the leg, if there is one.
    fn step(&mut self, aim: Aim) -> Option<Leg> {
        self.hear();
        let leg = self.think(Purpose::Lead(aim))?;
        let step = leg.way.shortened(250);
        if self.stops && self.would_touch(step) {
            self.stopped += 1;
            return Some(leg);
        }
        self.way_mm += f64::from(step.length_mm());
        self.points.moved(&PointLimits::NOMAD, step, Bearing::ZERO);
        self.places.moved(step);
        assert!(self.clearance_mm() > BODY_MM, "it touches the wall");
        Some(leg)
    }

    /// Steps until it is there.
    fn go_to(&mut self, goal: Displacement) -> usize {
        let arrives = |walker: &mut Self| {
            walker.step(Aim::Position(goal));
            goal.minus(walker.places.here()).is_shorter_than(20)
        };
        let steps = (1..=200).find(|_| arrives(self));
        steps.expect("it arrives")
    }
}

/// Thinks to the end, in slices.
fn think<const RECORDS: usize, const POINTS: usize>(
    places: &mut Places<16, RECORDS>,
    points: &PointMemory<POINTS>,
    view: [u8; 16],
    purpose: Purpose,
    goal: &Goal<16>,
    slice: u16,
) -> Option<Leg> {
    places.begin(ENCODING, view, purpose);
    loop {
        assert!(places.is_thinking());
        if let Poll::Ready(leg) = places.think(&LIMITS, points, Some(goal), slice) {
            assert!(!places.is_thinking());
            return leg;
        }
    }
}

fn perceived(view: &[u8; 16]) -> Goal<16> {
    Goal::perceived(&memory::from_bytes(view).0)
}

fn to(dx_mm: i16, dy_mm: i16) -> Displacement {
    Displacement { dx_mm, dy_mm }
}

#[test]
fn a_goal_behind_a_wall_is_found_and_the_way_back_is_short() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    walker.way_mm = 0.0;
    walker.go_to(Displacement::ZERO);
    // Around the end of the wall, at 0.29 m from it: 5.37 m at least.
    assert!(walker.way_mm < 6_500.0, "{}", walker.way_mm);
}

/// It goes to all corners of the two rooms, and its places stand so far apart.
fn explores_both_rooms<const RECORDS: usize>(
    walker: &mut Walker<'_, RECORDS>,
    apart_mm: u32,
    near_mm: u32,
) {
    let steps = (0..400).find(|_| walker.step(Aim::Frontier).is_none());
    assert!(steps.is_some_and(|steps| steps < 200), "{steps:?}");
    let places = || walker.places.positions();
    let within = |position: Displacement, mm: u32| {
        places().filter(move |place| place.minus(position).is_shorter_than(mm))
    };
    for (x, y) in [(2_600, 3_000), (2_600, -200), (-600, 3_000), (1_000, 2_800)] {
        assert!(within(to(x, y), near_mm).count() > 0, "{x} {y}");
    }
    for place in places() {
        assert_eq!(within(place, apart_mm).count(), 1, "{place:?}");
    }
}

#[test]
fn it_goes_where_it_has_not_been_until_it_has_been_everywhere() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    explores_both_rooms(&mut walker, 350, 600);
    let count = walker.places.positions().len();
    assert!((30..120).contains(&count), "{count}");
}

#[test]
fn without_room_for_all_places_stand_farther_apart() {
    let mut walker = Walker::<40>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    explores_both_rooms(&mut walker, 430, 700);
    let count = walker.places.positions().len();
    assert!((20..40).contains(&count), "{count}");
    walker.go_to(Displacement::ZERO);
}

#[test]
fn nothing_leads_through_a_wall() {
    let mut closed = TWO_ROOMS;
    closed[4][3] = 2_000.0;
    let mut walker = Walker::<256>::new(&closed, (-1_000.0, -1_400.0));
    for _ in 0..300 {
        walker.step(Aim::Position(to(2_000, 0)));
        assert!(walker.position().0 < -BODY_MM);
    }
}

#[test]
fn a_robot_that_cannot_go_on_is_led_elsewhere() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    // It is sent back and its base does not move.
    let home = Aim::Position(Displacement::ZERO);
    let mut ways = std::vec::Vec::new();
    for _ in 0..60 {
        walker.hear();
        let leg = walker.think(Purpose::Lead(home));
        ways.extend(leg.map(|leg| leg.way));
    }
    assert!(ways.iter().any(|way| *way != ways[0]), "{ways:?}");
}

#[test]
fn the_leg_tells_how_much_room_it_leaves_and_whether_it_is_the_last() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_200.0));
    let leg = walker.step(Aim::Position(to(0, 600))).expect("a way");
    assert_eq!((leg.way, leg.room_mm, leg.is_last), (to(0, 600), 400, true));
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_500.0, -1_200.0));
    let leg = walker.step(Aim::Position(to(0, 600))).expect("a way");
    // The wall is 0.5 m away.
    assert_eq!((leg.room_mm, leg.is_last), (75, true));
    let leg = walker.step(Aim::Position(to(2_600, 0))).expect("a way");
    assert!(!leg.is_last);
}

/// It goes where it has not been, back, and to a situation, with room for too few places.
fn a_whole_way(slice: u16) -> (std::vec::Vec<Option<Leg>>, Places<16, 40>) {
    let mut walker = Walker::<40>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    (walker.slice, walker.goal) = (slice, perceived(&walker.view()));
    let aims = [
        (Aim::Frontier, 90),
        (Aim::Situation, 40),
        (Aim::Position(to(2_000, 0)), 40),
    ];
    let mut legs = std::vec::Vec::new();
    for (aim, steps) in aims {
        walker.places.seek_anew();
        legs.extend((0..steps).map(|_| walker.step(aim)));
    }
    (legs, walker.places)
}

#[test]
fn it_does_not_depend_on_the_slices_what_it_thinks() {
    let at_once = a_whole_way(u16::MAX);
    assert!(at_once.0.iter().flatten().count() > 100);
    for slice in [1, 3, 16] {
        assert!(a_whole_way(slice) == at_once, "{slice}");
    }
}

#[test]
fn what_it_thinks_of_ends_when_it_is_told() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.look();
    let (points, view) = (walker.points.clone(), walker.view());
    let stops: [fn(&mut Places<16, 256>); 2] = [Places::stop_thinking, Places::forget];
    for stop in stops {
        walker.places.begin(ENCODING, view, Purpose::Stay);
        let slice = walker.places.think(&LIMITS, &points, None, 1);
        assert_eq!(slice, Poll::Pending);
        stop(&mut walker.places);
        assert!(!walker.places.is_thinking());
        let slice = walker.places.think(&LIMITS, &points, None, 1);
        assert_eq!(slice, Poll::Ready(None));
    }
}

#[test]
fn what_has_been_forgotten_is_unknown() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(0, 1_000));
    assert!(walker.places.compass != Compass::NEW);
    walker.places.forget();
    assert!(walker.places.compass == Compass::NEW && walker.places.traveled_mm == 0);
    assert_eq!(walker.places.positions().len(), 0);
    assert_eq!(walker.places.here(), Displacement::ZERO);
}

#[test]
fn a_full_memory_goes_on_with_what_it_has() {
    let mut points = PointMemory::<64>::new();
    let mut places = Places::<16, 2>::new();
    let (view, goal) = ([255; 16], perceived(&[255; 16]));
    for _ in 0..5 {
        think(&mut places, &points, view, Purpose::Perceive, &goal, 1);
        places.moved(to(500, 0));
        points.moved(&PointLimits::NOMAD, to(500, 0), Bearing::ZERO);
    }
    assert_eq!(places.positions().len(), 2);
    let mut none = Places::<16, 0>::new();
    let lead = Purpose::Lead(Aim::Frontier);
    assert_eq!(think(&mut none, &points, view, lead, &goal, 1), None);
}

#[test]
fn a_situation_recalls_the_place_where_it_was_perceived() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.goal = perceived(&walker.view());
    let ends = (0..400).any(|_| walker.step(Aim::Frontier).is_none());
    let far = walker.places.here();
    assert!(ends && !far.is_shorter_than(1_500), "{far:?}");
    walker.places.seek_anew();
    walker.way_mm = 0.0;
    // At each place that recalls it the robot looks for it by itself: here it only looks.
    let mut looks = std::vec::Vec::new();
    for _ in 0..100 {
        let leg = walker.step(Aim::Situation);
        let (goal, view) = (walker.goal, walker.view());
        if walker.places.is_found(&goal, &view) {
            break;
        }
        if leg.is_none() {
            looks.push(walker.places.here());
        }
    }
    let here = walker.places.here();
    assert!(here.is_shorter_than(200), "{here:?}");
    assert!(walker.way_mm < 15_000.0, "{}", walker.way_mm);
    // Where it looked in vain it does not look again.
    assert!((1..10).contains(&looks.len()), "{looks:?}");
    for (number, look) in looks.iter().enumerate() {
        let mut before = looks.iter().take(number);
        assert!(!before.any(|other| other.minus(*look).is_shorter_than(150)));
    }
}

#[test]
fn where_a_situation_was_found_a_noisy_view_is_that_place() {
    let mut places = Places::<16, 4>::new();
    let goal = perceived(&[100; 16]);
    let noisy = core::array::from_fn(|sensor| if sensor < 8 { 115 } else { 85 });
    assert!(!places.is_found(&goal, &noisy));
    assert!(places.is_found(&goal, &[103; 16]));
    assert!(places.is_found(&goal, &noisy));
    places.moved(to(70, 0));
    assert!(!places.is_found(&goal, &noisy));
    // One sector in which something stands does not count for much, nor one that is not seen.
    let mut beside = [100; 16];
    (beside[3], beside[4]) = (250, 255);
    assert!(places.is_found(&goal, &beside));
}
