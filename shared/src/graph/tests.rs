use super::*;

const AHEAD: Displacement = Displacement {
    dx_mm: 250,
    dy_mm: 0,
};
const LEFT: Displacement = Displacement {
    dx_mm: 0,
    dy_mm: 250,
};

/// Drives 0 → 1 → 2 → 3 ahead, two moves in each neuron.
fn corridor(times: usize) -> TraversedGraph<16> {
    let mut graph = TraversedGraph::new();
    for _ in 0..times {
        graph.interrupt();
        for neuron in [0, 0, 1, 1, 2, 2, 3] {
            graph.observe(neuron, AHEAD);
        }
    }
    graph
}

/// Puts the robot into neuron 1, from 0.
fn enter(graph: &mut TraversedGraph<16>) {
    graph.interrupt();
    for neuron in [0, 1] {
        graph.observe(neuron, AHEAD);
    }
}

#[test]
fn a_chain_of_passages_leads_to_the_goal() {
    let mut graph = corridor(1);
    enter(&mut graph);
    let to = |to| Some(Aim { to, way: AHEAD });
    assert_eq!(graph.aim(3, 250), to(2));
    // The aim is kept while the neuron is the same.
    graph.observe(1, AHEAD);
    assert_eq!(graph.aim(3, 250), to(2));
    graph.observe(2, AHEAD);
    assert_eq!(graph.aim(3, 250), to(3));
    graph.observe(3, AHEAD);
    assert_eq!(graph.aim(3, 250), None);
}

#[test]
fn what_was_not_traversed_is_no_way() {
    let mut graph = corridor(1);
    enter(&mut graph);
    assert_eq!(graph.aim(0, 250), None);
    assert_eq!(graph.aim(9, 250), None);
    // Not from where it came this time.
    graph.interrupt();
    for neuron in [5, 1] {
        graph.observe(neuron, LEFT);
    }
    assert_eq!(graph.aim(3, 250), None);
    assert_eq!(TraversedGraph::<16>::new().aim(3, 250), None);
}

#[test]
fn the_cheaper_chain_is_taken_and_the_first_on_ties() {
    let mut graph = TraversedGraph::<16>::new();
    let mut drive = |path: &[usize]| {
        graph.interrupt();
        path.iter().for_each(|&neuron| graph.observe(neuron, AHEAD));
    };
    drive(&[0, 1, 4, 4, 4, 4, 3]);
    drive(&[0, 1, 2, 3]);
    drive(&[0, 1, 6, 3]);
    enter(&mut graph);
    assert_eq!(graph.aim(3, 250).map(|aim| aim.to), Some(2));
}

#[test]
fn each_passage_of_a_chain_came_from_the_one_before() {
    let mut graph = TraversedGraph::<16>::new();
    let mut drive = |path: &[usize]| {
        graph.interrupt();
        path.iter().for_each(|&neuron| graph.observe(neuron, AHEAD));
    };
    drive(&[0, 1, 2, 3]);
    drive(&[5, 1, 1, 1, 4, 4, 4, 3]);
    drive(&[8, 2, 9]);
    drive(&[5, 1]);
    // The cheaper way of who came from 0 is none for who came from 5.
    assert_eq!(graph.aim(3, 250).map(|aim| aim.to), Some(4));
    enter(&mut graph);
    assert_eq!(graph.aim(3, 250).map(|aim| aim.to), Some(2));
    enter(&mut graph);
    assert_eq!(graph.aim(9, 250), None);
}

#[test]
fn an_aim_given_up_at_the_goal_is_no_failed_aim() {
    let mut graph = corridor(1);
    for _ in 0..3 {
        enter(&mut graph);
        assert!(graph.aim(3, 250).is_some());
        assert_eq!(graph.aim(1, 250), None);
        graph.observe(7, AHEAD);
    }
    enter(&mut graph);
    assert_eq!(graph.aim(3, 250).map(|aim| aim.to), Some(2));
}

#[test]
fn an_aim_that_fails_three_times_is_forgotten() {
    let mut graph = corridor(1);
    for tried in 0..3 {
        enter(&mut graph);
        assert_eq!(graph.aim(3, 250).map(|aim| aim.to), Some(2), "{tried}");
        graph.observe(7, AHEAD);
    }
    enter(&mut graph);
    assert_eq!(graph.aim(3, 250), None);
}

#[test]
fn a_leg_that_does_not_end_is_a_failed_aim() {
    let mut graph = corridor(1);
    for _ in 0..3 {
        enter(&mut graph);
        assert!(graph.aim(3, 250).is_some());
        for _ in 0..13 {
            graph.observe(1, AHEAD);
        }
    }
    enter(&mut graph);
    assert_eq!(graph.aim(3, 250), None);
}

#[test]
fn the_whole_way_is_gone_and_then_the_last_move_repeated() {
    let mut graph = TraversedGraph::<16>::new();
    for (neuron, moved) in [(0, AHEAD), (1, AHEAD), (1, LEFT), (1, LEFT), (3, AHEAD)] {
        graph.observe(neuron, moved);
    }
    enter(&mut graph);
    let way = |graph: &mut TraversedGraph<16>| graph.aim(3, 250).map(|aim| aim.way);
    let diagonal = way(&mut graph).expect("a way");
    assert_eq!((diagonal.dx_mm, diagonal.dy_mm), (112, 224));
    graph.observe(1, LEFT);
    graph.observe(1, LEFT);
    assert_eq!(way(&mut graph), Some(AHEAD));
    graph.observe(1, AHEAD);
    assert_eq!(way(&mut graph), Some(AHEAD));
}

#[test]
fn counts_decay_and_stay_within_bounds() {
    let mut graph = corridor(300);
    enter(&mut graph);
    for times in 0..300 {
        assert_eq!(graph.aim(3, 250).map(|aim| aim.to), Some(2), "{times}");
        graph.observe(2, AHEAD);
        enter(&mut graph);
    }
    let used = graph.passages.iter().flatten().filter(|one| one.is_used());
    let bounded = |one: &Passage| one.traversals <= 60 && one.tries <= 20 && one.hits <= one.tries;
    assert!(used.clone().all(bounded) && used.count() > 0);
}

#[test]
fn more_neighbors_than_slots_replace_the_rarest() {
    let mut graph = TraversedGraph::<64>::new();
    for _ in 0..2 {
        for neuron in [0, 1, 2] {
            graph.observe(neuron, AHEAD);
        }
        graph.interrupt();
    }
    for other in 3..40 {
        graph.interrupt();
        for neuron in [0, 1, other] {
            graph.observe(neuron, AHEAD);
        }
    }
    graph.interrupt();
    for neuron in [0, 1] {
        graph.observe(neuron, AHEAD);
    }
    assert_eq!(graph.aim(3, 250), None);
    assert_eq!(graph.aim(2, 250).map(|aim| aim.to), Some(2));
}

#[test]
fn the_graph_of_sixteen_neurons_takes_six_kilobytes() {
    let size = size_of::<TraversedGraph<16>>();
    assert!(size <= 6_144, "{size} bytes");
}
