//! Rows of variable length, one behind the other.

use rayon::prelude::*;

/// Rows that one thread takes at a time.
const CHUNK: usize = 2048;

/// The rows of variable length of a table, one behind the other.
pub(super) struct Table<T> {
    /// One more than there are rows.
    pub starts: Vec<u32>,
    pub items: Vec<T>,
}

impl<T: Copy + Send + Sync> Table<T> {
    /// Row number `i` is what `row(i, ..)` pushes.
    pub(super) fn collect<S>(
        count: usize,
        scratch: impl Fn() -> S + Sync,
        row: impl Fn(usize, &mut S, &mut Vec<T>) + Sync,
    ) -> Self {
        let chunks: Vec<(Vec<u32>, Vec<T>)> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let (mut ends, mut items) = (Vec::with_capacity(CHUNK), Vec::new());
                let mut scratch = scratch();
                for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                    row(i, &mut scratch, &mut items);
                    ends.push(items.len() as u32);
                }
                (ends, items)
            })
            .collect();
        let mut starts = Vec::with_capacity(count + 1);
        starts.push(0);
        let mut items = Vec::with_capacity(chunks.iter().map(|chunk| chunk.1.len()).sum());
        for (ends, chunk) in chunks {
            let before = items.len() as u32;
            starts.extend(ends.into_iter().map(|end| before + end));
            items.extend(chunk);
        }
        Self { starts, items }
    }

    pub(super) fn row(&self, i: usize) -> &[T] {
        &self.items[self.range(i)]
    }

    pub(super) fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    pub(super) fn row_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Row `target(item)` of the transposed table holds `turned(i, item)` for every item of row `i`, in the order of
    /// `i`.
    pub(super) fn transposed<U: Copy + Default>(
        &self,
        count: usize,
        target: impl Fn(&T) -> u32,
        turned: impl Fn(usize, &T) -> U,
    ) -> Table<U> {
        let mut starts = vec![0u32; count + 1];
        for item in &self.items {
            starts[target(item) as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut items = vec![U::default(); self.items.len()];
        for i in 0..self.row_count() {
            for item in self.row(i) {
                let place = &mut next[target(item) as usize];
                items[*place as usize] = turned(i, item);
                *place += 1;
            }
        }
        Table { starts, items }
    }
}
