// What a tick costs on this target, in instructions and bytes: prints one figure a line, "name value", for the budget test
// and tools/dev/bench-target. The hashes are of all u of a run; they are the same on every target and on the host.

#include "../support/cascade_f32.h"
#include "../support/cascade_q31.h"
#include "../support/init_parts.h"
#include "controller/anti_windup_f32.h"
#include "controller/anti_windup_q31.h"
#include "counter.h"
#include "friction/arm_f32.h"
#include "friction/arm_q31.h"
#include "friction/law_f32.h"
#include "friction/law_q31.h"

#include <stdio.h>

typedef TRIBO(force_loop, params_t) loop_params_t;
typedef TRIBO(force_loop, state_t) loop_state_t;
typedef TRIBO(force_loop, signals_t) loop_signals_t;

#define FULL_SCALE_N 2.0f
#define TICKS        60000 // 60 s
#define SEARCH_TICKS 20000
#define SPLIT_EVERY  20 // ticks: then the modules are counted, too
#define AXES_MAX     16
#define STACK_WORDS  384

static loop_params_t  paper;
static loop_params_t  other; // to retune to and fro
static loop_state_t   axis[AXES_MAX];
static loop_signals_t signals;

static TRIBO(feedforward, params_t) feedforward;
static TRIBO(feedforward, memory_t) memory;

// --- forces --------------------------------------------------------------------------------------------------------

static inline tribo_force_t number(int32_t millinewton)
{
    return TRIBO_EITHER((float)millinewton * 1e-3f, (int32_t)((int64_t)millinewton * 2147483647 / 2000));
}

/// `of_65536` parts of x, of 65536.
static inline tribo_force_t part(tribo_force_t x, int32_t of_65536)
{
    return TRIBO_EITHER(x * ((float)of_65536 * (1.0f / 65536.0f)), (int32_t)((int64_t)x * of_65536 / 65536));
}

/// From x towards `target` by `of_65536` parts of the distance.
static inline tribo_force_t approach(tribo_force_t x, tribo_force_t target, int32_t of_65536)
{
    return TRIBO_EITHER(x + part(target - x, of_65536), (int32_t)(x + ((int64_t)target - x) * of_65536 / 65536));
}

static void step_axes(uint32_t axes, tribo_force_t r)
{
    for (uint32_t i = 0; i < axes; i++)
    {
        (void)TRIBO(force_loop, step)(&paper, &axis[i], r, number(0), &signals);
    }
}

// --- what is counted -----------------------------------------------------------------------------------------------

#define PARAMS(noun) const TRIBO(noun, params_t) * params
#define STATE(noun)  TRIBO(noun, state_t) * state

/// Defines `name`, a step that lib has inline only, as a function of its own.
#define ALONE(type, name, parameters, statement)                                                                       \
    static COUNTED_ALONE type name parameters                                                                          \
    {                                                                                                                  \
        statement;                                                                                                     \
    }

ALONE(tribo_force_t,
      controller_alone,
      (PARAMS(controller),
       STATE(controller),
       tribo_force_t e,
       tribo_force_t friction,
       TRIBO(controller, signals_t) * out),
      return TRIBO_PART(controller, step)(params, state, e, friction, out))
ALONE(tribo_force_t,
      cascade_alone,
      (PARAMS(biquad), STATE(biquad), tribo_force_t e),
      return TRIBO_PART(cascade, step)(params, state, e))
ALONE(tribo_force_t,
      output_alone,
      (PARAMS(biquad), STATE(biquad), tribo_force_t e, TRIBO(biquad, outputs_t) * nodes),
      return TRIBO_PART(biquad, output)(params, state, e, nodes))
ALONE(void,
      advance_alone,
      (PARAMS(biquad), STATE(biquad), tribo_force_t e, const TRIBO(biquad, outputs_t) * nodes),
      TRIBO_EITHER(biquad_f32_advance(params, state, e, nodes, 0.0f),
                   ((void)e, biquad_q31_advance(params, state, nodes, 0))))
ALONE(void, arm_alone, (PARAMS(arm), STATE(arm), tribo_force_t drive), TRIBO_PART(arm, step)(params, state, drive))
ALONE(uint8_t,
      relay_alone,
      (tribo_relay_state_t * state, uint8_t width, uint8_t events),
      return (uint8_t)relay_step(state, width, events))
ALONE(uint8_t,
      edge_alone,
      (tribo_edge_state_t * state, uint8_t width, uint8_t events),
      return (uint8_t)edge_step(state, width, events))

COUNTED(tribo_force_t,
        counted_tick,
        (PARAMS(force_loop), STATE(force_loop), tribo_force_t r, tribo_force_t y, loop_signals_t *out),
        TRIBO(force_loop, step)(params, state, r, y, out))
COUNTED(tribo_force_t,
        counted_tick_without_signals,
        (PARAMS(force_loop), STATE(force_loop), tribo_force_t r, tribo_force_t y),
        TRIBO(force_loop, step)(params, state, r, y, NULL))
COUNTED(tribo_force_t,
        counted_controller,
        (PARAMS(controller),
         STATE(controller),
         tribo_force_t e,
         tribo_force_t friction,
         TRIBO(controller, signals_t) * out),
        controller_alone(params, state, e, friction, out))
COUNTED(tribo_force_t,
        counted_compensator,
        (PARAMS(compensator), STATE(compensator), tribo_force_t u, TRIBO(compensator, signals_t) * out),
        TRIBO(compensator, step)(params, state, u, out))
COUNTED(tribo_force_t,
        counted_cascade,
        (PARAMS(biquad), STATE(biquad), tribo_force_t e),
        cascade_alone(params, state, e))
COUNTED(int,
        counted_output,
        (PARAMS(biquad), STATE(biquad), tribo_force_t e, TRIBO(biquad, outputs_t) * nodes),
        ((void)output_alone(params, state, e, nodes), 0))
COUNTED(int,
        counted_advance,
        (PARAMS(biquad), STATE(biquad), tribo_force_t e, const TRIBO(biquad, outputs_t) * nodes),
        (advance_alone(params, state, e, nodes), 0))
COUNTED(tribo_force_t,
        counted_friction,
        (PARAMS(friction), STATE(friction), tribo_force_t u, tribo_force_t force, TRIBO(friction, signals_t) * out),
        TRIBO(friction, step)(params, state, u, force, out))
COUNTED(int, counted_arm, (PARAMS(arm), STATE(arm), tribo_force_t drive), (arm_alone(params, state, drive), 0))
COUNTED(uint8_t,
        counted_relay,
        (tribo_relay_state_t * state, uint8_t width, uint8_t events),
        relay_alone(state, width, events))
COUNTED(uint8_t,
        counted_edge,
        (tribo_edge_state_t * state, uint8_t width, uint8_t events),
        edge_alone(state, width, events))
COUNTED(int,
        counted_watch,
        (PARAMS(guard), STATE(guard), tribo_force_t r, tribo_force_t y),
        ((void)TRIBO(guard, step)(params, state, r, y, signals.compensator.friction.TRIBO_N(f), true), 0))
COUNTED(int, counted_axes, (uint32_t axes, tribo_force_t r), (step_axes(axes, r), 0))

// --- the plant: actuator, arm with friction, sensor ----------------------------------------------------------------

static struct
{
    tribo_force_t actuator, sensor;
    TRIBO(compensator, state_t) arm;
} plant;

static void plant_reset(void)
{
    plant.actuator = number(0);
    plant.sensor   = number(0);
    TRIBO(compensator, reset)(&plant.arm);
}

/// Poles -200 and -55 rad/s at 1 ms.
static void plant_step(tribo_force_t u)
{
    TRIBO(compensator, signals_t) seen;
    plant.actuator = approach(plant.actuator, u, 11880);
    (void)TRIBO(compensator, step)(&paper.compensator, &plant.arm, plant.actuator, &seen);
    plant.sensor = approach(plant.sensor, seen.TRIBO_N(force), 3507);
}

// --- inputs --------------------------------------------------------------------------------------------------------

/// 0.4 to 0.6 N, period 20 s.
static tribo_force_t triangle(int32_t tick)
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

static tribo_force_t random_force(int32_t largest_millinewton)
{
    return part(number(largest_millinewton), (int32_t)(random_bits() >> 15) - 65536);
}

typedef struct
{
    uint32_t      kind;
    tribo_force_t r, y, slope, error;
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
        s->r = tribo_force_of_word(random_bits());
        s->y = tribo_force_of_word(random_bits());
        break;
    }
}

// --- figures -------------------------------------------------------------------------------------------------------

static void print(const char *name, const char *of, uint32_t value)
{
    printf("%s.%s%s %lu\n", TRIBO_ARITHMETIC, name, of, (unsigned long)value);
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
    const tribo_force_t                       u     = in->controller.TRIBO_N(u);
    const tribo_force_t                       force = in->compensator.TRIBO_N(force);
    const tribo_force_t drive = in->compensator.friction.TRIBO_N(n) - in->compensator.friction.TRIBO_N(f);

    counted_controller(&paper.controller, &s.controller, in->TRIBO_N(e), in->TRIBO_N(friction_term), &out.controller);
    counts_add(&modules.controller);
    counted_compensator(&paper.compensator, &s.compensator, u, &out.compensator);
    counts_add(&modules.compensator);

    s = *before;
    (void)counted_cascade(&paper.controller.cascade, &s.controller.cascade, in->TRIBO_N(e));
    counts_add(&modules.cascade);

    s = *before;
    TRIBO(biquad, outputs_t) nodes;
    counted_output(&paper.controller.cascade, &s.controller.cascade, in->TRIBO_N(e), &nodes);
    counts_add(&modules.output);
    counted_advance(&paper.controller.cascade, &s.controller.cascade, in->TRIBO_N(e), &nodes);
    counts_add(&modules.advance);
    counted_friction(&paper.compensator.friction, &s.compensator.friction, u, force, &out.compensator.friction);
    counts_add(&modules.friction);
    counted_arm(&paper.compensator.arm, &s.compensator.arm, drive);
    counts_add(&modules.arm);

    tribo_relay_state_t *const relay  = &s.compensator.friction.relay;
    const uint8_t              width  = paper.compensator.friction.pulse_width;
    const uint8_t              events = relay->edge.line[(relay->edge.head - 1u) & TRIBO_EDGE_WIDTH_MAX];
    counted_relay(relay, width, events);
    counts_add(&modules.relay);
    counted_edge(&relay->edge, width, events);
    counts_add(&modules.edge);
}

static void axis_start(loop_state_t *state, const loop_params_t *params)
{
    (void)TRIBO(force_loop, start)(state, params, false); // a method has its memory
}

static uint32_t hash(uint32_t so_far, tribo_force_t u)
{
    return (so_far ^ tribo_force_word(u)) * 16777619u; // FNV-1a, by words
}

static void run_triangle(void)
{
    counts_t     tick            = {0};
    counts_t     without_signals = {0};
    uint32_t     hashed          = 2166136261u;
    loop_state_t before;
    loop_state_t copy;
    plant_reset();
    axis_start(&axis[0], &paper);
    for (int32_t k = 0; k < TICKS; k++)
    {
        const tribo_force_t r = triangle(k);
        const tribo_force_t y = plant.sensor;
        tribo_force_t       u;
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
    axis_start(&axis[0], &paper);
    for (int32_t k = 0; k < SEARCH_TICKS; k++)
    {
        tribo_force_t u;
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
    axis_start(&axis[0], &paper);
    for (int32_t k = 0; k < 500; k++)
    {
        const tribo_force_t r = triangle(k);
        tribo_force_t       u;
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
            axis_start(&axis[i], &paper);
        }
        for (int32_t k = 0; k < 200; k++)
        {
            const tribo_force_t r = triangle(k);
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
    search_t s     = {.kind = 0};
    random_state   = 0x7ab5u;
    axis[0].memory = odd->method != NULL ? &memory.state.tick : NULL;
    axis_start(&axis[0], odd);
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

/// Measures each module alone, with the signals of the tick before as its inputs.
static __attribute__((noinline)) void print_stack_of_modules(void)
{
    static struct
    {
        uint32_t controller, cascade, compensator, friction, arm, relay, edge;
    } stack;
    search_t s   = {.kind = 0};
    random_state = 0x7ab5u;
    axis_start(&axis[0], &paper);
    plant_reset();
    volatile uint32_t *const top = stack_pointer();
    for (int32_t k = 0; k < 400; k++)
    {
        search_step(&s, k * 5);
        const tribo_force_t  u   = TRIBO(force_loop, step)(&paper, &axis[0], s.r, s.y, &signals);
        const loop_signals_t in  = signals;
        loop_state_t         was = axis[0];

        paint(top);
        (void)controller_alone(&paper.controller,
                               &was.controller,
                               in.TRIBO_N(e),
                               in.TRIBO_N(friction_term),
                               &signals.controller);
        note_depth(top, &stack.controller);
        paint(top);
        (void)cascade_alone(&paper.controller.cascade, &was.controller.cascade, in.TRIBO_N(e));
        note_depth(top, &stack.cascade);
        paint(top);
        (void)TRIBO(compensator, step)(&paper.compensator, &was.compensator, u, &signals.compensator);
        note_depth(top, &stack.compensator);
        paint(top);
        (void)TRIBO(friction, step)(&paper.compensator.friction,
                                    &was.compensator.friction,
                                    u,
                                    in.compensator.TRIBO_N(force),
                                    &signals.compensator.friction);
        note_depth(top, &stack.friction);
        paint(top);
        arm_alone(&paper.compensator.arm, &was.compensator.arm, in.compensator.friction.TRIBO_N(n));
        note_depth(top, &stack.arm);
        paint(top);
        (void)relay_alone(&was.compensator.friction.relay, paper.compensator.friction.pulse_width, (uint8_t)(k & 15));
        note_depth(top, &stack.relay);
        paint(top);
        (void)edge_alone(&was.compensator.friction.relay.edge,
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
    tribo_point_t                      points[TRIBO_BREAKAWAY_POINTS_MAX]; // the same in this arithmetic
    for (uint32_t i = 0; i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        const float grown   = friction->positive.slope * ((float)i * 0.04f);
        table[i].force_n    = (float)i * 0.04f;
        table[i].positive_n = friction->positive.offset_n + grown;
        table[i].negative_n = friction->negative.offset_n + grown;
    }
    friction->table        = table;
    friction->table_length = TRIBO_BREAKAWAY_POINTS_MAX;
    if (tribo_init_loop(&other, points, &config, FULL_SCALE_N) != TRIBO_OK)
    {
        return; // the figures will be missed
    }

    counts_t tick   = {0};
    uint32_t hashed = 2166136261u;
    plant_reset();
    axis_start(&axis[0], &paper);
    for (int32_t k = 0; k < 20000; k++)
    {
        const tribo_force_t r = triangle(k);
        tribo_force_t       u;
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
    if (tribo_init_loop(&other, points, &config, FULL_SCALE_N) == TRIBO_OK)
    {
        print("stack.largest", "", stack_of_ticks(&paper, &other));
    }
}

// --- feed-forward --------------------------------------------------------------------------------------------------

/// Fast triangles, on which breakaway is learned, and after each a stand, in which friction is fed back.
static tribo_force_t triangle_and_stand(int32_t tick)
{
    const int32_t phase = tick % 8000;
    return triangle(phase < 5500 ? 5 * phase : 27500);
}

/// The loop with the feed-forward; like the table's run out of line.
static __attribute__((noinline)) void run_feedforward(void)
{
    const tribo_force_loop_f32_config_t  config   = tribo_force_loop_f32_paper();
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    if (tribo_init_feedforward(&other, NULL, &feedforward, &config, &standard, FULL_SCALE_N) != TRIBO_OK)
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
    axis[0].memory = &memory.state.tick;
    axis_start(&axis[0], &other);
    for (int32_t k = 0; k < 16000 + SEARCH_TICKS; k++)
    {
        s.r = triangle_and_stand(k);
        s.y = plant.sensor;
        if (k >= 16000)
        {
            search_step(&s, k);
        }
        const tribo_force_t u = k % 4 == 3 ? counted_tick_without_signals(&other, &axis[0], s.r, s.y)
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
    if (tribo_init_guard(&guard_params, &quick, 1e-3f, FULL_SCALE_N) != TRIBO_OK)
    {
        return; // the figures will be missed
    }
    counts_t counts = {0};
    search_t s      = {.kind = 0};
    random_state    = 0x6a3du;
    plant_reset();
    TRIBO(guard, reset)(&guard);
    axis[0].memory = &memory.state.tick;
    axis_start(&axis[0], &other);
    for (int32_t k = 0; k < 8000 + SEARCH_TICKS; k++)
    {
        s.r = triangle_and_stand(k);
        s.y = plant.sensor;
        if (k >= 8000)
        {
            search_step(&s, k);
        }
        const tribo_force_t u = TRIBO(force_loop, step)(&other, &axis[0], s.r, s.y, &signals);
        (void)counted_watch(&guard_params, &guard, s.r, s.y);
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

int main(void)
{
    tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    if (tribo_init_loop(&paper, NULL, &config, FULL_SCALE_N) != TRIBO_OK)
    {
        return 1;
    }
    config.gain = 0.5f;
    if (tribo_init_loop(&other, NULL, &config, FULL_SCALE_N) != TRIBO_OK)
    {
        return 1;
    }
#ifdef COST_TRACE // some ticks on the way up, for tools/dev/bench-target to look at the last one
    plant_reset();
    axis_start(&axis[0], &paper);
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
#endif
    return 0;
}
