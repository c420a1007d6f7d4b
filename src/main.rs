//! The `rayframe` program.

fn main() {}
