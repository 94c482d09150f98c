/// Sets the locale of the calling thread, and of no other, to C, whatever the surrounding program has set.
///
/// A program of this project never calls setlocale. The library, the Python package and the FMUs run inside programs that
/// do. In a locale with a decimal comma, strtod would end at the point of "0.001", and printf would write a comma.

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

/// Restores the locale. errno stays as it is.
static inline void common_c_locale_end(common_c_locale_t scope)
{
    (void)uselocale(scope.before);
    if (scope.own != (locale_t)0)
    {
        freelocale(scope.own);
    }
}

#endif
