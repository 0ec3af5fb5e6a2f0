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
}
