//! Maps: kernels on slices of any length, maps of fixed size, quality measures, recall.

use crate::arithmetic::{displacement, mask, weight};
use crate::{any, sink};
use amp::action_map::{ActionCode, ActionMap, Effect, Preference, Probe, Recall};
use amp::fixed::{Gain, Weight, Weight32};
use amp::som::metrics::{MapView, Quality, u_matrix_value};
use amp::som::neighborhood::{Update, View, gaussian};
use amp::som::{Edges, Grid, Neighborhood, Som, kernels};

pub fn all() {
    grids();
    searches();
    learning();
    metrics();
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

fn code() -> &'static [Weight32] {
    static CODE: [Weight32; 300] = [Weight32::ZERO; 300];
    any(&CODE[..])
}

fn probe() -> &'static [Weight] {
    static PROBE: [Weight; 40] = [Weight::ZERO; 40];
    any(&PROBE[..])
}

fn norms() -> impl Iterator<Item = i64> + Clone {
    static NORMS: [i64; 16] = [0; 16];
    any(&NORMS[..]).iter().copied()
}

fn searches() {
    let mut room = any([0_i64; 32]);
    let room = any(&mut room[..]);
    let dims = any(16_usize);
    kernels::scores(code(), norms(), dims, probe(), room);
    kernels::scores_masked(code(), dims, probe(), mask(), room);
    kernels::projections(code(), dims, probe(), mask(), room);
    kernels::alignments(code(), norms(), dims, probe(), mask(), room);
    sink((
        kernels::least(room),
        kernels::greatest(room, mask()),
        kernels::two_least(room),
    ));
    let distance = |k| kernels::distance(code(), dims, k, probe(), mask());
    sink(kernels::nearest(room, dims, any(1), distance));
}

fn shape() -> Neighborhood {
    any(Neighborhood::Direct)
}

fn learning() {
    let mut axis = any([Gain::ZERO; 20]);
    gaussian(any(1), any(&mut axis[..]));
    let view = View::new(shape(), any(1), any(2), any(&mut axis[..]));
    view.each(grid(), any(3), |k, gain| sink((k, gain)));
}

fn metrics() {
    let view = MapView {
        grid: grid(),
        code: code(),
        dims: any(16),
    };
    let mut room = any([0_i64; 32]);
    let mut quality = any(Quality::default());
    sink(quality.add(view, probe(), any(&mut room[..])));
    sink((
        quality.quantization_error_q21(),
        quality.topographic_error_q16(),
    ));
    sink(u_matrix_value(view, any(3)));
}

fn pull() -> Update<16> {
    Update::new(shape(), any(1), any(2))
}

fn som() {
    let mut som = any(Som::<16, 16>::new(grid(), any([[weight(); 16]; 16])));
    let probe = any([weight(); 16]);
    sink(som.winner(&probe, mask()));
    sink((
        som.scores(&probe),
        som.distance(any(3), &probe, mask()),
        som.code_vector(any(3)),
    ));
    sink((
        som.alignments(&probe, mask()),
        som.projections(&probe, mask()),
    ));
    som.learn(any(3), &probe, mask(), &pull());
    sink(som.quality(any(&[probe; 3][..])));
    sink(som.u_matrix());
    sink(som);
}

fn actions() {
    let mut map = any(ActionMap::<16, 16>::zeroed(grid()));
    let effect = any(Effect {
        change: [weight(); 16],
        action: [weight(); 2],
        mask: mask(),
    });
    sink(map.winner(&effect, any(256)));
    map.learn(any(3), &effect, &pull());
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
