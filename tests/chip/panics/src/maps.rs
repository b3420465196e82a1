//! Maps: search, training, quality measures, recall.

use crate::arithmetic::{displacement, mask, weight};
use crate::{any, sink};
use amp::action_map::{ActionCode, ActionMap, Effect, Preference, Probe, Recall};
use amp::fixed::Weight32;
use amp::som::{Decay, Edges, Grid, Neighborhood, SampleOrder, Schedule, Som, TrainConfig, Update};

pub fn all() {
    grids();
    learning();
    som();
    actions();
}

pub fn grid() -> Grid {
    any(Grid::rectangle(any(4), any(4)).with_edges(any(Edges::Open)))
}

fn grids() {
    let (a, b) = (any(1_usize), any(2_usize));
    sink((grid().position(a), grid().offsets(a, b), grid().hops(a, b)));
    sink((grid().len(), grid().are_neighbors(a, b)));
    grid().neighbors(a).for_each(sink);
    sink(Grid::chain(any(3)));
}

fn shape() -> Neighborhood {
    any(Neighborhood::Direct)
}

fn learning() {
    update().for_each(grid(), any(3), |k, gain| sink((k, gain)));
    sink(update().is_alone());
    sink(Update::new(shape(), any(0.5), any(1.5)));
}

fn update() -> Update {
    Update::from_q16(shape(), any(1), any(2))
}

fn train_config() -> TrainConfig {
    TrainConfig {
        neighborhood: shape(),
        rate: Schedule::new(any(0.5), any(0.1), any(Decay::Linear)),
        radius: Schedule::new(any(1.5), any(0.1), any(Decay::Linear)),
        epochs: any(3),
        order: any(SampleOrder::Shuffled),
    }
}

fn som() {
    let mut som = any(Som::<16, 16>::new(grid(), any([[weight(); 16]; 16])));
    let probe = any([weight(); 16]);
    sink(som.bmu(&probe, mask()));
    sink((
        som.scores(&probe, mask()),
        som.distance(any(3), &probe, mask()),
        som.code_vector(any(3)),
    ));
    sink((
        som.alignments(&probe, mask()),
        som.projections(&probe, mask()),
    ));
    let actions = any(Som::<16, 2>::zeroed(grid()));
    sink(som.joint_bmu(&probe, mask(), &actions, &[weight(); 2], any(3)));
    som.update(any(3), &probe, mask(), &update());
    sink(som.train_step(&probe, mask(), &update()));
    som.train(any(&mut [probe; 3][..]), &train_config(), any);
    let (quality, hits) = som.quality(any(&[probe; 3][..]));
    sink((
        hits,
        quality.quantization_error(),
        quality.topographic_error(),
    ));
    sink((som.novelty(&probe, &quality), quality.largest_novelty()));
    sink((quality.largest_distance(), som.u_matrix()));
    som.set_code_vector(any(3), &probe);
    som.set_component(any(3), any(Weight32::ZERO));
    sink(som.component(any(3)));
    som.clear();
    sink(som);
}

fn actions() {
    let mut map = any(ActionMap::<16, 16>::zeroed(grid()));
    let effect = any(Effect {
        change: [weight(); 16],
        action: [weight(); 2],
        mask: mask(),
    });
    sink(map.bmu(&effect, any(256)));
    map.update(any(3), &effect, &update());
    let probe = any(Probe {
        recall: Recall::Distance,
        preference: Some(Preference {
            code: [weight(); 2],
            weight_q8: 1,
        }),
    });
    sink(map.recall(&effect.change, mask(), probe, mask()));
    sink(map);
    let code = any(ActionCode::Displacement);
    sink(code.encode(displacement(), any(250)));
    sink(code.decode(any([weight(); 2]), any(250)));
}
