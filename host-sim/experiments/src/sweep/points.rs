//! The numbered points of a sweep: sets of options.

/// A key and its value.
pub type Assignment = (String, String);
/// The options of a point.
pub type PointOptions = Vec<Assignment>;

/// The points: those of a grid, then single ones. Of a grid only the axes are stored.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SweepPoints {
    /// Keys and values that all points share.
    pub fixed: PointOptions,
    /// Keys that differ between points, in order of appearance.
    keys: Vec<String>,
    /// The grid's keys (as indices into `keys`) with their values; the last varies fastest.
    axes: Vec<(usize, Vec<String>)>,
    /// Single points: values with indices into `keys`.
    rows: Vec<Vec<(usize, String)>>,
}

impl SweepPoints {
    fn place(&mut self, key: &str) -> usize {
        let place = self.keys.iter().position(|known| known == key);
        place.unwrap_or_else(|| {
            self.keys.push(key.to_owned());
            self.keys.len() - 1
        })
    }

    /// Adds an axis of the grid, with at least one value.
    pub fn add_axis(&mut self, key: &str, values: Vec<String>) {
        let place = self.place(key);
        self.axes.push((place, values));
    }

    /// Adds a single point after the grid.
    pub fn add(&mut self, row: PointOptions) {
        let row = row
            .into_iter()
            .map(|(key, value)| (self.place(&key), value))
            .collect();
        self.rows.push(row);
    }

    /// Keys that differ between points.
    #[must_use]
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    fn grid_len(&self) -> Option<u64> {
        if self.axes.is_empty() {
            // Without grid and list there is one point.
            return Some(u64::from(self.rows.is_empty()));
        }
        let lengths = self.axes.iter().map(|(_, values)| values.len() as u64);
        lengths.into_iter().try_fold(1, u64::checked_mul)
    }

    /// Number of points; `None` above 2⁶⁴ − 1.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        self.grid_len()?.checked_add(self.rows.len() as u64)
    }

    /// The values of point `index`, one per key of [`SweepPoints::keys`]; empty where the point
    /// does not set the key.
    #[must_use]
    pub fn cells(&self, index: u64) -> Vec<String> {
        let mut cells = vec![String::new(); self.keys.len()];
        let mut put = |place: usize, value: &str| {
            if let Some(cell) = cells.get_mut(place) {
                value.clone_into(cell);
            }
        };
        let grid = self.grid_len().unwrap_or(u64::MAX);
        if index < grid {
            let mut rest = index;
            for (place, values) in self.axes.iter().rev() {
                let count = values.len().max(1) as u64;
                if let Some(value) = values.get((rest % count) as usize) {
                    put(*place, value);
                }
                rest /= count;
            }
        } else if let Some(row) = self.rows.get((index - grid) as usize) {
            row.iter().for_each(|(place, value)| put(*place, value));
        }
        cells
    }

    /// All options of point `index`: the shared ones and its own.
    #[must_use]
    pub fn choices(&self, index: u64) -> PointOptions {
        let own = self.keys.iter().cloned().zip(self.cells(index));
        let own = own.filter(|(_, value)| !value.is_empty());
        self.fixed.iter().cloned().chain(own).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts<const N: usize>(texts: [&str; N]) -> Vec<String> {
        texts.map(str::to_owned).into()
    }

    #[test]
    fn the_grid_comes_first_its_last_key_fastest() {
        let mut points = SweepPoints::default();
        points.fixed.push(("steps".into(), "5".into()));
        points.add_axis("far", texts(["1", "2"]));
        points.add_axis("near", texts(["a", "b", "c"]));
        points.add(vec![
            ("preset".into(), "probe".into()),
            ("far".into(), "9".into()),
        ]);
        assert_eq!(points.keys(), texts(["far", "near", "preset"]));
        assert_eq!(points.count(), Some(7));
        assert_eq!(points.cells(0), texts(["1", "a", ""]));
        assert_eq!(points.cells(1), texts(["1", "b", ""]));
        assert_eq!(points.cells(5), texts(["2", "c", ""]));
        assert_eq!(points.cells(6), texts(["9", "", "probe"]));
        let choices = [("steps", "5"), ("far", "9"), ("preset", "probe")];
        assert_eq!(
            points.choices(6),
            choices.map(|(key, value)| (key.into(), value.into()))
        );
    }

    #[test]
    fn without_any_there_is_one_and_too_many_are_told() {
        assert_eq!(SweepPoints::default().count(), Some(1));
        assert!(SweepPoints::default().choices(0).is_empty());
        let mut points = SweepPoints::default();
        for key in 0..20 {
            points.add_axis(&key.to_string(), vec!["x".to_owned(); 100]);
        }
        assert_eq!(points.count(), None);
    }
}
