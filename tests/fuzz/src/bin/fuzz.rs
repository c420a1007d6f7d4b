//! The targets under libFuzzer. The variable `FUZZ_TARGET` names one; `run.py` builds and runs all.

#![no_main]

use std::alloc::System;
use std::sync::OnceLock;

use cap::Cap;
use fuzz_targets::mutation::Random;
use fuzz_targets::{PanicWatch, Target, memory_limit, target};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

/// Counts memory, and refuses more than an input may take.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

static CHOSEN: OnceLock<(Target, PanicWatch)> = OnceLock::new();

fuzz_target!(init: start(), |input: &[u8]| -> () { run(input) });

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    mutate(data, size, max_size, seed)
});

/// Chooses the target. libFuzzer's own hook aborts even where the library isolates a panic of a decoder.
#[expect(clippy::exit, clippy::print_stderr, reason = "a program without a main function")]
fn start() {
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    let Some(target) = target(&name) else {
        eprintln!("FUZZ_TARGET names no target: \"{name}\"");
        std::process::exit(2);
    };
    let _ = CHOSEN.set((*target, PanicWatch::quiet()));
}

#[expect(clippy::print_stderr, reason = "libFuzzer prints there, too")]
fn run(input: &[u8]) {
    let Some((target, watch)) = CHOSEN.get() else { return };
    let limit = ALLOCATOR.allocated().saturating_add(memory_limit(input.len()));
    let _ = ALLOCATOR.set_limit(limit);
    let found = watch.run(target.run, input);
    let _ = ALLOCATOR.set_limit(usize::MAX);
    if let Some(found) = found {
        eprintln!("find: {found}");
        std::process::abort();
    }
}

fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let Some((target, _)) = CHOSEN.get() else { return size };
    let mut mutate_bytes = |bytes: &mut Vec<u8>| {
        let length = bytes.len();
        let most = (length + length / 4 + 16).min(max_size.max(length));
        bytes.resize(most, 0);
        let mutated = fuzzer_mutate(bytes, length, most);
        bytes.truncate(mutated);
    };
    let mutated = target.mutation.apply(&data[..size], &mut Random::new(seed.into()), &mut mutate_bytes);
    let length = mutated.len().min(max_size);
    data[..length].copy_from_slice(&mutated[..length]);
    length
}
