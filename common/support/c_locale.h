/// Numbers, letters and messages as in C, for the calling thread and no other, whatever locale the program around has set.
///
/// A program of this project never calls setlocale. The library, the Python package and the FMUs run inside programs that do: with a
/// decimal comma strtod ends at the point of "0.001", and printf writes one.

#ifndef COMMON_C_LOCALE_H
#define COMMON_C_LOCALE_H

#include <locale.h>
#ifdef __APPLE__
#include <xlocale.h>
#endif

typedef struct
{
    locale_t own, before;
} common_c_locale_t;

static inline common_c_locale_t common_c_locale_begin(void)
{
    common_c_locale_t scope;
    scope.own    = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    scope.before = uselocale(scope.own);
    return scope;
}

/// errno stays as it is.
static inline void common_c_locale_end(common_c_locale_t scope)
{
    (void)uselocale(scope.before);
    if (scope.own != (locale_t)0)
    {
        freelocale(scope.own);
    }
}

#endif
