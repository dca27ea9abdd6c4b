//! The one switch of the tests: `ABBE_STRESS=full` makes all trials, which takes an hour or two; without it a
//! share of them is made, in seconds.

/// Whether all is to be tried.
pub fn is_full() -> bool {
    std::env::var("ABBE_STRESS").is_ok_and(|word| word == "full")
}

/// How many trials are made: few by default, or all.
pub fn count<T>(few: T, all: T) -> T {
    if is_full() { all } else { few }
}
