/// Included before each source, so that the compiler addresses symbols relative to the program counter and not through a
/// table that a loader would have to relocate.

#pragma GCC visibility push(hidden)
