//! Histogram grid: a square window of cells around the robot, each with a count of its echoes.
//!
//! J. Borenstein and Y. Koren, *Histogramic in-motion mapping*, IEEE Transactions on Robotics and
//! Automation 7(4), 1991, 535–539. An echo adds 3 to its cell (15 at most) and subtracts 1 from
//! each cell before it. Cells are fixed in the frame of dead reckoning.

use arena::sonar::FACE_RADIUS_M;
use arena::world::Point;
use sim::ring_pilot::{Perception, axis};

/// Side of a cell, m.
pub const CELL_M: f64 = 0.1;
/// Cells along a side of the window.
pub const SIDE: i32 = 33;
/// Least distance from the robot's cell to the edge of the window, m.
pub const REACH_M: f64 = (SIDE / 2) as f64 * CELL_M;

const HIT: u8 = 3;
const MAX_COUNT: u8 = 15;

/// Counts of recent echoes, by cell.
#[derive(Debug, Clone)]
pub struct CertaintyGrid {
    /// The window wraps: cell (column, row) has the index of both modulo [`SIDE`].
    counts: Vec<u8>,
    /// The cell with the robot.
    middle: [i32; 2],
}

impl Default for CertaintyGrid {
    fn default() -> Self {
        Self {
            counts: vec![0; (SIDE * SIDE) as usize],
            middle: [0, 0],
        }
    }
}

impl CertaintyGrid {
    /// Moves the window to the robot and adds a complete ring.
    pub fn hear(&mut self, perceived: &Perception) {
        self.move_to(cell(perceived.pose.position));
        let heading = Point::unit(perceived.pose.heading);
        for sensor in 0..16 {
            let axis = axis(sensor).turned(heading);
            let range = perceived.range_m(sensor);
            let face = perceived.pose.position + axis * FACE_RADIUS_M;
            let hit = range.is_finite().then(|| cell(face + axis * range));
            self.clear(face, axis, range.min(REACH_M), hit);
            if let Some(count) = hit.and_then(|hit| self.count_mut(hit)) {
                *count = count.saturating_add(HIT).min(MAX_COUNT);
            }
        }
    }

    /// Subtracts 1 from every cell along the axis except the cell of the echo.
    fn clear(&mut self, face: Point, axis: Point, range: f64, hit: Option<[i32; 2]>) {
        let mut last = None;
        let samples = (range / (CELL_M / 2.0)) as i32;
        for sample in 0..samples {
            let place = cell(face + axis * (f64::from(sample) * (CELL_M / 2.0)));
            if last != Some(place)
                && hit != Some(place)
                && let Some(count) = self.count_mut(place)
            {
                *count = count.saturating_sub(1);
            }
            last = Some(place);
        }
    }

    /// Clears the cells that enter the window.
    fn move_to(&mut self, middle: [i32; 2]) {
        let before = self.middle;
        if before == middle {
            return;
        }
        self.middle = middle;
        let half = SIDE / 2;
        for row in middle[1] - half..=middle[1] + half {
            for column in middle[0] - half..=middle[0] + half {
                let was_inside =
                    (column - before[0]).abs() <= half && (row - before[1]).abs() <= half;
                if !was_inside && let Some(count) = self.count_mut([column, row]) {
                    *count = 0;
                }
            }
        }
    }

    fn count_mut(&mut self, [column, row]: [i32; 2]) -> Option<&mut u8> {
        let half = SIDE / 2;
        if (column - self.middle[0]).abs() > half || (row - self.middle[1]).abs() > half {
            return None;
        }
        self.counts.get_mut(index(column, row))
    }

    /// Cells with a count: the vector from `place` to each center (m) and the count, 1 … 15.
    pub fn occupied(&self, place: Point) -> impl Iterator<Item = (Point, u8)> + '_ {
        let half = SIDE / 2;
        let [column0, row0] = self.middle;
        (row0 - half..=row0 + half).flat_map(move |row| {
            (column0 - half..=column0 + half).filter_map(move |column| {
                let count = self.counts.get(index(column, row)).copied().unwrap_or(0);
                let middle = |cell: i32| (f64::from(cell) + 0.5) * CELL_M;
                (count > 0).then(|| (Point::new(middle(column), middle(row)) - place, count))
            })
        })
    }
}

fn cell(place: Point) -> [i32; 2] {
    [place.x, place.y].map(|m| libm::floor(m / CELL_M) as i32)
}

fn index(column: i32, row: i32) -> usize {
    (row.rem_euclid(SIDE) * SIDE + column.rem_euclid(SIDE)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::units::{Bearing, Range};
    use arena::world::Pose;

    fn at(place: Point, sensor: usize, range_mm: u16) -> Perception {
        let mut ranges = [None; 16];
        ranges[sensor] = Some(Range::from_mm(range_mm));
        Perception {
            ranges,
            pose: Pose::new(place, 0.0),
            turned: Bearing::ZERO,
            last: None,
        }
    }

    #[test]
    fn echoes_add_three_and_what_lies_before_them_fades() {
        let mut grid = CertaintyGrid::default();
        let place = Point::new(0.05, 0.05);
        let found = |grid: &CertaintyGrid| grid.occupied(place).collect::<Vec<_>>();
        for expected in [3, 6, 9, 12, 15, 15] {
            // 0.05 + 0.2305 + 0.8 is in the cell from 1.0 to 1.1 m.
            grid.hear(&at(place, 0, 800));
            let cells = found(&grid);
            assert_eq!(cells.len(), 1);
            assert!(cells[0].0.distance(Point::new(1.0, 0.0)) < 1e-9);
            assert_eq!(cells[0].1, expected);
        }
        // A farther echo clears the cell before it.
        grid.hear(&at(place, 0, 1_100));
        assert_eq!(
            found(&grid).iter().map(|cell| cell.1).collect::<Vec<_>>(),
            [14, 3]
        );
    }

    #[test]
    fn the_window_goes_with_the_robot_and_forgets_what_it_leaves() {
        let mut grid = CertaintyGrid::default();
        grid.hear(&at(Point::default(), 0, 800));
        let near = Point::new(-0.5, 0.0);
        grid.hear(&at(near, 8, 6_000));
        let kept: Vec<_> = grid.occupied(near).collect();
        assert_eq!(kept.len(), 1);
        assert!(kept[0].0.distance(Point::new(1.55, 0.05)) < 1e-9);
        grid.hear(&at(Point::new(-5.0, 0.0), 8, 6_000));
        grid.hear(&at(Point::default(), 8, 6_000));
        assert_eq!(grid.occupied(Point::default()).count(), 0);
    }
}
