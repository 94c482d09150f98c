/// What a function of the extension begins and ends with: locale and floating-point environment as a program has them at its start. The
/// process around may have a decimal comma, another direction of rounding, subnormal numbers flushed to zero, or traps.

#ifndef NATIVE_SCOPE_H
#define NATIVE_SCOPE_H

#include "support/c_locale.h"

#include <fenv.h>

typedef struct
{
    common_c_locale_t locale;
    fenv_t            arithmetic;
} native_scope_t;

static inline native_scope_t native_enter(void)
{
    native_scope_t scope = {.locale = common_c_locale_begin()};
    (void)fegetenv(&scope.arithmetic);
    (void)fesetenv(FE_DFL_ENV);
    return scope;
}

static inline void native_leave(const native_scope_t *scope)
{
    (void)fesetenv(&scope->arithmetic);
    common_c_locale_end(scope->locale);
}

#endif
