//! Units with edges that age: what growing neural gas and growing when required have in common.

use super::codebook::CodeVector;
use super::transition::Transition;

/// A unit and what its method counts of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its code vector.
    pub code: CodeVector,
    /// Accumulated error, or how little it is habituated.
    pub counter: f64,
}

/// Units and the edges between them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Graph {
    /// The units.
    pub units: Vec<Unit>,
    /// Pairs of units, the lower index first, and the edge's age.
    edges: Vec<([usize; 2], u32)>,
}

impl Graph {
    /// Two units at these transitions.
    #[must_use]
    pub fn of(samples: [&Transition; 2], counter: f64) -> Self {
        let unit = |sample| Unit {
            code: CodeVector::of(sample),
            counter,
        };
        Self {
            units: samples.map(unit).into(),
            edges: Vec::new(),
        }
    }

    /// The neighbors of a unit.
    #[must_use]
    pub fn neighbors(&self, unit: usize) -> Vec<usize> {
        let ends = self.edges.iter().filter(|(pair, _)| pair.contains(&unit));
        ends.map(|([a, b], _)| a + b - unit).collect()
    }

    /// Connects two units by an edge of age 0.
    pub fn connect(&mut self, a: usize, b: usize) {
        self.disconnect(a, b);
        self.edges.push(([a.min(b), a.max(b)], 0));
    }

    /// Removes the edge between two units.
    pub fn disconnect(&mut self, a: usize, b: usize) {
        self.edges.retain(|(pair, _)| *pair != [a.min(b), a.max(b)]);
    }

    /// Ages all edges of a unit by one.
    pub fn age(&mut self, unit: usize) {
        let edges = self.edges.iter_mut();
        for (_, age) in edges.filter(|(pair, _)| pair.contains(&unit)) {
            *age += 1;
        }
    }

    /// Removes edges older than this, and units that have no edge left.
    pub fn prune(&mut self, oldest: u32) {
        self.edges.retain(|(_, age)| *age <= oldest);
        for unit in (0..self.units.len()).rev() {
            if self.edges.iter().any(|(pair, _)| pair.contains(&unit)) {
                continue;
            }
            self.units.remove(unit);
            let moved_up = |end: usize| if end > unit { end - 1 } else { end };
            for (pair, _) in &mut self.edges {
                *pair = pair.map(moved_up);
            }
        }
    }

    /// Adds a unit; returns its index.
    pub fn insert(&mut self, code: CodeVector, counter: f64) -> usize {
        self.units.push(Unit { code, counter });
        self.units.len() - 1
    }

    /// The code vectors.
    #[must_use]
    pub fn codes(&self) -> Vec<CodeVector> {
        self.units.iter().map(|unit| unit.code).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::cosines;
    use super::*;

    #[test]
    fn old_edges_and_lonely_units_go() {
        let samples = cosines(4, 1);
        let mut graph = Graph::of([&samples[0], &samples[1]], 0.0);
        for sample in &samples[2..] {
            graph.insert(CodeVector::of(sample), 0.0);
        }
        graph.connect(1, 0);
        graph.connect(2, 3);
        graph.age(0);
        assert_eq!((graph.neighbors(0), graph.neighbors(3)), (vec![1], vec![2]));
        graph.prune(0);
        // Units 2 and 3 are now 0 and 1.
        assert_eq!(
            graph.codes(),
            [&samples[2], &samples[3]].map(CodeVector::of)
        );
        assert_eq!(graph.neighbors(0), [1]);
        graph.disconnect(1, 0);
        assert!(graph.neighbors(0).is_empty());
    }
}
