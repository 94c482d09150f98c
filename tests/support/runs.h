// Long runs are for the host; an emulated microcontroller, which computes the same bits (tests/identity), runs a part of them.

#ifndef TESTS_SUPPORT_RUNS_H
#define TESTS_SUPPORT_RUNS_H

#if defined(__linux__)
#define RUNS(host, emulated) (host)
#else
#define RUNS(host, emulated) (emulated)
#endif

#endif
