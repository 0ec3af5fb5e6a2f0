//! Sets of numbers that are joined step by step.

/// Numbers from 0, each in one set.
#[derive(Debug)]
pub(super) struct DisjointSets {
    /// For each number, a number of its set that is no greater.
    lower: Vec<usize>,
}

impl DisjointSets {
    /// Numbers up to a count, each in a set of its own.
    pub(super) fn new(count: usize) -> Self {
        Self { lower: (0..count).collect() }
    }

    /// The least number of a number's set.
    pub(super) fn least(&mut self, mut number: usize) -> usize {
        while self.lower[number] != number {
            self.lower[number] = self.lower[self.lower[number]];
            number = self.lower[number];
        }
        number
    }

    /// Joins the sets of two numbers.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.least(a), self.least(b));
        self.lower[a.max(b)] = a.min(b);
    }
}
