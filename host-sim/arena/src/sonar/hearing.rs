//! The first echo of one Polaroid transducer.
//!
//! Rays over the lobe, and towards likely reflectors, find the visible surfaces. A flat face
//! returns an echo near its normal and is a mirror otherwise; circles and corners return one at any
//! angle. Each surface returns one echo, from its nearest point (regions of constant depth, Leonard
//! and Durrant-Whyte).

use core::f64::consts::PI;

use super::config::SonarConfig;
use crate::caster::{Fan, Hit, LobeHit, LobeView, Surface};
use crate::world::{Point, World};

/// Search for the first echo: precomputed directions and scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Hearing {
    fan: Fan,
    cos_half_angle: f64,
    cos_max_incidence: f64,
    /// Cosine of the largest angle between axis and normal at which a face can return an echo.
    least_facing: f64,
    promising: Vec<Point>,
    /// Rays of the fan and their first hits.
    fan_hits: Vec<(Point, LobeHit)>,
    surface_echoes: SurfaceEchoes,
}

impl Hearing {
    pub(crate) fn new(config: &SonarConfig, half_angle: f64) -> Self {
        let max_incidence = config.max_incidence_rad.clamp(0.0, PI / 2.0);
        Self {
            fan: Fan::new(config.fan_rays.max(2), half_angle),
            cos_half_angle: libm::cos(half_angle),
            cos_max_incidence: libm::cos(max_incidence),
            // The margin exceeds any rounding error.
            least_facing: libm::cos((half_angle + max_incidence).min(PI)) - 1e-6,
            promising: Vec::new(),
            fan_hits: Vec::new(),
            surface_echoes: SurfaceEchoes::default(),
        }
    }

    /// Range of the first echo after the blanking, m, for a lobe that is aimed.
    pub(crate) fn first_echo(
        &mut self,
        world: &World,
        lobe: &mut LobeView,
        config: &SonarConfig,
    ) -> Option<f64> {
        self.collect_promising(lobe);
        if config.blanking_m > 0.0 || config.bounces > 0 || !self.fan.is_narrow() {
            return self.first_echo_by_rays(world, lobe, config);
        }
        let (least_cos, facing) = (self.cos_max_incidence, self.least_facing);
        let answer = lobe.nearest_answer(&self.fan, &self.promising, least_cos, facing);
        let max_range = answer.min(config.max_range_m);
        let corner = lobe.nearest_corner(0.0, max_range).unwrap_or(f64::INFINITY);
        let first = answer.min(corner);
        (first <= config.max_range_m).then_some(first)
    }

    /// As [`first_echo`](Self::first_echo), by casting every ray.
    #[inline(never)]
    fn first_echo_by_rays(
        &mut self,
        world: &World,
        lobe: &mut LobeView,
        config: &SonarConfig,
    ) -> Option<f64> {
        let mut first = FirstInRange {
            min: config.blanking_m,
            max: config.max_range_m,
            range: None,
        };
        self.cast_rays(lobe, &mut first);
        self.follow_reflections(world, lobe, config.bounces, &mut first);
        if let Some(corner) = lobe.nearest_corner(first.min, first.range.unwrap_or(first.max)) {
            first.offer(corner);
        }
        first.range
    }

    fn collect_promising(&mut self, lobe: &LobeView) {
        let axis = lobe.lobe().axis;
        self.promising.clear();
        for direction in lobe.promising() {
            if direction.dot(axis) >= self.cos_half_angle {
                self.promising.push(direction);
            }
        }
    }

    /// Casts every ray and offers the nearest echo of each surface. A surface whose nearest echo is
    /// blanked gives no later echo.
    fn cast_rays(&mut self, lobe: &LobeView, first: &mut FirstInRange) {
        let axis = lobe.lobe().axis;
        self.fan_hits.clear();
        self.surface_echoes.clear();
        for direction in self.fan.directions() {
            let ray = direction.turned(axis);
            if let Some(hit) = lobe.cast(ray) {
                self.fan_hits.push((ray, hit));
                self.surface_echoes.add(&hit, self.cos_max_incidence);
            }
        }
        for &ray in &self.promising {
            if let Some(hit) = lobe.cast(ray) {
                self.surface_echoes.add(&hit, self.cos_max_incidence);
            }
        }
        for &(_, range) in &self.surface_echoes.nearest {
            first.offer(range);
        }
    }

    /// Follows the rays of the fan that faces reflect, up to `bounces` times.
    fn follow_reflections(
        &self,
        world: &World,
        lobe: &LobeView,
        bounces: usize,
        first: &mut FirstInRange,
    ) {
        let tip = lobe.lobe().tip;
        for (ray, hit) in &self.fan_hits {
            let Some(mut normal) = hit.normal else {
                continue;
            };
            if hit.cos_incidence >= self.cos_max_incidence {
                continue;
            }
            let (mut at, mut direction) = (tip, *ray);
            let (mut last_m, mut total_m) = (hit.distance_m, hit.distance_m);
            for _ in 0..bounces {
                at = at + direction * last_m;
                direction = direction - normal * (2.0 * direction.dot(normal));
                let Some(next) = world.cast(at, direction) else {
                    break;
                };
                total_m += next.distance_m;
                if self.returns_echo(&next) {
                    first.offer(total_m);
                    break;
                }
                (last_m, normal) = (next.distance_m, next.normal);
            }
        }
    }

    fn returns_echo(&self, hit: &Hit) -> bool {
        matches!(hit.surface, Surface::Circle(_)) || hit.cos_incidence >= self.cos_max_incidence
    }
}

/// The nearest echo of each surface.
#[derive(Debug, Clone, Default)]
struct SurfaceEchoes {
    /// Number of the surface, and distance of its echo, m.
    nearest: Vec<(f64, f64)>,
}

impl SurfaceEchoes {
    fn clear(&mut self) {
        self.nearest.clear();
    }

    /// Adds a hit if it returns an echo: if its cosine is at least `min_cos`.
    fn add(&mut self, hit: &LobeHit, min_cos: f64) {
        if hit.cos_incidence < min_cos {
            return;
        }
        let mut known = self.nearest.iter_mut();
        match known.find(|(number, _)| *number == hit.number) {
            Some((_, nearest)) => *nearest = nearest.min(hit.distance_m),
            None => self.nearest.push((hit.number, hit.distance_m)),
        }
    }
}

/// The smallest offered range within limits.
struct FirstInRange {
    min: f64,
    max: f64,
    range: Option<f64>,
}

impl FirstInRange {
    fn offer(&mut self, range: f64) {
        if self.improves(range) {
            self.range = Some(range);
        }
    }

    fn improves(&self, range: f64) -> bool {
        let better = self.range.is_none_or(|known| range < known);
        better && range >= self.min && range <= self.max
    }
}
