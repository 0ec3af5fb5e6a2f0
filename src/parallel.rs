//! Work that is divided among the processor's cores.

use std::sync::atomic::{AtomicUsize, Ordering};

/// The most threads.
const MAX_THREADS: usize = 8;
/// A thread is not worth its start for less work than this.
const MIN_EACH: usize = 4;

/// The results of a function for the numbers from 0 up to `count`, in their order. Several threads take the numbers one by
/// one, so that work of different length is shared out.
pub(crate) fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    // Asking for the number of cores reads files.
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if count <= MIN_EACH { 1 } else { cores().min(MAX_THREADS) };
    let threads = threads.min(count.div_ceil(MIN_EACH));
    if threads <= 1 {
        return (0..count).map(of).collect();
    }
    let next = AtomicUsize::new(0);
    let work = || {
        let mut found = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return found;
            }
            found.push((number, of(number)));
        }
    };
    let mut all = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut all = work();
        for other in others {
            match other.join() {
                Ok(found) => all.extend(found),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_unstable_by_key(|(number, _)| *number);
    all.into_iter().map(|(_, result)| result).collect()
}

/// The results of a function for all numbers. `first` has, for each of them, the first one with the same result; only for
/// those the function is called.
pub(crate) fn map_alike<T: Clone + Send>(
    first: &[usize],
    of: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let distinct: Vec<usize> = (0..first.len()).filter(|i| first[*i] == *i).collect();
    let found = map(distinct.len(), |i| of(distinct[i]));
    let mut place = vec![0; first.len()];
    distinct.iter().enumerate().for_each(|(i, number)| place[*number] = i);
    first.iter().map(|number| found[place[*number]].clone()).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn results_are_in_order_and_every_number_is_asked_for_once() {
        for count in [0, 1, 3, 5, 1000] {
            let asked = std::sync::atomic::AtomicUsize::new(0);
            let found = super::map(count, |number| {
                asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                number * number
            });
            assert!(found.iter().copied().eq((0..count).map(|number| number * number)));
            assert_eq!(asked.into_inner(), count);
        }
    }
    #[test]
    fn alike_numbers_are_asked_for_once() {
        let asked = std::sync::atomic::AtomicUsize::new(0);
        let found = super::map_alike(&[0, 0, 2, 0, 2, 5], |number| {
            asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            10 * number
        });
        assert_eq!(found, [0, 0, 20, 0, 20, 50]);
        assert_eq!(asked.into_inner(), 3);
    }
}
