#include "relay.h"

#include "tribo/friction_f32.h"

#define EVENTS (TRIBO_RELAY_SET1 | TRIBO_RELAY_SET2 | TRIBO_RELAY_RESET1 | TRIBO_RELAY_RESET2)

uint8_t tribo_relay_latch_step(tribo_relay_latch_t *latch, uint8_t pulses)
{
    return (uint8_t)relay_latch_step(latch, pulses & EVENTS);
}
