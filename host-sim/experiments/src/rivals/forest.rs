//! Rival: one-step control by a random forest.
//!
//! L. Breiman, *Machine Learning* 45, 2001: regression trees on bootstrap samples, each split the
//! best of a third of the inputs. A leaf holds the mean changes of all 16 transducers; a split
//! lowers the sum of their squared errors. Unknown changes are left out of the sums.

use super::goal_cost::GoalCost;
use super::policy::CostModel;
use super::transition::{INPUTS, Transition, augmented, input};
use crate::baselines::learning::Values;
use arena::noise::Noise;
use arena::world::Point;

/// Trees of the forest.
pub const TREES: usize = 20;
/// Most transitions of a tree's bootstrap sample.
pub const MOST_SAMPLES: usize = 1_600;
/// Inputs that are tried for a split.
const TRIED: usize = INPUTS / 3;
/// Least transitions in a leaf (Breiman's 5 for regression).
const LEAF: usize = 5;

/// A node of a tree.
#[derive(Debug, Clone, PartialEq)]
enum Node {
    /// Goes on at one of two nodes.
    Split {
        input: usize,
        threshold: f64,
        /// Where the input is at most the threshold, and where it is above.
        next: [usize; 2],
    },
    /// The mean changes.
    Leaf(Values),
}

/// A forest of regression trees; a tree's root is its last node.
#[derive(Debug, Clone, PartialEq)]
pub struct Forest {
    trees: Vec<Vec<Node>>,
}

/// A transition as a tree sees it.
struct Row {
    input: [f64; INPUTS],
    change: Values,
    known: [bool; 16],
}

/// Sums of the known changes, and how many they are.
#[derive(Clone, Copy)]
struct Sums {
    sums: Values,
    counts: Values,
}

impl Sums {
    const NONE: Self = Self {
        sums: [0.0; 16],
        counts: [0.0; 16],
    };

    fn add(&mut self, row: &Row, sign: f64) {
        for sensor in 0..16 {
            if row.known[sensor] {
                self.sums[sensor] += sign * row.change[sensor];
                self.counts[sensor] += sign;
            }
        }
    }

    fn of(rows: &[&Row]) -> Self {
        let mut sums = Self::NONE;
        rows.iter().for_each(|row| sums.add(row, 1.0));
        sums
    }

    fn means(&self) -> Values {
        std::array::from_fn(|i| self.sums[i] / self.counts[i].max(1.0))
    }

    /// By how much the means lower the sum of squares.
    fn explained(&self) -> f64 {
        let pairs = self.sums.iter().zip(&self.counts);
        pairs.map(|(sum, count)| sum * sum / count.max(1.0)).sum()
    }
}

impl Forest {
    /// Grows the forest.
    #[must_use]
    pub fn fit(transitions: &[Transition], symmetric: bool, seed: u64) -> Self {
        let row = |one: &Transition| Row {
            input: one.input(),
            change: one.change,
            known: one.known,
        };
        let rows: Vec<Row> = augmented(transitions, symmetric).iter().map(row).collect();
        let mut noise = Noise::new(seed);
        let tree = |_| {
            let count = rows.len().min(MOST_SAMPLES);
            let drawn = (0..count).map(|_| &rows[noise.index(rows.len())]);
            let mut drawn: Vec<&Row> = drawn.collect();
            let mut nodes = Vec::new();
            grow(&mut nodes, &mut drawn, &mut noise);
            nodes
        };
        Self {
            trees: (0..TREES).map(tree).collect(),
        }
    }

    /// The change of a situation by a move.
    #[must_use]
    pub fn change(&self, situation: &Values, moved: Point) -> Values {
        let input = input(situation, moved);
        let mut mean = [0.0; 16];
        for tree in &self.trees {
            for (mean, leaf) in mean.iter_mut().zip(leaf(tree, &input)) {
                *mean += leaf / self.trees.len() as f64;
            }
        }
        mean
    }
}

impl CostModel for Forest {
    fn costs(&self, situation: &Values, moves: &[Point], goal: &GoalCost) -> Vec<f64> {
        let cost = |moved: &Point| {
            let change = self.change(situation, *moved);
            let after = std::array::from_fn(|i| situation[i] + change[i]);
            goal.of(&after) - goal.progress(*moved)
        };
        moves.iter().map(cost).collect()
    }

    fn numbers(&self) -> usize {
        let numbers = |node: &Node| match node {
            Node::Split { .. } => 3,
            Node::Leaf(_) => 16,
        };
        self.trees.iter().flatten().map(numbers).sum()
    }
}

fn leaf<'a>(tree: &'a [Node], values: &[f64; INPUTS]) -> &'a Values {
    const NOTHING: Values = [0.0; 16];
    let mut node = tree.last();
    while let Some(Node::Split {
        input,
        threshold,
        next,
    }) = node
    {
        node = tree.get(next[usize::from(values[*input] > *threshold)]);
    }
    match node {
        Some(Node::Leaf(means)) => means,
        _ => &NOTHING,
    }
}

/// Adds the nodes of a subtree, its root last; returns the root's index.
fn grow(nodes: &mut Vec<Node>, rows: &mut [&Row], noise: &mut Noise) -> usize {
    let node = match best_split(rows, noise) {
        None => Node::Leaf(Sums::of(rows).means()),
        Some((input, threshold)) => {
            rows.sort_by(|a, b| a.input[input].total_cmp(&b.input[input]));
            let middle = rows.partition_point(|row| row.input[input] <= threshold);
            let (low, high) = rows.split_at_mut(middle);
            let next = [grow(nodes, low, noise), grow(nodes, high, noise)];
            Node::Split {
                input,
                threshold,
                next,
            }
        }
    };
    nodes.push(node);
    nodes.len() - 1
}

/// The input and the threshold that explain most, of a random choice of inputs; `None` if no split
/// leaves enough on both sides and explains anything.
fn best_split(rows: &mut [&Row], noise: &mut Noise) -> Option<(usize, f64)> {
    let all = Sums::of(rows);
    let (mut best, mut most) = (None, all.explained() + 1e-12);
    let mut inputs: [usize; INPUTS] = std::array::from_fn(|i| i);
    for tried in 0..TRIED {
        inputs.swap(tried, tried + noise.index(INPUTS - tried));
        let input = inputs[tried];
        rows.sort_by(|a, b| a.input[input].total_cmp(&b.input[input]));
        let (mut low, mut high) = (Sums::NONE, all);
        for (index, pair) in rows.windows(2).enumerate() {
            low.add(pair[0], 1.0);
            high.add(pair[0], -1.0);
            let [here, next] = [pair[0].input[input], pair[1].input[input]];
            let left = index + 1;
            if left < LEAF || rows.len() - left < LEAF || here == next {
                continue;
            }
            let explained = low.explained() + high.explained();
            if explained > most {
                (best, most) = (Some((input, 0.5 * (here + next))), explained);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::cosines;
    use super::*;

    /// A step: forwards the change is 0.1, backwards −0.2.
    fn step(moved: Point) -> f64 {
        if moved.x > 0.0 { 0.1 } else { -0.2 }
    }

    fn steps(count: usize) -> Vec<Transition> {
        let mut transitions = cosines(count, 1);
        for one in &mut transitions {
            one.change = [step(one.moved); 16];
        }
        transitions
    }

    #[test]
    fn it_fits_a_step() {
        let forest = Forest::fit(&steps(500), false, 1);
        for bearing in [0.0, 1.0, 2.2, 3.1, -2.2, -1.0] {
            let moved = Point::unit(bearing);
            let found = forest.change(&[0.5; 16], moved)[7];
            assert!((found - step(moved)).abs() < 0.03, "{bearing}: {found}");
        }
    }

    #[test]
    fn unknown_changes_are_not_learned() {
        let mut transitions = steps(500);
        for wrong in transitions.iter_mut().step_by(2) {
            (wrong.change[3], wrong.known[3]) = (9.0, false);
        }
        let forest = Forest::fit(&transitions, false, 1);
        let found = forest.change(&[0.5; 16], Point::unit(0.0))[3];
        assert!((found - 0.1).abs() < 0.03, "{found}");
    }

    #[test]
    fn a_seed_gives_one_forest() {
        let grown = |seed: u64| Forest::fit(&steps(60), true, seed);
        assert_eq!(grown(4), grown(4));
        assert_ne!(grown(4), grown(5));
        assert!(grown(4).trees.iter().all(|tree| tree.len() > 2));
    }
}
