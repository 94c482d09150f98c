// Runs seven scenarios through the f32 and the Q31 loop and prints a hash of all that each tick saw. The numbers are the
// library's alone: references are integers, the plant is the library's own friction, arm and filter. So the same
// hashes must come out of every compiler, optimisation and machine (expected.txt).
// A change that is meant to change a bit puts the new ones there: identity_trace >tests/identity/expected.txt

#include "../support/cascade_f32.h"
#include "../support/cascade_q31.h"
#include "friction/arm_q31.h"
#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"

#include <stdio.h>
#include <string.h>

#define TICKS 6000
#define GRID  4194304 // references are multiples of 2^-22 N
#define N(x)  ((int32_t)((x) * GRID))

static uint64_t hash;

static void hash_word(uint32_t word)
{
    for (int i = 0; i < 4; i++)
    {
        hash = (hash ^ (word >> (8 * i) & 0xffu)) * UINT64_C(0x100000001b3); // FNV-1a
    }
}

static void hash_float(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    hash_word(bits);
}

// --- scenarios ---------------------------------------------------------------------------------------------------

static uint32_t random_word; // a linear congruence, of which the upper bits serve

static uint32_t random_bits(uint32_t count)
{
    random_word = random_word * 1664525u + 1013904223u;
    return random_word >> (32u - count);
}

static int32_t wandering;

static int32_t triangle(int k)
{
    const int32_t phase = k % 4000;
    return N(0.4) + (phase < 2000 ? phase : 4000 - phase) * (N(0.2) / 2000);
}

static int32_t steps(int k)
{
    static const int32_t levels[] = {N(0.9), N(0.1), N(-0.9), 0, N(0.6), N(-0.2)};
    return levels[k / 1000];
}

static int32_t wander(int k)
{
    wandering += (int32_t)random_bits(12) - 2048;
    wandering = k % 700 == 0 ? (int32_t)random_bits(22) - GRID / 2 : wandering;
    return wandering;
}

typedef struct
{
    const char *name;
    int32_t (*reference)(int k);
    float u_max_n;
    bool  faults;
    bool  retuning;
    bool  feeds_forward; // and changes to the paper's method where it is retuned
} scenario_t;

static const scenario_t scenarios[] = {{"triangle", triangle, 2.0f, false, false, false},
                                       {"limits", steps, 0.5f, false, false, false},
                                       {"wander", wander, 2.0f, false, false, false},
                                       {"faults", wander, 1.0f, true, false, false},
                                       {"retuning", triangle, 1.5f, true, true, false},
                                       {"fed", triangle, 2.0f, false, false, true},
                                       {"methods", steps, 1.0f, true, true, true}};

#define SCENARIOS (sizeof scenarios / sizeof scenarios[0])

// --- params ------------------------------------------------------------------------------------------------------

static const tribo_breakaway_point_f32_t table[]  = {{0.1f, 0.02f, 0.03f}, {0.3f, 0.09f, 0.11f}, {0.5f, 0.17f, 0.15f}};
static const tribo_biquad_f32_section_t  softer[] = {{1.0f, 1.5f, 0.5f, 1.4f, 0.4f},
                                                     {0.4f, 0.41f, 0.01f, 1.00001f, 1e-5f}};
static const tribo_biquad_f32_section_t  sensor[] = {{0.0f, 0.05f, 0.053f, 1.053f, 0.053f}};

/// The loops that a scenario may change between: the paper's, one with a table, one asymmetric with gravity.
static tribo_force_loop_f32_config_t config_of(const scenario_t *scenario, int which)
{
    tribo_force_loop_f32_config_t config   = tribo_force_loop_f32_paper();
    tribo_friction_f32_config_t  *friction = &config.compensator.friction;
    config.controller.u_max_n              = scenario->u_max_n;
    if (which == 1)
    {
        friction->table                = table;
        friction->table_length         = 3;
        config.gain                    = 0.4f;
        config.compensator.arm.damping = 0.05f;
    }
    if (which == 2)
    {
        friction->positive              = (tribo_breakaway_f32_t){.offset_n = 0.01f, .slope = 0.25f};
        friction->negative              = (tribo_breakaway_f32_t){.offset_n = 0.005f, .slope = 0.35f};
        friction->gravity_n             = 0.004f;
        config.controller.sections      = softer;
        config.controller.section_count = 2;
    }
    return config;
}

static int params_at(const scenario_t *scenario, int k)
{
    return scenario->retuning ? k / 500 % 3 : 0;
}

/// The second loop of a scenario with a feed-forward has the paper's method.
static bool feeds_forward(const scenario_t *scenario, int which)
{
    return scenario->feeds_forward && which != 1;
}

/// Holds after 0.4 s.
static tribo_feedforward_f32_config_t soon_holding(void)
{
    tribo_feedforward_f32_config_t config = tribo_feedforward_f32_default();
    config.still_time_s                   = 0.4f;
    return config;
}

static bool faulty(const scenario_t *scenario, int k)
{
    return scenario->faults && k % 97 < 3;
}

static void start(void)
{
    hash        = UINT64_C(0xcbf29ce484222325);
    random_word = 20110701;
    wandering   = 0;
}

// --- f32 ---------------------------------------------------------------------------------------------------------

static float bad_float(int k)
{
    static const uint32_t bits[] = {0x7fc00000u, 0xffc00001u, 0x7f800000u, 0xff800000u, 0x7f7fffffu, 0x40200000u};
    float                 x;
    memcpy(&x, &bits[k % 6], sizeof x);
    return x;
}

static void hash_f32(const tribo_feedforward_f32_memory_t *memory)
{
    const tribo_feedforward_f32_state_t *s      = &memory->state;
    const float                          seen[] = {s->b,
                                                   s->lead,
                                                   s->learner.travel_n,
                                                   s->friction,
                                                   s->sigma,
                                                   s->weights.use[1],
                                                   s->learner.P[0],
                                                   s->learner.a[3],
                                                   s->learner.ratio};
    for (size_t i = 0; i < sizeof seen / sizeof seen[0]; i++)
    {
        hash_float(seen[i]);
    }
    hash_word(memory->state.mode);
}

static bool run_f32(const scenario_t *scenario)
{
    static tribo_feedforward_f32_params_t feedforward[3];
    static tribo_feedforward_f32_memory_t memory;

    const tribo_feedforward_f32_config_t standard = soon_holding();
    tribo_force_loop_f32_params_t        params[3];
    tribo_force_loop_f32_state_t         state;
    tribo_compensator_f32_params_t       plant;
    tribo_compensator_f32_state_t        plant_state;
    tribo_biquad_f32_params_t            filter;
    tribo_biquad_f32_state_t             filter_state;

    const tribo_compensator_f32_config_t truth = tribo_force_loop_f32_paper().compensator;
    bool                                 ok    = tribo_compensator_f32_init(&plant, &truth, 1.0e-3f) == TRIBO_OK &&
              tribo_biquad_f32_init(&filter, sensor, 1, NULL) == TRIBO_OK;
    for (int i = 0; i < 3; i++)
    {
        tribo_force_loop_f32_config_t config = config_of(scenario, i);
        if (feeds_forward(scenario, i))
        {
            config.method = tribo_feedforward_f32_use(&feedforward[i], &standard);
        }
        ok = ok && tribo_force_loop_f32_init(&params[i], &config) == TRIBO_OK;
    }
    tribo_feedforward_f32_reset(&memory.state); // of params that come later, too
    state.memory = &memory.state.tick;
    ok           = ok && tribo_force_loop_f32_start(&state, &params[0], false) == TRIBO_OK;
    tribo_compensator_f32_reset(&plant_state);
    tribo_biquad_f32_reset(&filter_state);
    start();
    for (int k = 0; ok && k < TICKS; k++)
    {
        tribo_force_loop_f32_signals_t  s;
        tribo_compensator_f32_signals_t p;
        const float                     r = (float)scenario->reference(k) * (1.0f / GRID);
        const float                     F = plant_state.arm.force_n;
        const float y = faulty(scenario, k) ? bad_float(k) : cascade_f32_step(&filter, &filter_state, F);
        const float u = tribo_force_loop_f32_step(&params[params_at(scenario, k)], &state, r, y, &s);
        (void)tribo_compensator_f32_step(&plant, &plant_state, u, &p);
        const float seen[] = {F,
                              u,
                              s.e_n,
                              s.friction_term_n,
                              s.controller.v_n,
                              s.compensator.force_n,
                              s.compensator.friction.n_n,
                              s.compensator.friction.L_n,
                              s.compensator.friction.v_n_per_s,
                              s.compensator.friction.f_n,
                              p.friction.f_n};
        for (size_t i = 0; i < sizeof seen / sizeof seen[0]; i++)
        {
            hash_float(seen[i]);
        }
        hash_word(s.compensator.friction.relays | (s.controller.limited ? 8u : 0u));
        if (scenario->feeds_forward)
        {
            hash_f32(&memory);
        }
    }
    hash_word(state.bad_inputs);
    hash_word(state.controller.limited_ticks);
    return ok;
}

// --- Q31, at a full scale of 2 N ---------------------------------------------------------------------------------

static void hash_q31(const tribo_feedforward_q31_memory_t *memory)
{
    const tribo_feedforward_q31_state_t *s = &memory->state;
    hash_word((uint32_t)s->b);
    hash_word((uint32_t)s->lead);
    hash_word((uint32_t)s->friction);
    hash_word((uint32_t)s->sigma);
    hash_word((uint32_t)s->weights.use[1]);
    hash_float(s->learner.travel_n);
    hash_float(s->learner.P[0]);
    hash_float(s->learner.a[3]);
    hash_float(s->learner.ratio);
    hash_word(memory->state.mode);
}

static bool run_q31(const scenario_t *scenario)
{
    static const int32_t                  bad[] = {INT32_MIN, INT32_MAX, -INT32_MAX};
    static tribo_feedforward_q31_params_t feedforward[3];
    static tribo_feedforward_q31_memory_t memory;

    const tribo_feedforward_f32_config_t standard = soon_holding();
    tribo_force_loop_q31_params_t        params[3];
    tribo_force_loop_q31_state_t         state;
    tribo_breakaway_point_q31_t          points[3][3];
    tribo_compensator_q31_params_t       plant;
    tribo_compensator_q31_state_t        plant_state;
    tribo_biquad_q31_params_t            filter;
    tribo_biquad_q31_state_t             filter_state;
    tribo_headroom_q31_t                 headroom;

    const tribo_compensator_f32_config_t truth = tribo_force_loop_f32_paper().compensator;
    bool ok = tribo_compensator_q31_init(&plant, NULL, &truth, 1.0e-3f, 2.0f) == TRIBO_OK &&
              cascade_q31_init(&filter, sensor, 1, &headroom) == TRIBO_OK;
    start();
    for (int i = 0; i < 3; i++)
    {
        tribo_force_loop_f32_config_t config = config_of(scenario, i);
        config.input_max_n                   = 1.9f;
        config.usual_force_n                 = 0.475f;
        if (feeds_forward(scenario, i))
        {
            config.method = tribo_feedforward_q31_use(&feedforward[i], &standard);
        }
        const tribo_force_loop_q31_config_t whole = {.loop         = config,
                                                     .full_scale_n = 2.0f,
                                                     .table        = points[i],
                                                     .headroom     = &headroom};

        ok = ok && tribo_force_loop_q31_init(&params[i], &whole) == TRIBO_OK;
        for (int j = 0; ok && j < 4; j++)
        {
            hash_float(headroom.output[j]);
        }
    }
    tribo_feedforward_q31_reset(&memory.state); // of params that come later, too
    state.memory = &memory.state.tick;
    ok           = ok && tribo_force_loop_q31_start(&state, &params[0], false) == TRIBO_OK;
    tribo_compensator_q31_reset(&plant_state);
    tribo_biquad_q31_reset(&filter_state);
    for (int k = 0; ok && k < TICKS; k++)
    {
        tribo_force_loop_q31_signals_t  s;
        tribo_compensator_q31_signals_t p;
        const int32_t                   r = scenario->reference(k) * 256;
        const int32_t                   F = tribo_arm_q31_force(&plant_state.arm);
        const int32_t y = faulty(scenario, k) ? bad[k % 3] : cascade_q31_step(&filter, &filter_state, F);
        const int32_t u = tribo_force_loop_q31_step(&params[params_at(scenario, k)], &state, r, y, &s);
        (void)tribo_compensator_q31_step(&plant, &plant_state, u, &p);
        const int32_t seen[] = {F,
                                u,
                                s.e,
                                s.friction_term,
                                s.controller.v,
                                s.compensator.force,
                                s.compensator.friction.n,
                                s.compensator.friction.L,
                                s.compensator.friction.rise,
                                s.compensator.friction.f,
                                p.friction.f};
        for (size_t i = 0; i < sizeof seen / sizeof seen[0]; i++)
        {
            hash_word((uint32_t)seen[i]);
        }
        hash_word(s.compensator.friction.relays | (s.controller.limited ? 8u : 0u));
        if (scenario->feeds_forward)
        {
            hash_q31(&memory);
        }
    }
    hash_word(state.bad_inputs);
    hash_word(state.saturated);
    hash_word(state.controller.limited_ticks);
    hash_word(state.controller.cascade.saturated);
    return ok;
}

static void print(const char *arithmetic, const scenario_t *scenario)
{
    (void)printf("%s %-8s %08lx%08lx\n",
                 arithmetic,
                 scenario->name,
                 (unsigned long)(hash >> 32),
                 (unsigned long)(hash & UINT32_MAX));
}

int main(void)
{
    bool ok = true;
    for (size_t i = 0; i < SCENARIOS; i++)
    {
        ok = run_f32(&scenarios[i]) && ok;
        print("f32", &scenarios[i]);
        ok = run_q31(&scenarios[i]) && ok;
        print("q31", &scenarios[i]);
    }
    return ok ? 0 : 1;
}
