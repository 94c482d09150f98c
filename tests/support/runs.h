// Long runs are for the host's optimised trees. An emulated microcontroller, which computes the same bits (tests/identity), and the check's trees
// with sanitizers or coverage run a part of them.

#ifndef TESTS_SUPPORT_RUNS_H
#define TESTS_SUPPORT_RUNS_H

#if defined(__linux__) && !defined(TRIBO_SHORT_RUNS)
#define RUNS(all, part) (all)
#else
#define RUNS(all, part) (part)
#endif

#endif
