// What a tick costs on this target, in instructions and bytes: prints one figure a line, "name value", for the budget test
// and tools/bench-target. The hashes are of all u of a run; they are the same on every target and on the host.

#include COST_HEADER
#include "counter.h"

#include <stdio.h>

typedef TRIBO(force_loop, params_t) loop_params_t;
typedef TRIBO(force_loop, state_t) loop_state_t;
typedef TRIBO(force_loop, signals_t) loop_signals_t;

#define TICKS        60000 // 60 s
#define SEARCH_TICKS 20000
#define SPLIT_EVERY  20 // ticks: then the modules are counted, too
#define AXES_MAX     16
#define STACK_WORDS  384

static loop_params_t  paper;
static loop_params_t  other; // to retune to and fro
static loop_state_t   axis[AXES_MAX];
static loop_signals_t signals;

static TRIBO(lugre, params_t) lugre;
static TRIBO(feedforward, params_t) feedforward;
static TRIBO(feedforward, memory_t) memory;

static void step_axes(uint32_t axes, number_t r)
{
    for (uint32_t i = 0; i < axes; i++)
    {
        (void)TRIBO(force_loop, step)(&paper, &axis[i], r, number(0), &signals);
    }
}

// --- what is counted -----------------------------------------------------------------------------------------------

#define PARAMS(noun) const TRIBO(noun, params_t) * params
#define STATE(noun)  TRIBO(noun, state_t) * state

COUNTED(number_t,
        counted_tick,
        (PARAMS(force_loop), STATE(force_loop), number_t r, number_t y, loop_signals_t *out),
        TRIBO(force_loop, step)(params, state, r, y, out))
COUNTED(number_t,
        counted_tick_without_signals,
        (PARAMS(force_loop), STATE(force_loop), number_t r, number_t y),
        TRIBO(force_loop, step)(params, state, r, y, NULL))
COUNTED(number_t,
        counted_controller,
        (PARAMS(controller), STATE(controller), number_t e, number_t friction, TRIBO(controller, signals_t) * out),
        TRIBO(controller, step)(params, state, e, friction, out))
COUNTED(number_t,
        counted_compensator,
        (PARAMS(compensator), STATE(compensator), number_t u, TRIBO(compensator, signals_t) * out),
        TRIBO(compensator, step)(params, state, u, out))
COUNTED(number_t, counted_cascade, (PARAMS(biquad), STATE(biquad), number_t e), TRIBO(biquad, step)(params, state, e))
COUNTED(int,
        counted_output,
        (PARAMS(biquad), STATE(biquad), number_t e, TRIBO(biquad, outputs_t) * nodes),
        ((void)TRIBO(biquad, output)(params, state, e, nodes), 0))
COUNTED(int,
        counted_advance,
        (PARAMS(biquad), STATE(biquad), number_t e, const TRIBO(biquad, outputs_t) * nodes),
        (ADVANCE(params, state, e, nodes), 0))
COUNTED(number_t,
        counted_friction,
        (PARAMS(friction), STATE(friction), number_t u, number_t force, TRIBO(friction, signals_t) * out),
        TRIBO(friction, step)(params, state, u, force, out))
COUNTED(int, counted_arm, (PARAMS(arm), STATE(arm), number_t drive), (TRIBO(arm, step)(params, state, drive), 0))
COUNTED(uint8_t,
        counted_relay,
        (tribo_relay_state_t * state, uint8_t width, uint8_t events),
        tribo_relay_step(state, width, events))
COUNTED(uint8_t,
        counted_edge,
        (tribo_edge_state_t * state, uint8_t width, uint8_t events),
        tribo_edge_step(state, width, events))
COUNTED(int,
        counted_watch,
        (PARAMS(guard), STATE(guard), loop_state_t *loop, number_t r, number_t y),
        (TRIBO(force_loop_guard, watch)(params, state, &other, loop, r, y, &signals), 0))
COUNTED(int, counted_axes, (uint32_t axes, number_t r), (step_axes(axes, r), 0))

// --- the plant: actuator, arm with friction, sensor ----------------------------------------------------------------

static struct
{
    number_t actuator, sensor;
    TRIBO(compensator, state_t) arm;
} plant;

static void plant_reset(void)
{
    plant.actuator = number(0);
    plant.sensor   = number(0);
    TRIBO(compensator, reset)(&plant.arm);
}

/// Poles -200 and -55 rad/s at 1 ms.
static void plant_step(number_t u)
{
    TRIBO(compensator, signals_t) seen;
    plant.actuator = approach(plant.actuator, u, 11880);
    (void)TRIBO(compensator, step)(&paper.compensator, &plant.arm, plant.actuator, &seen);
    plant.sensor = approach(plant.sensor, seen.N(force), 3507);
}

// --- inputs --------------------------------------------------------------------------------------------------------

/// 0.4 to 0.6 N, period 20 s.
static number_t triangle(int32_t tick)
{
    const int32_t phase = tick % 20000;
    return number(400) + part(number(200), (phase < 10000 ? phase : 20000 - phase) * 4096 / 625);
}

static uint32_t random_state;

static uint32_t random_bits(void) // xorshift
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static number_t random_force(int32_t largest_millinewton)
{
    return part(number(largest_millinewton), (int32_t)(random_bits() >> 15) - 65536);
}

typedef struct
{
    uint32_t kind;
    number_t r, y, slope, error;
} search_t;

/// Inputs of the search for the worst tick: creeping near rest, jumps, limits, bad inputs, random bits.
static void search_step(search_t *s, int32_t tick)
{
    if (tick % 32 == 0)
    {
        s->kind  = random_bits() % 6u;
        s->r     = random_force(900);
        s->slope = random_force(s->kind == 0u ? 1 : 3);
        s->error = random_force(5);
    }
    switch (s->kind)
    {
    case 0:
    case 1: // the plant answers
        s->r += s->slope;
        s->y = plant.sensor;
        break;
    case 2: // a standing error
        s->r += s->slope;
        s->y = s->r - s->error;
        break;
    case 3: // from limit to limit
        s->r = number(tick % 16 < 8 ? 900 : -900);
        s->y = random_force(900);
        break;
    case 4:
        s->r = random_force(1900);
        s->y = random_force(1900);
        break;
    default:
        s->r = number_of_bits(random_bits());
        s->y = number_of_bits(random_bits());
        break;
    }
}

// --- figures -------------------------------------------------------------------------------------------------------

static void print(const char *name, const char *of, uint32_t value)
{
    printf("%s.%s%s %lu\n", ARITH, name, of, (unsigned long)value);
}

static void print_counts(const char *name, const counts_t *c)
{
    print(name, ".min", c->min);
    print(name, ".mean", (uint32_t)((c->sum + c->calls / 2u) / c->calls));
    print(name, ".max", c->max);
}

static struct
{
    counts_t controller, cascade, output, advance, compensator, friction, relay, edge, arm;
} modules;

/// Each module alone, from the state before the tick and with the inputs it had in the tick.
static void count_modules(const loop_state_t *before)
{
    loop_state_t                              s  = *before;
    const TRIBO(force_loop, signals_t) *const in = &signals;
    loop_signals_t                            out;
    const number_t                            u     = in->controller.N(u);
    const number_t                            force = in->compensator.N(force);
    const number_t                            drive = in->compensator.friction.N(n) - in->compensator.friction.N(f);

    counted_controller(&paper.controller, &s.controller, in->N(e), in->N(feedforward), &out.controller);
    counts_add(&modules.controller);
    counted_compensator(&paper.compensator, &s.compensator, u, &out.compensator);
    counts_add(&modules.compensator);

    s = *before;
    (void)counted_cascade(&paper.controller.cascade, &s.controller.cascade, in->N(e));
    counts_add(&modules.cascade);

    s = *before;
    TRIBO(biquad, outputs_t) nodes;
    counted_output(&paper.controller.cascade, &s.controller.cascade, in->N(e), &nodes);
    counts_add(&modules.output);
    counted_advance(&paper.controller.cascade, &s.controller.cascade, in->N(e), &nodes);
    counts_add(&modules.advance);
    counted_friction(&paper.compensator.friction, &s.compensator.friction.paper, u, force, &out.compensator.friction);
    counts_add(&modules.friction);
    counted_arm(&paper.compensator.arm, &s.compensator.arm, drive);
    counts_add(&modules.arm);

    tribo_relay_state_t *const relay  = &s.compensator.friction.paper.relay;
    const uint8_t              width  = paper.compensator.friction.pulse_width;
    const uint8_t              events = relay->edge.line[(relay->edge.head - 1u) & TRIBO_EDGE_WIDTH_MAX];
    counted_relay(relay, width, events);
    counts_add(&modules.relay);
    counted_edge(&relay->edge, width, events);
    counts_add(&modules.edge);
}

static uint32_t hash(uint32_t so_far, number_t u)
{
    return (so_far ^ bits_of(u)) * 16777619u; // FNV-1a, by words
}

static void run_triangle(void)
{
    counts_t     tick            = {0};
    counts_t     without_signals = {0};
    uint32_t     hashed          = 2166136261u;
    loop_state_t before;
    loop_state_t copy;
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    for (int32_t k = 0; k < TICKS; k++)
    {
        const number_t r = triangle(k);
        const number_t y = plant.sensor;
        number_t       u;
        before = axis[0];
        u      = counted_tick(&paper, &axis[0], r, y, &signals);
        counts_add(&tick);
        hashed = hash(hashed, u);
        copy   = before;
        (void)counted_tick_without_signals(&paper, &copy, r, y);
        counts_add(&without_signals);
        if (k % SPLIT_EVERY == 0)
        {
            count_modules(&before);
        }
        plant_step(u);
    }
    print_counts("tick", &tick);
    print_counts("tick.without_signals", &without_signals);
    print_counts("tick.controller", &modules.controller);
    print_counts("tick.controller.cascade", &modules.cascade);
    print_counts("tick.controller.cascade.output", &modules.output);
    print_counts("tick.controller.cascade.advance", &modules.advance);
    print_counts("tick.compensator", &modules.compensator);
    print_counts("tick.compensator.friction", &modules.friction);
    print_counts("tick.compensator.friction.relay", &modules.relay);
    print_counts("tick.compensator.friction.relay.edge", &modules.edge);
    print_counts("tick.compensator.arm", &modules.arm);
    print("hash", ".triangle", hashed);
}

static void run_search(void)
{
    counts_t     tick            = {0};
    counts_t     without_signals = {0};
    uint32_t     hashed          = 2166136261u;
    search_t     s               = {.kind = 0};
    loop_state_t copy;
    random_state = 0x7ab5u;
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    for (int32_t k = 0; k < SEARCH_TICKS; k++)
    {
        number_t u;
        search_step(&s, k);
        copy = axis[0];
        (void)counted_tick_without_signals(&paper, &copy, s.r, s.y);
        counts_add(&without_signals);
        u = counted_tick(&paper, &axis[0], s.r, s.y, &signals);
        counts_add(&tick);
        hashed = hash(hashed, u);
        plant_step(u);
    }
    print_counts("search", &tick);
    print_counts("search.without_signals", &without_signals);
    print("hash", ".search", hashed);
}

/// Params swapped at every tick.
static void run_retuning(void)
{
    counts_t tick = {0};
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    for (int32_t k = 0; k < 500; k++)
    {
        const number_t r = triangle(k);
        number_t       u;
        if (k == 0)
        {
            u = TRIBO(force_loop, step)(&other, &axis[0], r, plant.sensor, &signals);
        }
        else
        {
            u = counted_tick(k % 2 ? &paper : &other, &axis[0], r, plant.sensor, &signals);
            counts_add(&tick);
        }
        plant_step(u);
    }
    print_counts("retuning", &tick);
}

static void run_axes(void)
{
    for (uint32_t axes = 1; axes <= AXES_MAX; axes *= 2u)
    {
        counts_t all = {0};
        char     name[16];
        for (uint32_t i = 0; i < AXES_MAX; i++)
        {
            TRIBO(force_loop, reset)(&axis[i]);
        }
        for (int32_t k = 0; k < 200; k++)
        {
            const number_t r = triangle(k);
            counted_axes(axes, r);
            counts_add(&all);
        }
        all.sum = (all.sum + all.calls / 2u) / all.calls;
        (void)snprintf(name, sizeof name, "axes.%lu", (unsigned long)axes);
        print(name, ".each", (uint32_t)(all.sum + axes / 2u) / axes);
    }
}

// --- stack ---------------------------------------------------------------------------------------------------------

#define PAINT 0x5a5a5a5au

#if defined(__arm__) || defined(__riscv)

static inline uint32_t *stack_pointer(void)
{
    uint32_t *sp;
#if defined(__arm__)
    __asm volatile("mov %0, sp" : "=r"(sp));
#else
    __asm volatile("mv %0, sp" : "=r"(sp));
#endif
    return sp;
}

// Both inline: the stack pointer must be that of the caller.

static inline __attribute__((always_inline)) void paint(volatile uint32_t *top)
{
    for (uint32_t i = 1; i <= STACK_WORDS; i++)
    {
        *(top - i) = PAINT;
    }
}

static inline __attribute__((always_inline)) void note_depth(const volatile uint32_t *top, uint32_t *deepest)
{
    uint32_t words = STACK_WORDS;
    while (words > 0u && *(top - words) == PAINT)
    {
        words--;
    }
    const uint32_t bytes = words * (uint32_t)sizeof(uint32_t);
    *deepest             = bytes > *deepest ? bytes : *deepest;
}

/// Bytes of stack that a tick uses below its caller, with params that change from tick to tick, or do not.
static __attribute__((noinline)) uint32_t stack_of_ticks(const loop_params_t *even, const loop_params_t *odd)
{
    search_t s   = {.kind = 0};
    random_state = 0x7ab5u;
    TRIBO(force_loop, reset)(&axis[0]);
    ATTACH(&axis[0], odd->feedforward != NULL ? &memory : NULL);
    plant_reset();
    volatile uint32_t *const top     = stack_pointer();
    uint32_t                 deepest = 0;
    for (int32_t k = 0; k < 400; k++)
    {
        search_step(&s, k * 5); // a kind lasts 7 ticks
        const loop_params_t *params = k % 2 ? odd : even;
        paint(top);
        if (k % 4 < 2)
        {
            (void)TRIBO(force_loop, step)(params, &axis[0], s.r, s.y, &signals);
        }
        else
        {
            (void)TRIBO(force_loop, step)(params, &axis[0], s.r, s.y, NULL);
        }
        note_depth(top, &deepest);
    }
    return deepest;
}

/// The same of each module alone, with the signals of a tick before it as its inputs.
static __attribute__((noinline)) void print_stack_of_modules(void)
{
    static struct
    {
        uint32_t controller, cascade, compensator, friction, arm, relay, edge;
    } stack;
    search_t s   = {.kind = 0};
    random_state = 0x7ab5u;
    TRIBO(force_loop, reset)(&axis[0]);
    plant_reset();
    volatile uint32_t *const top = stack_pointer();
    for (int32_t k = 0; k < 400; k++)
    {
        search_step(&s, k * 5);
        const number_t       u   = TRIBO(force_loop, step)(&paper, &axis[0], s.r, s.y, &signals);
        const loop_signals_t in  = signals;
        loop_state_t         was = axis[0];

        paint(top);
        (void)TRIBO(controller,
                    step)(&paper.controller, &was.controller, in.N(e), in.N(feedforward), &signals.controller);
        note_depth(top, &stack.controller);
        paint(top);
        (void)TRIBO(biquad, step)(&paper.controller.cascade, &was.controller.cascade, in.N(e));
        note_depth(top, &stack.cascade);
        paint(top);
        (void)TRIBO(compensator, step)(&paper.compensator, &was.compensator, u, &signals.compensator);
        note_depth(top, &stack.compensator);
        paint(top);
        (void)TRIBO(friction, step)(&paper.compensator.friction,
                                    &was.compensator.friction.paper,
                                    u,
                                    in.compensator.N(force),
                                    &signals.compensator.friction);
        note_depth(top, &stack.friction);
        paint(top);
        (void)TRIBO(arm, step)(&paper.compensator.arm, &was.compensator.arm, in.compensator.friction.N(n));
        note_depth(top, &stack.arm);
        paint(top);
        (void)tribo_relay_step(&was.compensator.friction.paper.relay,
                               paper.compensator.friction.pulse_width,
                               (uint8_t)(k & 15));
        note_depth(top, &stack.relay);
        paint(top);
        (void)tribo_edge_step(&was.compensator.friction.paper.relay.edge,
                              paper.compensator.friction.pulse_width,
                              (uint8_t)(k & 15));
        note_depth(top, &stack.edge);
    }
    print("stack.controller", "", stack.controller);
    print("stack.cascade", "", stack.cascade);
    print("stack.compensator", "", stack.compensator);
    print("stack.friction", "", stack.friction);
    print("stack.arm", "", stack.arm);
    print("stack.relay", "", stack.relay);
    print("stack.edge", "", stack.edge);
}

#else

static uint32_t stack_of_ticks(const loop_params_t *even, const loop_params_t *odd)
{
    (void)even;
    (void)odd;
    return PAINT & 0u;
}

static void print_stack_of_modules(void)
{
}

#endif

// --- breakaway table -----------------------------------------------------------------------------------------------

/// 20 s of the triangle with the paper's breakaway as the longest table. Out of line and without variables of its own, so
/// that the code around the other counts stays as it is.
static __attribute__((noinline)) void run_table(void)
{
    tribo_force_loop_f32_config_t      config   = tribo_force_loop_f32_paper();
    tribo_friction_f32_config_t *const friction = &config.compensator.friction;
    tribo_breakaway_point_f32_t        table[TRIBO_BREAKAWAY_POINTS_MAX];
    point_t                            points[TRIBO_BREAKAWAY_POINTS_MAX]; // the same in this arithmetic
    for (uint32_t i = 0; i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        const float grown   = friction->positive.slope * ((float)i * 0.04f);
        table[i].force_n    = (float)i * 0.04f;
        table[i].positive_n = friction->positive.offset_n + grown;
        table[i].negative_n = friction->negative.offset_n + grown;
    }
    friction->table        = table;
    friction->table_length = TRIBO_BREAKAWAY_POINTS_MAX;
    if (INIT(&other, &config, points) != TRIBO_OK)
    {
        return; // the figures will be missed
    }

    counts_t tick   = {0};
    uint32_t hashed = 2166136261u;
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    for (int32_t k = 0; k < 20000; k++)
    {
        const number_t r = triangle(k);
        number_t       u;
        u = counted_tick(&other, &axis[0], r, plant.sensor, &signals);
        counts_add(&tick);
        hashed = hash(hashed, u);
        plant_step(u);
    }
    print_counts("tick.table", &tick);
    print("hash", ".table", hashed);

    // Changes to that and four sections, and back: the most that a tick can need.
    const tribo_biquad_f32_section_t lag    = {0.5f, 0.5f, 0.0625f, 1.0f, 0.125f};
    const tribo_biquad_f32_section_t four[] = {config.controller.sections[0], config.controller.sections[1], lag, lag};
    config.controller.sections              = four;
    config.controller.section_count         = 4;
    if (INIT(&other, &config, points) == TRIBO_OK)
    {
        print("stack.largest", "", stack_of_ticks(&paper, &other));
    }
}

// --- feed-forward --------------------------------------------------------------------------------------------------

/// Fast triangles, on which breakaway is learned, and after each a stand, in which friction is fed back.
static number_t triangle_and_stand(int32_t tick)
{
    const int32_t phase = tick % 8000;
    return triangle(phase < 5500 ? 5 * phase : 27500);
}

/// The loop with the feed-forward; like the table's run out of line.
static __attribute__((noinline)) void run_feedforward(void)
{
    const tribo_force_loop_f32_config_t  config   = tribo_force_loop_f32_paper();
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    if (INIT_FED(&other, &feedforward, &config, &standard) != TRIBO_OK)
    {
        return; // the figures will be missed
    }
    counts_t tick            = {0};
    counts_t search          = {0};
    counts_t without_signals = {0};
    uint32_t hashed          = 2166136261u;
    search_t s               = {.kind = 0};
    random_state             = 0x7ab5u;
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    TRIBO(feedforward, reset)(&feedforward, &memory.state);
    ATTACH(&axis[0], &memory);
    for (int32_t k = 0; k < 16000 + SEARCH_TICKS; k++)
    {
        s.r = triangle_and_stand(k);
        s.y = plant.sensor;
        if (k >= 16000)
        {
            search_step(&s, k);
        }
        const number_t u = k % 4 == 3 ? counted_tick_without_signals(&other, &axis[0], s.r, s.y)
                                      : counted_tick(&other, &axis[0], s.r, s.y, &signals);
        counts_add(k % 4 == 3 ? &without_signals : k < 16000 ? &tick : &search);
        hashed = hash(hashed, u);
        plant_step(u);
    }
    print_counts("feedforward.tick", &tick);
    print_counts("feedforward.search", &search);
    print_counts("feedforward.without_signals", &without_signals);
    print("hash", ".feedforward", hashed);
    print("stack.feedforward", "", stack_of_ticks(&other, &other));
    print("stack.methods", "", stack_of_ticks(&paper, &other));
    print("ram.feedforward", "", (uint32_t)sizeof memory);
    print("flash.feedforward_params", "", (uint32_t)sizeof feedforward);
}

/// The guard beside the loop with the feed-forward. It judges turns of small forces here, so that many ticks have one.
static __attribute__((noinline)) void run_guard(void)
{
    static TRIBO(guard, params_t) guard_params;
    static TRIBO(guard, state_t) guard;
    const tribo_guard_f32_config_t quick = {.turn_n       = 1.0e-3f,
                                            .quick_time_s = 0.2f,
                                            .stray_n      = 1.0e-3f,
                                            .fade_time_s  = 0.5f};
    if (INIT_GUARD(&guard_params, &quick) != TRIBO_OK)
    {
        return; // the figures will be missed
    }
    counts_t counts = {0};
    search_t s      = {.kind = 0};
    random_state    = 0x6a3du;
    plant_reset();
    TRIBO(guard, reset)(&guard);
    TRIBO(force_loop, reset)(&axis[0]);
    TRIBO(feedforward, reset)(&feedforward, &memory.state);
    ATTACH(&axis[0], &memory);
    for (int32_t k = 0; k < 8000 + SEARCH_TICKS; k++)
    {
        s.r = triangle_and_stand(k);
        s.y = plant.sensor;
        if (k >= 8000)
        {
            search_step(&s, k);
        }
        const number_t u = TRIBO(force_loop, step)(&other, &axis[0], s.r, s.y, &signals);
        (void)counted_watch(&guard_params, &guard, &axis[0], s.r, s.y);
        counts_add(&counts);
        if (k % 2000 == 0)
        {
            TRIBO(guard, restore)(&guard);
        }
        plant_step(u);
    }
    print_counts("guard", &counts);
    print("ram.guard", "", (uint32_t)sizeof guard);
}

// --- LuGre ---------------------------------------------------------------------------------------------------------

/// Explicit Euler steps of Eq. (12) that a tick needs, the fewest with which its fastest rate, 1/s, does not grow: h rate/n < 2.
static uint32_t explicit_steps(float tick_s, float rate)
{
    return (uint32_t)(0.5f * tick_s * rate) + 1u;
}

/// The rates are those of the speed: (s1 (1 - s0 z sign(w)/L) + s2 + b)/I with relaxed bristles, and where the arm reverses and z
/// is still -L/s0, and of z, s0 |w|/L, where the arm follows the triangle.
static void print_explicit_steps(const tribo_force_loop_f32_config_t *config, const tribo_lugre_f32_config_t *bristles)
{
    const tribo_arm_f32_config_t *const arm         = &config->compensator.arm;
    const tribo_breakaway_f32_t *const  law         = &config->compensator.friction.positive;
    const float                         other_rates = (bristles->viscous + arm->damping) / arm->inertia;
    const float                         speed       = 0.02f / arm->stiffness;
    const float                         L           = law->offset_n + law->slope * 0.4f;
    const float                         at_rest     = bristles->damping / arm->inertia + other_rates;
    const float reversing = 2.0f * bristles->damping / arm->inertia + other_rates + bristles->stiffness * speed / L;
    print("lugre.explicit_steps.at_rest", "", explicit_steps(config->sample_time_s, at_rest));
    print("lugre.explicit_steps.reversing", "", explicit_steps(config->sample_time_s, reversing));
}

/// The loop with LuGre; like the table's run out of line.
static __attribute__((noinline)) void run_lugre(void)
{
    const tribo_force_loop_f32_config_t config   = tribo_force_loop_f32_paper();
    const tribo_lugre_f32_config_t      bristles = tribo_lugre_f32_paper();
    if (INIT_LUGRE(&other, &lugre, &config, &bristles) != TRIBO_OK)
    {
        return; // the figures will be missed
    }
    counts_t tick            = {0};
    counts_t search          = {0};
    counts_t without_signals = {0};
    uint32_t hashed          = 2166136261u;
    search_t s               = {.kind = 0};
    random_state             = 0x7ab5u;
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    for (int32_t k = 0; k < 20000 + SEARCH_TICKS; k++)
    {
        s.r = triangle(k);
        s.y = plant.sensor;
        if (k >= 20000)
        {
            search_step(&s, k);
        }
        const number_t u = k % 4 == 3 ? counted_tick_without_signals(&other, &axis[0], s.r, s.y)
                                      : counted_tick(&other, &axis[0], s.r, s.y, &signals);
        counts_add(k % 4 == 3 ? &without_signals : k < 20000 ? &tick : &search);
        hashed = hash(hashed, u);
        plant_step(u);
    }
    print_counts("lugre.tick", &tick);
    print_counts("lugre.search", &search);
    print_counts("lugre.without_signals", &without_signals);
    print("hash", ".lugre", hashed);
    print("stack.lugre", "", stack_of_ticks(&other, &other));
    print("stack.lugre_methods", "", stack_of_ticks(&paper, &other));
    print("flash.lugre_params", "", (uint32_t)sizeof lugre);
    print_explicit_steps(&config, &bristles);
}

int main(void)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    if (INIT(&paper, &config, NULL) != TRIBO_OK)
    {
        return 1;
    }
    config.gain = 0.5f;
    if (INIT(&other, &config, NULL) != TRIBO_OK)
    {
        return 1;
    }
#ifdef COST_TRACE // some ticks on the way up, for tools/bench-target to look at the last one
    plant_reset();
    TRIBO(force_loop, reset)(&axis[0]);
    for (int32_t k = 0; k < 200; k++)
    {
        plant_step(TRIBO(force_loop, step)(&paper, &axis[0], triangle(k), plant.sensor, &signals));
    }
#else
    counter_init();
    run_triangle();
    run_search();
    run_retuning();
    run_axes();
    print("stack.tick", "", stack_of_ticks(&paper, &paper));
    print("stack.retuning", "", stack_of_ticks(&paper, &other));
    print_stack_of_modules();
    print("ram.axis", "", (uint32_t)sizeof(loop_state_t));
    print("flash.params", "", (uint32_t)sizeof(loop_params_t));
    run_table();
    run_feedforward();
    run_guard();
    run_lugre();
#endif
    return 0;
}
