/// The largest force that the f32 modules take.

#ifndef TRIBO_FORCE_F32_H
#define TRIBO_FORCE_F32_H

/// Largest force in N that any f32 module takes; a larger one, an infinity or a NaN is a bad input.
#define TRIBO_F32_FORCE_MAX_N 1.0e6f

#endif
