#include "params_name.h"

#include <stdio.h>
#include <string.h>

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

/// The word of a register of the staged set.
static uint32_t word_of(uint32_t address)
{
    const uint32_t at = address - REGISTERS_STAGED_AT;
    return at < REGISTERS_LOOP_AT       ? at / 2u
           : at < REGISTERS_SECTIONS_AT ? (uint32_t)PARAMS_WORD(at)
                                        : PARAMS_SECTIONS_AT + (at - REGISTERS_SECTIONS_AT) / 2u;
}

static double value_of(uint32_t word, uint32_t bits)
{
    float number;
    memcpy(&number, &bits, sizeof number);
    const bool is_whole = word < (uint32_t)DRIVE_CONFIG_COUNT && !drive_config_fields[word].is_float;
    return is_whole ? (double)bits : (double)number;
}

void params_name_changes(const registers_t *registers)
{
    static uint32_t told;
    const uint32_t  count = registers->protection_changes;
    if (count - told > REGISTERS_CHANGES)
    {
        (void)fprintf(stderr, "protection: %u changes\n", count - told - REGISTERS_CHANGES);
        told = count - REGISTERS_CHANGES;
    }
    for (; told != count; told++)
    {
        const registers_change_t *change = &registers->changes[told % REGISTERS_CHANGES];
        const uint32_t            word   = word_of(change->address);
        (void)fprintf(stderr,
                      "protection: %s from %.9g to %.9g at tick %u, now 0x%08x\n",
                      params_name(word),
                      value_of(word, change->from),
                      value_of(word, change->to),
                      change->tick,
                      registers->protection);
    }
}
