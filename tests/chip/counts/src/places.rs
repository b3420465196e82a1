//! Counts what a full memory of places costs: 256 of them, with 256 points around the robot.

use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::goal::Goal;
use amp::memory;
use amp::places::{Aim, PlaceLimits, Places, Purpose, SLICE};
use amp::points::{Beam, PointLimits, PointMemory};
use amp::scan::Encoding;
use amp::units::{Bearing, Displacement, Range};
use core::hint::black_box;

/// A memory of places in static memory: it is too large for the stack.
pub type Map = Places<16, 256>;

/// The robot goes to and fro in rows of so many places, so far apart.
const ROW: i16 = 16;
const APART_MM: i16 = 360;
/// The last rows find no room: places are thinned out.
const ROWS: i16 = 18;
/// Distances of the points all around: things far away, in the middle of its ways, in its way.
const THINGS_MM: [u16; 3] = [2_000, 900, 350];
const ENCODING: Encoding = Encoding {
    near_mm: 0,
    far_mm: 4_500,
};

/// Instructions by kind of call.
#[derive(Default)]
pub struct PlaceCounts {
    /// Where the robot is.
    pub locate: InstructionStats,
    /// A slice of thinking.
    pub slice: InstructionStats,
    /// All slices of a decision of a robot that is not led.
    pub perceive: InstructionStats,
    /// All slices of a decision of a robot that is led.
    pub lead: InstructionStats,
    /// All slices of a decision of a robot that was set down elsewhere.
    pub lost: InstructionStats,
}

/// Fills the map, and leads the robot through it.
pub fn count(watch: &Stopwatch, map: &mut Map) -> PlaceCounts {
    let mut robot = MappedRobot {
        watch,
        map,
        counts: PlaceCounts::default(),
    };
    let around = THINGS_MM.map(things);
    robot.map.trust_heading(true);
    for row in 0..ROWS {
        for column in 0..ROW {
            let view = core::array::from_fn(|sector| (80 + row + column) as u8 + sector as u8);
            let here = &around[usize::from(column.unsigned_abs()) % 2];
            robot.locate(&view);
            let instructions = robot.think(here, view, Purpose::Perceive);
            robot.counts.perceive.add(instructions);
            robot.map.moved(match (column + 1 == ROW, row % 2) {
                (true, _) => to(0, APART_MM),
                (false, 0) => to(APART_MM, 0),
                (false, _) => to(-APART_MM, 0),
            });
        }
        // As many as there may be.
        if robot.map.positions().len() == 256 {
            robot.lead_everywhere(&around);
            robot.lead_everywhere(&[wall(), spiral(400, 4)]);
        }
    }
    for has_compass in [true, false] {
        for points in around.iter().chain(&[wall()]) {
            robot.set_down(points, has_compass);
        }
    }
    robot.counts
}

struct MappedRobot<'a> {
    watch: &'a Stopwatch,
    map: &'a mut Map,
    counts: PlaceCounts,
}

impl MappedRobot<'_> {
    fn locate(&mut self, view: &[u8; 16]) {
        let (instructions, ()) = self.watch.count(|| {
            let (map, view) = black_box((&mut *self.map, view));
            map.locate(black_box(ENCODING), view);
        });
        self.counts.locate.add(instructions);
    }

    /// Instructions of all slices.
    fn think(&mut self, points: &PointMemory<256>, view: [u8; 16], purpose: Purpose) -> u32 {
        let (limits, goal) = (PlaceLimits::NOMAD, perceived(100));
        self.map.begin(ENCODING, view, purpose);
        let mut all = 0;
        loop {
            let (instructions, thought) = self.watch.count(|| {
                let (map, points) = black_box((&mut *self.map, points));
                map.think(black_box(&limits), points, black_box(Some(&goal)), SLICE)
            });
            self.counts.slice.add(instructions);
            all += instructions;
            if thought.is_ready() {
                return all;
            }
        }
    }

    /// From the middle: where it has not been, to a situation, and far away; nothing that it tries
    /// goes, so that it gives up ways. Its heading drifts, and it perceives nothing that it knows.
    fn lead_everywhere(&mut self, around: &[PointMemory<256>]) {
        let here = self.map.here();
        let half_mm = APART_MM * ROW / 2;
        let middle = to(half_mm, half_mm);
        self.map.trust_heading(false);
        for points in around {
            for aim in [
                Aim::Frontier,
                Aim::Situation,
                Aim::Position(to(30_000, 0)),
                Aim::Position(to(0, 0)),
            ] {
                self.map.seek_anew();
                for _ in 0..20 {
                    self.map.moved(middle.minus(self.map.here()));
                    let instructions = self.think(points, [100; 16], Purpose::Lead(aim));
                    self.counts.lead.add(instructions);
                }
            }
        }
        let back = here.minus(self.map.here());
        self.map.moved(back);
        self.map.trust_heading(true);
    }

    /// It does not know where it is, and what it perceives was perceived at many places.
    fn set_down(&mut self, points: &PointMemory<256>, has_compass: bool) {
        self.map.trust_heading(has_compass);
        self.map.set_down();
        for step in 0..40 {
            let view = core::array::from_fn(|sector| 90 + (step + sector) as u8);
            let lead = Purpose::Lead(Aim::Position(to(0, 0)));
            let instructions = self.think(points, view, lead);
            self.counts.lost.add(instructions);
            self.map.moved(to(250, 0));
        }
        self.map.trust_heading(true);
    }
}

/// A wall on the left, of which all 256 points tell: 16 of them heard here.
fn wall() -> PointMemory<256> {
    let mut points = PointMemory::new();
    for (count, way) in [(240, to(400, 0)), (16, to(0, 0))] {
        for sensor in 0..count {
            // Within 7° of its normal.
            let axis = Bearing::of_place(960 + sensor % 64, 4_096);
            points.hear(&PointLimits::NOMAD, &echo(axis, 900));
        }
        points.moved(&PointLimits::NOMAD, way, Bearing::ZERO);
    }
    points
}

/// Things all around that leave 256 points.
fn things(range_mm: u16) -> PointMemory<256> {
    spiral(range_mm, 0)
}

/// Points all around, each so much farther than the one before: each beam sees past the last ones.
fn spiral(range_mm: u16, farther_mm: u16) -> PointMemory<256> {
    let mut points = PointMemory::new();
    for sensor in 0..256 {
        let range_mm = range_mm + sensor as u16 * farther_mm;
        let echo = echo(Bearing::of_place(sensor, 256), range_mm);
        points.hear(&PointLimits::NOMAD, &echo);
    }
    points
}

fn echo(axis: Bearing, range_mm: u16) -> Beam {
    Beam {
        mount: Displacement::ZERO,
        axis,
        range: Range::from_mm(range_mm),
        is_echo: true,
    }
}

fn perceived(value: u8) -> Goal<16> {
    Goal::perceived(&memory::from_bytes(&[value; 16]).0)
}

fn to(dx_mm: i16, dy_mm: i16) -> Displacement {
    Displacement { dx_mm, dy_mm }
}
