//! What one Polaroid transducer can hear from where it is.
//!
//! A fan of rays over the lobe, and one ray at each place most likely to answer, find what the transducer
//! can see; what is hidden is met by no ray. A flat face answers where the sound meets it near its normal,
//! and is a mirror otherwise. A circle answers wherever it is met. A corner or edge answers from its tip, at
//! any angle. Each thing answers once, with its nearest answering point (Leonard and Durrant-Whyte's
//! regions of constant depth come out of that).

use core::f64::consts::PI;

use super::SonarConfig;
use crate::world::{Hit, LobeView, Point, Rays, Surface, World};

/// How much nearer than a corner a ray may end and still be said to reach it, m.
const CORNER_SLACK_M: f64 = 1e-6;

/// Scratch memory and precomputed directions.
#[derive(Debug, Clone)]
pub(super) struct Hearing {
    /// The fan, relative to the axis, and how many rays it has.
    fan: Rays,
    fan_rays: usize,
    cos_half_angle: f64,
    cos_max_incidence: f64,
    /// The fan and the promising directions.
    rays: Rays,
    to_corners: Rays,
    /// How far the corners are at the end of `to_corners`, m.
    corners: Vec<f64>,
    /// Number and nearest answer, m, of each surface met.
    answers: Vec<(f64, f64)>,
}

impl Hearing {
    pub(super) fn new(config: &SonarConfig, half_angle: f64) -> Self {
        let fan_rays = config.fan_rays.max(2);
        let step = 2.0 * half_angle / (fan_rays - 1) as f64;
        let mut fan = Rays::default();
        (0..fan_rays).for_each(|i| fan.push(Point::unit(step * i as f64 - half_angle)));
        Self {
            fan,
            fan_rays,
            cos_half_angle: libm::cos(half_angle),
            cos_max_incidence: libm::cos(config.max_incidence_rad.clamp(0.0, PI / 2.0)),
            rays: Rays::default(),
            to_corners: Rays::default(),
            corners: Vec::new(),
            answers: Vec::new(),
        }
    }

    /// Range of the first echo after the blanking, m.
    pub(super) fn first_echo(
        &mut self,
        world: &World,
        lobe: &LobeView,
        tip: Point,
        axis: Point,
        config: &SonarConfig,
    ) -> Option<f64> {
        self.fan.turned_into(axis, &mut self.rays);
        for direction in lobe.promising() {
            if direction.dot(axis) >= self.cos_half_angle {
                self.rays.push(direction);
            }
        }
        let mut first = Nearest {
            least: config.blanking_m,
            most: config.max_range_m,
            range: None,
        };
        let least_cos = self.cos_max_incidence;
        if config.blanking_m > 0.0 {
            // What answers too early answers no more: the nearest answer of each surface has to be known.
            lobe.meet(&mut self.rays, |_| config.max_range_m);
            self.note_answers();
            self.answers
                .iter()
                .for_each(|&(_, range)| first.offer(range));
        } else {
            let mut nearest = f64::INFINITY;
            lobe.meet(&mut self.rays, |rays| {
                nearest = rays.nearest(least_cos);
                nearest.min(config.max_range_m)
            });
            first.offer(nearest);
        }
        if config.bounces > 0 {
            self.follow(world, lobe, tip, config.bounces, &mut first);
        }
        self.hear_corners(lobe, axis, &mut first);
        first.range
    }

    /// Offers the corners that nothing hides.
    fn hear_corners(&mut self, lobe: &LobeView, axis: Point, first: &mut Nearest) {
        self.to_corners.clear();
        self.corners.clear();
        let mut farthest = 0.0;
        for &(corner, range) in lobe.corners() {
            if first.wants(range) {
                let towards = if range > 0.0 {
                    corner * (1.0 / range)
                } else {
                    axis
                };
                self.to_corners.push(towards);
                self.corners.push(range);
                farthest = range.max(farthest);
            }
        }
        if self.corners.is_empty() {
            return;
        }
        lobe.meet(&mut self.to_corners, |_| farthest);
        for (&range, &way) in self.corners.iter().zip(self.to_corners.ways()) {
            if way >= range - CORNER_SLACK_M {
                first.offer(range);
            }
        }
    }

    /// Lets the rays of the fan go on as mirrored by the faces they meet too obliquely, up to `bounces` times.
    fn follow(
        &self,
        world: &World,
        lobe: &LobeView,
        tip: Point,
        bounces: usize,
        first: &mut Nearest,
    ) {
        let met = self.rays.ways().iter().zip(self.rays.cos_incidences());
        for (ray, (&length, &cos)) in met.enumerate().take(self.fan_rays) {
            if cos >= self.cos_max_incidence {
                continue;
            }
            let number = self.rays.numbers().get(ray);
            let Some(mut normal) = number.and_then(|&number| lobe.normal(number)) else {
                continue;
            };
            let (mut at, mut direction) = (tip, self.rays.direction(ray));
            let (mut last_way, mut way) = (length, length);
            for _ in 0..bounces {
                at = at + direction * last_way;
                direction = direction - normal * (2.0 * direction.dot(normal));
                let Some(next) = world.cast(at, direction) else {
                    break;
                };
                way += next.distance_m;
                if self.answers_from(&next) {
                    first.offer(way);
                    break;
                }
                (last_way, normal) = (next.distance_m, next.normal);
            }
        }
    }

    fn answers_from(&self, hit: &Hit) -> bool {
        matches!(hit.surface, Surface::Circle(_)) || hit.cos_incidence >= self.cos_max_incidence
    }

    /// Keeps the nearest answer of each surface.
    fn note_answers(&mut self) {
        self.answers.clear();
        let least_cos = self.cos_max_incidence;
        let met = self.rays.ways().iter().zip(self.rays.cos_incidences());
        for ((&way, &cos), &number) in met.zip(self.rays.numbers()) {
            if cos < least_cos {
                continue;
            }
            match self.answers.iter_mut().find(|(known, _)| *known == number) {
                Some((_, nearest)) => *nearest = nearest.min(way),
                None => self.answers.push((number, way)),
            }
        }
    }
}

/// The least range offered that lies within limits.
struct Nearest {
    least: f64,
    most: f64,
    range: Option<f64>,
}

impl Nearest {
    fn offer(&mut self, range: f64) {
        if self.wants(range) {
            self.range = Some(range);
        }
    }

    fn wants(&self, range: f64) -> bool {
        let better = self.range.is_none_or(|known| range < known);
        better && range >= self.least && range <= self.most
    }
}
