//! How long the robot takes to look around and to move: what a simulated step costs without its
//! mind.

use arena::noise::Noise;
use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::{Ring, SonarModel};
use arena::world::{Point, Pose, World};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

/// Places where the robot fits, with a heading each.
fn poses(world: &World, count: usize) -> Vec<Pose> {
    let mut noise = Noise::new(1);
    let mut poses = Vec::new();
    while poses.len() < count {
        let place = Point::new(noise.uniform_in(-3.7, 3.7), noise.uniform_in(-3.7, 3.7));
        if !world.is_inside(place) && world.clearance(place) > COLLISION_RADIUS_M {
            poses.push(Pose::new(place, noise.uniform_in(-3.0, 3.0)));
        }
    }
    poses
}

fn sense(c: &mut Criterion) {
    let world = World::random(1);
    let poses = poses(&world, 256);
    let mut noise = Noise::new(2);
    let mut turn = 0;
    let mut next = move || {
        turn = (turn + 1) % 256;
        turn
    };

    let mut ring = Ring::new(SonarModel::Ideal, &mut noise);
    let mut readings = [None; 16];
    c.bench_function("scan of 16, random room of 52 segments", |b| {
        b.iter(|| {
            ring.scan(&world, black_box(&poses[next()]), &mut readings);
            readings[3]
        });
    });
    c.bench_function("sweep of 0.25 m", |b| {
        b.iter(|| {
            let pose = &poses[next()];
            let to = pose.position + Point::new(0.25, 0.0);
            world.sweep(black_box(pose.position), black_box(to), COLLISION_RADIUS_M)
        });
    });
    c.bench_function("clearance", |b| {
        b.iter(|| world.clearance(black_box(poses[next()].position)));
    });
    for model in [SonarModel::Nomad, SonarModel::Harsh] {
        let mut ring = Ring::new(model, &mut noise);
        c.bench_function(&format!("ping, {}", model.name()), |b| {
            let mut time_s = 0.0;
            b.iter(|| {
                let turn = next();
                time_s += 0.04;
                ring.ping(
                    &world,
                    black_box(&poses[turn]),
                    turn % 16,
                    time_s,
                    &mut noise,
                )
            });
        });
    }
}

criterion_group!(benches, sense);
criterion_main!(benches);
