#include "params_name.h"

#include <stdio.h>

const char *params_name(uint32_t word)
{
    static const char *const names[] = {
#define FIELD(type, name, ...)                [DRIVE_CONFIG_##name] = "drive." #name,
#define NAME(group, symbol, member, key, ...) [PARAMS_##symbol] = TRIBO_KEY_##group key,
        DRIVE_CONFIG_FIELDS(FIELD) PARAMS_LOOP_ROWS(NAME) PARAMS_FEED_ROWS(NAME) PARAMS_GUARD_ROWS(NAME)
#undef NAME
#undef FIELD
            [PARAMS_SECTIONS_AT] = "controller.sections",
        [PARAMS_TABLE_AT]        = "compensator.friction.breakaway.table"};
    const uint32_t at = word >= (uint32_t)PARAMS_TABLE_AT      ? (uint32_t)PARAMS_TABLE_AT
                        : word >= (uint32_t)PARAMS_SECTIONS_AT ? (uint32_t)PARAMS_SECTIONS_AT
                                                               : word;
    return names[at] != NULL ? names[at] : "compensator.method";
}

static double value_of(const params_set_t *set, uint32_t word)
{
    return (double)(word < (uint32_t)DRIVE_CONFIG_COUNT ? drive_config_value(&set->drive, word)
                                                        : params_number(set, word));
}

static void name_change(const registers_t *registers, const params_set_t *before, uint32_t word)
{
    const registers_change_t *last = &registers->changes[(registers->protection_changes - 1u) % REGISTERS_CHANGES];
    (void)fprintf(stderr,
                  "protection: %s from %.9g to %.9g at tick %u, now 0x%08x\n",
                  params_name(word),
                  value_of(before, word),
                  value_of(&registers->active->set, word),
                  last->tick,
                  registers->protection);
}

void params_name_changes(const registers_t *registers, params_set_t *told, uint32_t *told_changes)
{
    const params_set_t *set   = &registers->active->set;
    uint32_t            place = 0;
    params_error_t      turned;
    if (registers->protection_changes == *told_changes)
    {
        return;
    }
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        if (params_word(set, word) != params_word(told, word))
        {
            name_change(registers, told, word);
        }
    }
    if (!params_signs_alike(set, told, &turned))
    {
        name_change(registers, told, turned.word);
    }
    *told         = *set;
    *told_changes = registers->protection_changes;
}
