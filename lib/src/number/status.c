#include "tribo/status.h"

// A row becomes a text such as "friction v0_n_per_s: 1e-6 to 1e6 N/s; q31: over m full_scale_n/(6 2^31 h)". A row
// without a condition has an empty one, and one without a unit has the unit "-".
// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are literals to be joined
#define ROW(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)                \
    case TRIBO_ERR_##symbol:                                                                                           \
        return condition[0] == '\0'                                                                                    \
                   ? (unit[0] == '-' ? RANGE(group, member, low, high) : RANGE(group, member, low, high) " " unit)     \
                   : (unit[0] == '-' ? RANGE(group, member, low, high) "; " condition                                  \
                                     : RANGE(group, member, low, high) " " unit "; " condition);
#define RANGE(group, member, low, high) TRIBO_TITLE_##group #member ": " #low " to " #high
#define REFUSAL(symbol, key, text)                                                                                     \
    case TRIBO_ERR_##symbol:                                                                                           \
        return text;
// NOLINTEND(bugprone-macro-parentheses)

const char *tribo_status_text(tribo_status_t status)
{
    switch (status)
    {
    case TRIBO_OK:
        return "no error";
    case TRIBO_ERR_NULL:
        return "pointer argument: not null";
        TRIBO_PARAMETERS(ROW) // GCOVR_EXCL_BR_LINE: a row's conditions are constants; test_status reads each text
        TRIBO_REFUSALS(REFUSAL)
    default:
        return "unknown status";
    }
}
