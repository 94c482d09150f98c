/// In front of each source: an address is then taken relative to the program counter, and not through a table that a loader would have to relocate.

#pragma GCC visibility push(hidden)
