//! Counts what an echo costs a memory that is full of points.

use crate::room::SquareRoom;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::config::Config;
use amp::points::{Beam, PointLimits, PointMemory};
use amp::units::{Bearing, Displacement, Range};
use core::hint::black_box;

/// Rings that the robot hears on its way around the room.
const RINGS: usize = 64;
const LEG_MM: i32 = 200;
/// The first rings fill the memory.
const FULL: usize = 200;

/// Echoes of a ring of 16 sensors, taken by a memory of 256 points.
pub fn echoes(watch: &Stopwatch) -> InstructionStats {
    let robot = Config::recommended().robot;
    let mut points = PointMemory::<256>::new();
    let mut room = SquareRoom::new();
    let mut counts = InstructionStats::default();
    for ring in 0..RINGS {
        for sensor in 0..16 {
            let axis = Bearing::of_place(sensor, 16);
            let beam = Beam {
                mount: Displacement::along(axis, robot.face_radius_mm.into()),
                axis,
                range: Range::from_mm(room.range_mm(sensor)),
                is_echo: true,
            };
            let is_full = points.len() >= FULL;
            let (instructions, ()) = watch.count(|| {
                let (points, beam) = (black_box(&mut points), black_box(&beam));
                points.hear(black_box(&PointLimits::NOMAD), beam);
            });
            if is_full {
                counts.add(instructions);
            }
        }
        let moved = room.drive(Displacement::along(Bearing::of_place(ring, 10), LEG_MM));
        points.moved(&PointLimits::NOMAD, moved, Bearing::ZERO);
    }
    counts
}
