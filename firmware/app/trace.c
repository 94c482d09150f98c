#include "app/trace.h"

#include <stdatomic.h>
#include <stddef.h>

// NOLINTNEXTLINE(readability-non-const-parameter): the tick writes to `ring`
void trace_init(trace_t *trace, uint32_t *ring, uint32_t ring_words)
{
    *trace = (trace_t){.ring = ring, .ring_words = ring_words};
}

static bool needs_force(trace_trigger_t trigger)
{
    return trigger == TRACE_REVERSAL || trigger == TRACE_RISE || trigger == TRACE_FALL;
}

uint32_t trace_capacity(const trace_t *trace, uint32_t channels)
{
    return trace->ring_words / channels;
}

bool trace_suits(const trace_t *trace, const trace_setup_t *setup)
{
    const uint32_t channels = setup->channel_count;
    return channels >= 1u && channels <= TRACE_CHANNELS_MAX && setup->decimation >= 1u &&
           (uint32_t)setup->trigger < (uint32_t)TRACE_TRIGGERS && setup->after < trace_capacity(trace, channels) &&
           (!needs_force(setup->trigger) || setup->watched != NULL);
}

bool trace_arm(trace_t *trace, const trace_setup_t *setup)
{
    const uint32_t channels = setup->channel_count;
    if (!trace_suits(trace, setup))
    {
        return false;
    }
    trace->state = TRACE_STOPPED; // the tick ignores the trace until it is armed below
    *trace       = (trace_t){.ring       = trace->ring,
                             .ring_words = trace->ring_words,
                             .setup      = *setup,
                             .capacity   = trace_capacity(trace, channels)};
    atomic_thread_fence(memory_order_release); // the tick may be on another core
    trace->state = TRACE_ARMED;
    return true;
}

void trace_stop(trace_t *trace)
{
    trace->state = TRACE_STOPPED;
}

// --- the tick ------------------------------------------------------------------------------------------------------

static bool reverses(trace_t *trace, loop_force_t now)
{
    const int was       = trace->direction;
    const int direction = now > trace->last ? 1 : now < trace->last ? -1 : was;
    trace->direction    = direction;
    return was != 0 && direction != was;
}

static bool fires(trace_t *trace, bool is_fault)
{
    const trace_setup_t *setup    = &trace->setup;
    const bool           begun    = trace->begun;
    const bool           faulted  = is_fault && !trace->was_fault;
    const loop_force_t   last     = trace->last;
    const loop_force_t   now      = setup->watched != NULL ? *setup->watched : 0;
    const bool           reversed = begun && reverses(trace, now);
    trace->begun                  = true;
    trace->was_fault              = is_fault;
    trace->last                   = now;
    switch (setup->trigger)
    {
    case TRACE_FAULT:
        return begun && faulted;
    case TRACE_REVERSAL:
        return reversed;
    case TRACE_RISE:
        return begun && last < setup->level && now >= setup->level;
    case TRACE_FALL:
        return begun && last > setup->level && now <= setup->level;
    default:
        return false;
    }
}

static void take_sample(trace_t *trace)
{
    uint32_t *to = trace->ring + trace->place;
    for (uint32_t i = 0; i < trace->setup.channel_count; i++)
    {
        to[i] = tribo_force_word(*trace->setup.channels[i]);
    }
    const uint32_t next = trace->place + trace->setup.channel_count;
    trace->place        = next < trace->capacity * trace->setup.channel_count ? next : 0u;
    trace->wait         = trace->setup.decimation;
    trace->held         = trace->held < trace->capacity ? trace->held + 1u : trace->capacity;
    trace->count        = trace->count + 1u; // comes last, because trace_read checks it
}

void trace_step(trace_t *trace, uint32_t tick, bool is_fault)
{
    if (trace->state != TRACE_ARMED && trace->state != TRACE_TRIGGERED)
    {
        return;
    }
    if (!trace->begun)
    {
        trace->first_tick = tick;
    }
    else
    {
        trace->wait--;
    }
    if (trace->wait == 0u)
    {
        take_sample(trace);
        if (trace->state == TRACE_TRIGGERED && --trace->left == 0u)
        {
            trace->state = TRACE_DONE;
        }
    }
    if (fires(trace, is_fault) && trace->state == TRACE_ARMED)
    {
        trace->trigger_sample = trace->count - 1u;
        trace->left           = trace->setup.after;
        trace->state          = trace->left == 0u ? TRACE_DONE : TRACE_TRIGGERED;
    }
}

// --- the background ------------------------------------------------------------------------------------------------

// Sample numbers wrap, because a trace may wait for its trigger for years.

uint32_t trace_first(const trace_t *trace)
{
    return trace->count - trace->held;
}

/// Returns the place of the sample that is `age` samples older than the next one.
static uint32_t place_of(const trace_t *trace, uint32_t next_place, uint32_t age)
{
    const uint32_t back = age * trace->setup.channel_count;
    return next_place >= back ? next_place - back : next_place + trace->capacity * trace->setup.channel_count - back;
}

bool trace_read(const trace_t *trace, uint32_t number, uint32_t *words, uint32_t count)
{
    const uint32_t next       = trace->count;
    const uint32_t next_place = trace->place;
    const uint32_t channels   = trace->setup.channel_count;
    const uint32_t age        = next - number;
    if (next != trace->count || channels == 0u || age == 0u || age > trace->held || count == 0u ||
        (count - 1u) / channels >= age)
    {
        return false;
    }
    uint32_t place = place_of(trace, next_place, age);
    for (uint32_t i = 0; i < count; i++)
    {
        if (place >= trace->ring_words)
        {
            return false; // the tick, on another core, restarts the trace
        }
        words[i] = trace->ring[place];
        place    = place + 1u < trace->capacity * channels ? place + 1u : 0u;
    }
    return trace->count - number <= trace->capacity; // false if the tick has overwritten them meanwhile
}
