"""The library's force loop from Python. It is the C that a drive runs, called through ctypes; nothing of it is computed here."""

import ctypes


class ForceLoop:
    """A loop of its own, made for one rig by `make RIG=...`; `period_s` is the time between two calls of step."""

    def __init__(self, library):
        c = ctypes.CDLL(str(library))
        self.period_s = ctypes.c_float.in_dll(c, "force_loop_period_s").value
        self._state = ctypes.create_string_buffer(ctypes.c_size_t.in_dll(c, "force_loop_size").value)
        self._step = c.force_loop_step
        self._step.argtypes = [ctypes.c_void_p, ctypes.c_float, ctypes.c_float]
        self._step.restype = ctypes.c_float
        self._guard = c.force_loop_guard
        self._guard.argtypes = c.force_loop_start.argtypes = [ctypes.c_void_p]
        c.force_loop_start(self._state)

    def step(self, r, y):
        """u for the reference r and the reading y; finite and within its limits whatever they are. NaN: there was no reading."""
        return self._step(self._state, r, y)

    @property
    def guard(self):
        """Why the guard fades friction: 0 it does not, 1 hunting, 2 overshoot."""
        return self._guard(self._state)
