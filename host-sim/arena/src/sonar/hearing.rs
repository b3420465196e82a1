//! What one Polaroid transducer can hear from where it is.
//!
//! Rays over the lobe and towards likely places find what the transducer can see. A flat face
//! answers near its normal and is a mirror otherwise; circles and corners answer at any angle. Each
//! answers once, at its nearest point (regions of constant depth, Leonard and Durrant-Whyte).

use core::f64::consts::PI;

use super::config::SonarConfig;
use crate::caster::{Fan, Hit, LobeView, Rays, Surface};
use crate::world::{Point, World};

/// Scratch memory and precomputed directions.
#[derive(Debug, Clone)]
pub(crate) struct Hearing {
    fan: Fan,
    cos_half_angle: f64,
    cos_max_incidence: f64,
    /// Cosine of the angle between axis and normal beyond which a face answers no ray of the lobe.
    least_facing: f64,
    promising: Vec<Point>,
    /// The fan and the promising directions.
    rays: Rays,
    /// Number and nearest answer, m, of each surface met.
    answers: Vec<(f64, f64)>,
}

impl Hearing {
    pub(crate) fn new(config: &SonarConfig, half_angle: f64) -> Self {
        let max_incidence = config.max_incidence_rad.clamp(0.0, PI / 2.0);
        Self {
            fan: Fan::new(config.fan_rays.max(2), half_angle),
            cos_half_angle: libm::cos(half_angle),
            cos_max_incidence: libm::cos(max_incidence),
            // Less by far more than any rounding.
            least_facing: libm::cos((half_angle + max_incidence).min(PI)) - 1e-6,
            promising: Vec::new(),
            rays: Rays::default(),
            answers: Vec::new(),
        }
    }

    /// Range of the first echo after the blanking, m, of what the lobe was aimed at.
    pub(crate) fn first_echo(
        &mut self,
        world: &World,
        lobe: &mut LobeView,
        config: &SonarConfig,
    ) -> Option<f64> {
        self.aim_at_promising(lobe);
        if config.blanking_m > 0.0 || config.bounces > 0 || !self.fan.is_narrow() {
            return self.first_by_rays(world, lobe, config);
        }
        let (least_cos, facing) = (self.cos_max_incidence, self.least_facing);
        let answer = lobe.nearest_answer(&self.fan, &self.promising, least_cos, facing);
        let most = answer.min(config.max_range_m);
        let corner = lobe.nearest_corner(0.0, most).unwrap_or(f64::INFINITY);
        let first = answer.min(corner);
        (first <= config.max_range_m).then_some(first)
    }

    /// The same by all rays.
    #[inline(never)]
    fn first_by_rays(
        &mut self,
        world: &World,
        lobe: &mut LobeView,
        config: &SonarConfig,
    ) -> Option<f64> {
        let mut first = FirstInRange {
            least: config.blanking_m,
            most: config.max_range_m,
            range: None,
        };
        self.hear_rays(lobe, config, &mut first);
        self.follow(world, lobe, config.bounces, &mut first);
        if let Some(corner) = lobe.nearest_corner(first.least, first.range.unwrap_or(first.most)) {
            first.offer(corner);
        }
        first.range
    }

    fn aim_at_promising(&mut self, lobe: &LobeView) {
        let axis = lobe.lobe().axis;
        self.promising.clear();
        for direction in lobe.promising() {
            if direction.dot(axis) >= self.cos_half_angle {
                self.promising.push(direction);
            }
        }
    }

    /// Casts every ray and offers the nearest answer of each surface: one that answers too early
    /// does not answer again.
    fn hear_rays(&mut self, lobe: &LobeView, config: &SonarConfig, first: &mut FirstInRange) {
        let axis = lobe.lobe().axis;
        self.fan.rays().turned_into(axis, &mut self.rays);
        for &direction in &self.promising {
            self.rays.push(direction);
        }
        lobe.meet(&mut self.rays, config.max_range_m);
        self.note_answers();
        self.answers
            .iter()
            .for_each(|&(_, range)| first.offer(range));
    }

    /// Follows the rays of the fan that faces mirror, up to `bounces` times.
    fn follow(&self, world: &World, lobe: &LobeView, bounces: usize, first: &mut FirstInRange) {
        let tip = lobe.lobe().tip;
        let met = self.rays.ways().iter().zip(self.rays.cos_incidences());
        for (ray, (&length, &cos)) in met.enumerate().take(self.fan.count()) {
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
struct FirstInRange {
    least: f64,
    most: f64,
    range: Option<f64>,
}

impl FirstInRange {
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
