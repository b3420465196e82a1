//! Rejected worlds.

use super::*;

fn wall(points: &[(f64, f64)]) -> Shape {
    Shape::Wall {
        points: points.iter().map(|&(x, y)| Point::new(x, y)).collect(),
    }
}

fn post(radius: f64) -> Shape {
    Shape::Circle {
        center: Point::default(),
        radius,
    }
}

fn square(side: f64) -> Shape {
    Shape::Box {
        center: Point::default(),
        size: Point::new(side, side),
        angle: 0.0,
    }
}

#[test]
fn invalid_worlds_are_rejected() {
    let start = |x| Pose::new(Point::new(x, 0.0), 0.0);
    for (shapes, start, words) in [
        (vec![], start(0.0), "at least one"),
        (vec![square(2.0)], start(0.0), "inside something"),
        (vec![post(5.0)], start(1.0), "inside something"),
        (
            vec![wall(&[(0.2, -1.0), (0.2, 1.0)])],
            start(0.0),
            "inside something",
        ),
        (
            vec![wall(&[(0.2, -1.0), (0.2, 1.0)])],
            start(f64::NAN),
            "the start",
        ),
        (vec![wall(&[(0.2, -1.0)])], start(9.0), "at least 2"),
    ] {
        let error = World::new("w", start, shapes).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(World::new("w", start(0.0), vec![wall(&[(0.27, -1.0), (0.27, 1.0)])]).is_ok());
}
