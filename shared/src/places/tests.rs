use super::*;
use crate::goal::Goal;
use crate::memory;
use crate::points::{Beam, PointLimits, PointMemory};
use crate::scan::Encoding;
use crate::units::{Bearing, Range};
use core::task::Poll;

const LIMITS: PlaceLimits = PlaceLimits::NOMAD;
const BODY_MM: f64 = 269.0;
const FACE_MM: f64 = 231.0;

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
    places.begin(view, purpose);
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

/// A guard of a large margin, and room for few places: it goes on to look for ways.
#[test]
fn a_wide_spacing_leaves_open_ways() {
    let limits = PlaceLimits {
        radius_mm: u16::MAX,
        ..LIMITS
    };
    let mut graph = Graph::<16, 2>::NEW;
    for x_mm in [0, 600, 1_200, 1_800, 2_400, 3_000] {
        graph.place_at(&limits, to(x_mm, 0), &[255; 16]);
        while graph.thin_out(&limits).is_some() {}
    }
    assert_eq!(graph.spacing_mm(&limits), 550);
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
        walker.places.begin(view, Purpose::Stay);
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
    walker.places.forget();
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

/// That of [`Walker::view`].
const ENCODING: Encoding = Encoding {
    near_mm: 0,
    far_mm: 4_500,
};

impl Walker<'_> {
    /// Odometry tells that it went there, and it did not.
    fn slip(&mut self, way: Displacement) {
        self.start.0 -= f64::from(way.dx_mm);
        self.start.1 -= f64::from(way.dy_mm);
        self.places.moved(way);
    }

    fn locate(&mut self, view: &[u8; 16]) -> Displacement {
        let (x, y) = self.position();
        self.places.locate(ENCODING, view);
        // The walls stay where they are.
        let moved = (self.position().0 - x, self.position().1 - y);
        (self.start.0, self.start.1) = (self.start.0 - moved.0, self.start.1 - moved.1);
        self.places.here()
    }
}

#[test]
fn at_a_known_place_it_perceives_that_odometry_was_wrong() {
    for slip in [to(60, -40), to(-50, -50), to(0, 80)] {
        let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -300.0));
        walker.look();
        walker.slip(slip);
        for _ in 0..20 {
            walker.look();
            let view = walker.view();
            walker.locate(&view);
        }
        let here = walker.places.here();
        assert!(here.is_shorter_than(25), "{slip:?}: {here:?}");
    }
}

#[test]
fn what_does_not_tell_that_it_is_elsewhere_leaves_it_where_it_is() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -300.0));
    let view = walker.view();
    assert_eq!(walker.locate(&view), Displacement::ZERO);
    walker.look();
    // 53 mm of noise, a little more of it on one side.
    let is_farther = |sector| [4, 6, 8, 10, 12, 14].contains(&sector);
    let noise = |sector| if is_farther(sector) { -3 } else { 3 };
    let noisy = core::array::from_fn(|sector| view[sector].saturating_add_signed(noise(sector)));
    assert_eq!(walker.locate(&noisy), Displacement::ZERO);
    // Things all around have gone, or nothing has been seen of them.
    assert_eq!(walker.locate(&[40; 16]), Displacement::ZERO);
    assert_eq!(walker.locate(&[0; 16]), Displacement::ZERO);
    assert_eq!(walker.locate(&[255; 16]), Displacement::ZERO);
    // Far from all places.
    walker.slip(to(300, 0));
    assert_eq!(walker.locate(&view), to(300, 0));
}

#[test]
fn a_place_keeps_what_it_showed_at_first_and_adds_what_it_did_not() {
    let mut record = record::Record::<4>::new(Displacement::ZERO, &[10, 255, 30, 255]);
    record.complete(&[99, 20, 255, 255]);
    assert_eq!(record.view, [10, 20, 30, 255]);
}

#[test]
fn only_what_shows_the_same_things_tells_where_it_is() {
    let walls = [100; 16];
    let only = |seen: u8, sectors: &[usize]| {
        core::array::from_fn(|sector| if sectors.contains(&sector) { 100 } else { seen })
    };
    // As seen from farther ahead, in units of 18 mm.
    let ahead = |view: [u8; 16], units: f64| {
        core::array::from_fn(|sector| {
            let nearer = units * libm::cos(sector as f64 * core::f64::consts::TAU / 16.0);
            match view[sector] {
                seen @ (0 | 255) => seen,
                seen => seen.saturating_add_signed(libm::round(nearer) as i8),
            }
        })
    };
    // Where it thinks that it is after this view, if it thought that it had gone so far.
    let located = |before: [u8; 16], thought_mm: i16, now: [u8; 16]| {
        let mut places = Places::<16, 4>::new();
        let (points, goal) = (PointMemory::<64>::new(), perceived(&before));
        think(&mut places, &points, before, Purpose::Perceive, &goal, 1);
        places.moved(to(thought_mm, 0));
        places.locate(ENCODING, &now);
        places.here().dx_mm
    };
    assert!((20..40).contains(&located(walls, 50, walls)));
    // Five sectors are too few.
    let five = only(255, &[14, 15, 0, 1, 2]);
    assert_eq!(located(walls, 50, five), 50);
    assert_eq!(located(five, 50, walls), 50);
    // Nothing is in range behind it: that does not say that it stands still.
    let front = only(0, &[12, 13, 14, 15, 0, 1, 2, 3, 4]);
    assert!((10..40).contains(&located(front, 0, ahead(front, 3.0))));
    // Other things, 0.3 m nearer and farther.
    assert_eq!(located(walls, 0, ahead(walls, 17.0)), 0);
    // It is not at that place.
    assert_eq!(located(walls, 300, ahead(walls, 14.0)), 300);
}

#[test]
fn links_tell_between_which_places_it_went() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    assert_eq!(walker.places.links().count(), 0);
    walker.go_to(to(0, 1_500));
    let count = walker.places.positions().len() as u16;
    // It went from each place to the next one, and never back.
    let links = std::vec::Vec::from_iter(walker.places.links());
    let in_a_row = std::vec::Vec::from_iter((1..count).map(|place| (place - 1, place)));
    assert_eq!(links, in_a_row);
}

/// From the middle place it went to more others than it remembers links.
#[test]
fn a_link_that_one_end_forgot_is_told_by_the_other() {
    let mut graph = Graph::<16, 16>::NEW;
    for x in 0..10 {
        graph.place_at(&LIMITS, to(1_000 * x, 0), &[255; 16]);
    }
    for other in 1..10 {
        graph.went(0, other);
    }
    let places = Places::<16, 16> {
        graph,
        ..Places::new()
    };
    let mut links = std::vec::Vec::from_iter(places.links());
    links.iter_mut().for_each(|(one, other)| {
        (*one, *other) = ((*one).min(*other), (*one).max(*other));
    });
    links.sort_unstable();
    let all = std::vec::Vec::from_iter((1..10).map(|other| (0, other)));
    assert_eq!(links, all);
}

#[test]
fn a_way_that_does_not_go_is_blocked_once() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    let count = walker.places.links().count();
    walker.places.graph.block(3, 2);
    assert!(walker.places.blocked().eq([(2, 3)]));
    assert_eq!(walker.places.links().count(), count - 1);
}

#[test]
fn frontiers_lead_to_where_it_has_not_been() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.look();
    let frontiers = std::vec::Vec::from_iter(walker.places.frontiers());
    assert!(!frontiers.is_empty());
    for [from, end] in frontiers {
        assert_eq!(from, Displacement::ZERO);
        assert!((350..=600).contains(&end.length_mm()), "{end:?}");
    }
    while walker.step(Aim::Frontier).is_some() {}
    assert_eq!(walker.places.frontiers().count(), 0);
}

#[test]
fn the_plan_goes_from_the_next_sub_goal_to_the_end() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    let plan = |walker: &Walker<'_>, aim: Aim| std::vec::Vec::from_iter(walker.places.plan(aim));
    assert_eq!(plan(&walker, Aim::Frontier), []);
    // To where it has not been: the end of an open way.
    let leg = walker.step(Aim::Frontier).expect("a way");
    assert_eq!(plan(&walker, Aim::Frontier), [leg.way]);
    walker.go_to(to(2_000, 0));
    // A goal in sight is all of the way.
    let near = Aim::Position(to(2_000, 300));
    walker.step(near);
    assert_eq!(plan(&walker, near), [to(2_000, 300)]);
    // Back around the end of the wall.
    let home = Aim::Position(Displacement::ZERO);
    let before = walker.places.here();
    let leg = walker.step(home).expect("a way");
    let way = plan(&walker, home);
    assert_eq!(way.first(), Some(&before.plus(leg.way)));
    assert_eq!(way.last(), Some(&Displacement::ZERO));
    assert!(way.len() > 3, "{way:?}");
    for pair in way.windows(2) {
        assert!(pair[1].minus(pair[0]).length_mm() <= 1_500, "{way:?}");
    }
}

#[test]
fn a_plan_that_ends_with_an_open_way_goes_to_its_end() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    let (mut plans, mut open) = (0, 0);
    while walker.step(Aim::Frontier).is_some() {
        let plan = std::vec::Vec::from_iter(walker.places.plan(Aim::Frontier));
        let mut ends = walker.places.frontiers().map(|[_, end]| end);
        // Over a place at least.
        if plan.len() > 1 {
            plans += 1;
            open += usize::from(ends.any(|end| plan.last() == Some(&end)));
        }
    }
    // A new place may close an open way that the robot still goes along.
    assert!(plans > 5 && 10 * open > 8 * plans, "{open} of {plans}");
}
