//! Numbers, quantities, scans and situations.

use crate::{any, bytes, sink};
use amp::fixed::{self, Gain, Mask, Weight, Weight32};
use amp::memory;
use amp::robot::{self, RobotSpec};
use amp::scan::{self, Echo, Encoding, Scan};
use amp::som::{Decay, Schedule};
use amp::units::{Bearing, Direction, Displacement, Millis, Range};

pub fn all() {
    formats();
    vectors();
    functions();
    masks();
    schedules();
    moves();
    scans();
    sink(RobotSpec::miniature());
    sink(robot::evenly_spaced::<24>());
}

pub fn weight() -> Weight {
    Weight::from_bits(any(1))
}

fn formats() {
    let fine = Weight32::from_bits(any(1));
    let gain = Gain::from_bits(any(1));
    sink(fixed::to_weight16(fine));
    sink(fixed::unit_weight(any(1)));
    sink(Gain::from_q16(any(1)).times(gain).to_bits());
    sink(fixed::approach(fine, Weight32::from_bits(any(2)), gain));
}

/// Vectors of any length.
fn vectors() {
    static WEIGHTS: [Weight; 40] = [Weight::ZERO; 40];
    static FINES: [Weight32; 40] = [Weight32::ZERO; 40];
    let (weights, fines) = (any(&WEIGHTS[..]), any(&FINES[..]));
    sink(fixed::dot(fines, weights));
    sink(fixed::squared_norm(fines));
    sink(fixed::squared_distance(fines, weights, mask()));
}

fn functions() {
    sink(fixed::isqrt(any(1)));
    sink(fixed::quotient(any(1), any(2)));
    sink(fixed::q16(any(0.5)));
    sink(fixed::exp2_neg(any(1)));
    sink(fixed::exp_neg(any(1)));
    sink(fixed::log2_ratio(any(1), any(2)));
}

pub fn mask() -> Mask {
    Mask::from_bits(any(1))
}

fn masks() {
    let place = any(3_usize);
    sink((mask().contains(place), mask().covers(place)));
    sink((
        mask().without(place),
        mask().with(place),
        mask().and(any(Mask::ALL)),
    ));
    sink(mask().to_bits());
}

fn schedules() {
    let fall = Schedule::from_q16(any(1), any(2), any(Decay::Linear));
    sink(fall);
    sink(any(fall).at(any(1), any(2)));
    sink(Schedule::constant(any(1)));
}

pub fn displacement() -> Displacement {
    any(Displacement { dx_mm: 1, dy_mm: 2 })
}

pub fn bearing() -> Bearing {
    Bearing::from_turns(any(1))
}

pub fn now() -> Millis {
    Millis::from_ms(any(1))
}

fn moves() {
    let direction = any(Direction { x_q14: 1, y_q14: 2 });
    sink(Bearing::of_place(any(1), any(2)));
    sink((
        bearing().direction(),
        bearing().plus(bearing()),
        bearing().minus(bearing()),
    ));
    sink((
        direction.along(any(1), any(2)),
        direction.times(any(1)),
        direction.rotate(any(1), any(2)),
    ));
    sink(Displacement::saturating(any(1), any(2)));
    sink(Displacement::along(bearing(), any(1)));
    sink((
        displacement().length_mm(),
        displacement().bearing(),
        displacement().with_length(any(1)),
    ));
    sink((
        displacement().plus(displacement()),
        displacement().minus(displacement()),
    ));
    sink(displacement().rotated(direction));
    sink(now().since(now()));
}

pub fn echo() -> Echo {
    Echo {
        range: any(Some(Range::from_mm(any(1)))),
        at: now(),
    }
}

fn scans() {
    let mut scan = any(Scan::<16>::new());
    scan.hear(any(1), echo());
    scan.renew();
    sink((scan.is_complete(mask()), scan.has_heard_all(mask())));
    let encoding = any(Encoding {
        near_mm: 1,
        far_mm: 2,
    });
    let situation = encoding.situation(&scan);
    sink(scan::rotated(&situation, any(3)));
    let kept = memory::to_bytes(&situation, mask());
    sink(memory::from_bytes(&kept));
    if let Some(kept) = bytes().first_chunk::<24>() {
        sink(memory::from_bytes(kept));
    }
}
