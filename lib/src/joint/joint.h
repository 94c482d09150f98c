// A joint with current and encoder: its tick, its init and what it reports. This text serves both arithmetics;
// joint_f32.c and joint_q31.c include it after their words.

#include "joint_config.h"

typedef NAME(joint, t) joint_t;
typedef NAME(joint, params_t) joint_params_t;
typedef NAME(joint, slide_t) joint_slide_t;

static int8_t sign_of(way_t x)
{
    return (int8_t)((x > 0) - (x < 0));
}

/// Moves a play by `moved`. Returns the side to which the play is pushed, or 0 while the motion stays within it.
static int8_t push(way_t *slack, way_t moved, way_t half)
{
    const way_t wanted = plus(*slack, moved);
    if (!beyond(wanted, half))
    {
        *slack = wanted;
        return 0;
    }
    *slack = wanted > 0 ? half : -half;
    return wanted > 0 ? 1 : -1;
}

/// Latches a cause, unless one is latched already.
static void trip(joint_t *x, tribo_joint_cause_t cause)
{
    if (x->cause == TRIBO_JOINT_SOUND)
    {
        x->cause = (uint8_t)cause;
    }
}

/// Notes whether the loop is on: away from q_ref it would have an effort. A hand that leads, with q as q_ref, needs none.
static void note_loop(joint_t *x, force_t effort, way_t off)
{
    if (effort != 0 || off == 0)
    {
        x->alive = x->params.rest_ticks;
    }
    else if (x->alive > 0u && beyond(off, JOINT_DEADBAND * x->params.half))
    {
        x->alive--;
    }
}

/// Chooses the direction of the term. `off` is q_ref - q.
static void direct(joint_t *x, way_t intended, way_t off, force_t effort)
{
    const way_t  half = x->params.half;
    const int8_t side = push(&x->slack, intended, half / 2);

    x->still = x->still < x->params.rest_ticks ? x->still + 1u : x->still;
    if (side != 0)
    {
        if (x->still == x->params.rest_ticks)
        {
            const force_t wound = minus(effort, x->offset);
            x->kept             = within_of(side > 0 ? wound : minus(0, wound), 0, x->level);
        }
        x->intended = side;
        x->still    = 0;
        x->turns    = 0;
    }
    x->is_off = 0;
    if (x->still < x->params.rest_ticks)
    {
        x->sign = x->intended;
        return;
    }
    x->is_off         = beyond(off, JOINT_DEADBAND * half);
    const int8_t back = x->is_off != 0u ? sign_of(off) : x->sign;
    if (back != x->sign)
    {
        x->sign  = back;
        x->turns = x->turns < JOINT_TURNS ? (uint8_t)(x->turns + 1u) : x->turns;
        if (x->turns == JOINT_TURNS)
        {
            trip(x, TRIBO_JOINT_HUNTING);
        }
    }
}

/// How far a loop may overshoot a q_ref that has started or turned quickly: 0.2 s at half of the joint's own peak speed,
/// up to half of the travel that q_ref has asked for, there and back.
static long_t overshoot(const joint_t *x)
{
    const long_t own   = JOINT_AHEAD * (long_t)(x->slide.peak / 2) * (way_t)x->params.rest_ticks;
    const long_t asked = (x->slide.asked[0] + x->slide.asked[1]) / 2;
    return own < asked ? own : asked;
}

/// Trips if the joint runs ahead of q_ref with its term, by more than JOINT_ASTRAY, more than 0.2 s at half of its last
/// peak speed, and more than an overshoot.
static void guard(joint_t *x, way_t intended, way_t measured, way_t off)
{
    const way_t ahead    = x->sign > 0 ? plus(measured, -intended) : plus(intended, -measured);
    const way_t sum      = plus(x->astray, ahead);
    const bool  is_ahead = x->sign > 0 ? off < 0 : x->sign < 0 && off > 0;
    x->astray            = is_ahead && sum > 0 ? sum : 0;
    if (x->astray > JOINT_ASTRAY * x->params.half &&
        x->astray > JOINT_AHEAD * (long_t)x->slide.knee * (way_t)x->params.rest_ticks && x->astray > overshoot(x))
    {
        trip(x, TRIBO_JOINT_ASTRAY);
    }
}

/// Learns from one slide in each direction: their mean is friction, their difference the load, which does not reverse.
/// Two slides change the learned values by up to a quarter.
static void learn(joint_t *x)
{
    joint_slide_t *const slide = &x->slide;

    const force_t sum  = slide->mean[0] / 2 + slide->mean[1] / 2; // of efforts against the motion
    const force_t diff = slide->mean[1] / 2 - slide->mean[0] / 2;
    if (sum < 0)
    {
        x->against = x->against < JOINT_AGAINST ? (uint8_t)(x->against + 1u) : x->against;
        if (x->against == JOINT_AGAINST)
        {
            trip(x, TRIBO_JOINT_REVERSED);
        }
        x->friction -= x->friction / 4;
        return;
    }
    x->against = 0;
    if (x->learned == 0u)
    {
        x->learned  = 1;
        x->friction = sum;
        x->offset   = diff;
        x->spread   = sum / 4;
        return;
    }
    const force_t error = minus(sum, x->friction);
    const force_t most  = x->friction / 2 + x->params.effort_max / 256;
    x->friction         = plus(x->friction, within_of(error, -most, most) / 2);
    x->offset           = plus(x->offset, minus(diff, x->offset) / 2);
    x->spread           = plus(x->spread, minus(size_of(error), x->spread) / 4);
}

/// True for a slide that lasts a few time constants of the low pass. The reversals of friction at both ends then fill its
/// slow part, whose mean effort is less than half of the friction and may have either sign.
static bool is_brief(const joint_t *x)
{
    return faded_by((force_t)x->slide.ticks, x->params.observer_part) < JOINT_BRIEF;
}

/// Takes the mean effort against the motion over the slow part of a slide, or over all of it if that part is short or the
/// slide brief, and keeps the fast part for the next tick. The travel back within the play is added, because friction
/// acts there as well.
static void take_mean(joint_slide_t *slide, way_t half, bool is_whole)
{
    const bool   is_up = slide->side > 0;
    const long_t slow  = is_up ? slide->slow_travel : -slide->slow_travel;
    const long_t all   = is_up ? slide->travel : -slide->travel;
    slide->fast_travel = 0;
    if (is_whole || slow < JOINT_SLOW_MIN * (long_t)half || slow < all / JOINT_SLOW_PART)
    {
        slide->mean[is_up] = mean_effort(slide->work, all + 4 * (long_t)half);
        return;
    }
    slide->mean[is_up] = mean_effort(slide->slow_work, slow + 4 * (long_t)half);
    if (slide->peak > slide->knee + slide->knee / 2)
    {
        slide->fast_travel = all - slow;
        slide->fast_work   = slide->work - slide->slow_work;
    }
}

/// Voids the slide and takes the term out at once.
static void stop(joint_t *x)
{
    x->slide.ticks  = JOINT_TICKS_MAX;
    x->slide.moved  = 0;
    x->slide.effort = 0;
    x->direction    = 0;
    x->level        = 0;
    x->term         = 0;
    x->kept         = 0;
    x->lagged       = 0;
}

/// Forgets all that a flipped bit may have made infinite, or no number. A sound load stays.
static void forget(joint_t *x)
{
    stop(x);
    x->slide.ended  = 0;
    x->slide.has[0] = 0;
    x->slide.has[1] = 0;
    x->learned      = 0;
    x->friction     = 0;
    x->spread       = 0;
    x->offset       = 0;
    x->load         = effort_is_bad(x->load) ? 0 : x->load;
    count_one(&x->bad_inputs);
}

static void forget_if(joint_t *x, bool is_ruined)
{
    if (is_ruined)
    {
        forget(x);
    }
}

/// The two ticks after a slide: the first one learns, because two divisions in one tick are too many without an FPU, and
/// the second one looks for corrupt states. From zero to the knee the mean speed is two thirds of the knee, and beyond it
/// about 1.7 knees, so viscous friction is extrapolated to zero speed. A fast part that takes less counts in place of the
/// slow one, whose effort also lifts a load or bends a gear.
static void finish_slide(joint_t *x)
{
    joint_slide_t *const slide = &x->slide;
    force_t *const       mean  = &slide->mean[slide->side < 0]; // the motion has turned since

    slide->ended--;
    if (slide->ended == 0u)
    {
        forget_if(x, is_corrupt(x));
        return;
    }
    if (slide->fast_travel > 0)
    {
        const force_t fast = mean_effort(slide->fast_work, slide->fast_travel);
        const force_t rise = minus(fast, plus(*mean, *mean / JOINT_VISCOUS_MIN));
        *mean              = minus(*mean, within_of(rise / 8 * JOINT_VISCOUS, 0, size_of(*mean) / 4 * 3));
        *mean              = fast < *mean ? fast : *mean;
    }
    if (slide->has[0] != 0u && slide->has[1] != 0u)
    {
        learn(x);
    }
}

/// Ends a slide. It counts if it is long enough and if q_ref asked for it. A sticking joint starts long after q_ref, so
/// the travel of q_ref is counted from the last slide in that direction on. Far less travel is a rebound of the gear.
static void end_slide(joint_t *x)
{
    joint_slide_t *const slide = &x->slide;

    const bool   is_up    = slide->side > 0;
    const long_t travel   = is_up ? slide->travel : -slide->travel;
    const long_t asked    = slide->asked[is_up];
    const bool   is_sound = slide->ticks < JOINT_TICKS_MAX && travel >= JOINT_SLIDE_MIN * (long_t)x->params.half;
    if (is_sound && slide->follows != 0u && asked >= travel / 2 && travel >= asked / JOINT_REBOUND)
    {
        take_mean(slide, x->params.half, is_brief(x));
        slide->has[is_up] = 1;
        slide->ended      = 2;
        slide->knee       = slide->peak / 2;
    }
    slide->ticks        = 0;
    slide->follows      = 0;
    slide->travel       = 0;
    slide->asked[is_up] = 0;
    slide->work         = 0;
    slide->slow_travel  = 0;
    slide->slow_work    = 0;
    slide->peak         = 0;
}

/// Runs one tick of a slide. The same low pass for motion and effort keeps the kinetic energy in balance, and smooths
/// the counts of an encoder.
static void slide_on(joint_t *x, way_t intended, way_t measured, way_t off)
{
    joint_slide_t *const        slide  = &x->slide;
    const joint_params_t *const params = &x->params;

    if (slide->ended != 0u)
    {
        finish_slide(x);
    }
    slide->moved      = way_track(slide->moved, measured, params->observer_part);
    slide->effort     = force_track(slide->effort, minus(x->lagged, x->load), params->observer_part);
    const int8_t side = push(&slide->slack, slide->moved, params->half);
    x->direction      = direction_track(x->direction, side, params->observer_part);
    if (side != 0 && side != slide->side)
    {
        end_slide(x);
        slide->side = side;
    }
    if (x->still == 0u)
    {
        slide->asked[x->intended > 0] += size_of(intended);
    }
    if (slide->ticks == JOINT_TICKS_MAX || is_too_long(slide))
    {
        slide->ticks = JOINT_TICKS_MAX;
        forget_if(x, is_no_number(slide->moved));
        return;
    }
    const way_t  speed = size_of(slide->moved);
    const long_t work  = work_of(slide->effort, slide->moved);
    slide->ticks++;
    slide->follows = slide->follows != 0u || off != 0 ? 1u : 0u;
    slide->travel += slide->moved;
    slide->work += work;
    slide->peak = speed > slide->peak ? speed : slide->peak;
    if (speed <= slide->knee)
    {
        slide->slow_travel += slide->moved;
        slide->slow_work += work;
    }
    else
    {
        forget_if(x, is_no_number(speed));
    }
}

/// Returns the value that the term moves to: 0 without a loop or an encoder. At rest the term gives way to an effort
/// that opposes it, and away from q_ref it needs an effort that points back, so that the term alone never moves the
/// joint.
static force_t wanted_term(const joint_t *x, force_t effort)
{
    force_t size = faded_by(x->level, x->share);
    force_t less = within_of(x->kept, 0, size);
    if (x->alive == 0u)
    {
        return 0;
    }
    if (x->still == x->params.rest_ticks)
    {
        if (effort == 0)
        {
            return 0;
        }
        size = halved(size, x->turns > 1u ? (x->turns - 1u) & (JOINT_TURNS - 1u) : 0u); // at most 3

        const force_t wound  = minus(effort, x->offset);
        const force_t toward = x->sign < 0 ? minus(0, wound) : wound;
        if (x->is_off != 0u)
        {
            size = within_of(toward, 0, size / JOINT_SUPPORT) * JOINT_SUPPORT;
            less = 0;
        }
        else
        {
            less = within_of(minus(0, toward), 0, size);
            less = plus(less, less);
        }
    }
    return x->sign < 0 ? less - size : (x->sign > 0 ? size - less : 0);
}

/// Moves the term towards its wanted value and returns it. It follows a falling level even behind a slow actuator.
static force_t term_of(joint_t *x, force_t effort)
{
    const joint_params_t *const params = &x->params;

    const force_t known    = x->learned != 0u ? x->friction : x->friction / JOINT_UNLEARNED;
    const fade_t  gain     = x->slide.follows != 0u ? params->gain : params->led;
    const bool    is_sound = x->cause == TRIBO_JOINT_SOUND;
    x->level               = force_track(x->level, faded_by(known, gain), params->level_part);
    x->share               = next_fade(x->share, is_sound ? params->fade_step / 8 : params->fade_step, is_sound);
    x->kept                = force_track(x->kept, 0, params->level_part);

    const force_t most = plus(faded_by(x->level, params->jump), SMALLEST);
    const force_t next = plus(x->term, within_of(minus(wanted_term(x, effort), x->term), -most, most));
    x->term            = next > x->level ? x->level : (next < -x->level ? -x->level : next); // no number stays none
    return x->term;
}

/// Returns `sum` within the limit of u. A corrupt joint is forgotten, and its u is the loop's `effort`.
static force_t limited(joint_t *x, long_t sum, force_t effort)
{
    const force_t most = x->params.effort_max;
    if (sum >= -(long_t)most && sum <= most)
    {
        return (force_t)sum;
    }
    count_one(&x->limited_ticks);
    if (is_corrupt(x))
    {
        forget(x);
        return within_of(effort, -most, most);
    }
    return sum > 0 ? most : -most;
}

/// Returns the change of q in this tick. A jump, which the motion in the tick before does not lead to, counts as none and
/// voids the slide.
static way_t motion(joint_t *x, position_t now, position_t before)
{
    const way_t moved = way_between(&x->params, now, before);
    const bool  jumps = beyond(minus(moved, x->moved), plus(x->params.fastest, size_of(x->moved)));
    x->moved          = moved;
    if (jumps)
    {
        x->slide.ticks = JOINT_TICKS_MAX;
        return 0;
    }
    return moved;
}

force_t NAME(joint, step)(joint_t *joint, force_t effort, position_t q_ref, position_t q)
{
    if (joint->made == 0u)
    {
        return 0;
    }
    const bool is_bad = position_is_bad(q_ref) || position_is_bad(q);
    if (is_bad || effort_is_bad(effort))
    {
        count_one(&joint->bad_inputs);
    }
    const force_t sound = effort_is_bad(effort) ? 0 : effort;
    if (!is_bad)
    {
        if (joint->runs == 0u)
        {
            joint->runs  = 1;
            joint->q_ref = q_ref;
            joint->q     = q;
        }
        const way_t intended =
            way_between(&joint->params, q_ref, joint->q_ref); // of any size: a step is an intention as well
        const way_t measured = motion(joint, q, joint->q);
        const way_t off      = way_between(&joint->params, q_ref, q);
        joint->q_ref         = q_ref;
        joint->q             = q;
        direct(joint, intended, off, sound);
        guard(joint, intended, measured, off);
        slide_on(joint, intended, measured, off);
        note_loop(joint, sound, off);
    }
    else if (joint->alive > 0u)
    {
        joint->alive--;
    }
    const force_t u = limited(joint, (long_t)sound + joint->load + term_of(joint, sound), sound);
    joint->lagged   = force_track(joint->lagged, u, joint->params.actuator_part);
    return u;
}

void NAME(joint, load)(joint_t *joint, force_t load)
{
    if (effort_is_bad(load))
    {
        count_one(&joint->bad_inputs);
        return;
    }
    joint->load = load;
}

void NAME(joint, rest)(joint_t *joint)
{
    stop(joint);
    joint->runs     = 0;
    joint->sign     = 0;
    joint->intended = 0;
    joint->turns    = 0;
    joint->still    = joint->params.rest_ticks;
    joint->alive    = joint->params.rest_ticks;
    joint->slack    = 0;
    joint->astray   = 0;
}

void NAME(joint, restore)(joint_t *joint)
{
    joint->cause   = TRIBO_JOINT_SOUND;
    joint->turns   = 0;
    joint->against = 0;
    joint->astray  = 0;
}

tribo_status_t NAME(joint, gain)(joint_t *joint, float gain)
{
    if (!within(gain, 0.0f, 1.0f))
    {
        return TRIBO_ERR_JOINT_GAIN;
    }
    joint->params.gain = part_of(gain);
    joint->params.led  = part_of(limit_f32(gain, 0.0f, JOINT_LED));
    return TRIBO_OK;
}

tribo_status_t NAME(joint, init)(joint_t *joint, const tribo_joint_config_t *config)
{
    if (joint == NULL || config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_status_t status = check_config(config);
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float    h        = config->sample_time_s;
    const float    pole     = config->actuator_pole_rad_per_s;
    const float    lag      = (pole > 0.0f ? 1.0f / pole : 0.0f) + JOINT_LAG_TICKS * h;
    const float    observer = larger(larger(JOINT_OBSERVER_TIME * lag, JOINT_OBSERVER_TICKS * h), JOINT_OBSERVER_LEAST);
    const float    actuator = pole > 0.0f ? first_order_f32_part(limit_f32(pole * h, 0.0f, 50.0f)) : 1.0f;
    const uint32_t rest     = (uint32_t)larger(JOINT_REST_TIME / h, 4.0f);

    *joint = (joint_t){.params = {.jump          = part_of(limit_f32(2.0f * h / (JOINT_JUMP_TIME * lag), 0.0f, 1.0f)),
                                  .level_part    = part_of(first_order_f32_lag(JOINT_LEVEL_TIME, h)),
                                  .observer_part = part_of(first_order_f32_lag(observer, h)),
                                  .actuator_part = part_of(actuator),
                                  .fade_step     = part_of(limit_f32(h / JOINT_FADE_TIME, 0.0f, 1.0f)),
                                  .rest_ticks    = rest},
                       .made   = 1,
                       .share  = ALL,
                       .still  = rest,
                       .alive  = rest};
    set_units(joint, config);
    return NAME(joint, gain)(joint, config->gain);
}

tribo_joint_force_t NAME(joint, force)(const joint_t *joint)
{
    const float friction = in_units(joint, joint->friction);
    const float moving   = friction * ((float)joint->direction / (float)DIRECTION_ONE);
    const float force    = in_units(joint, joint->slide.effort) - moving;
    const float more     = joint->learned != 0u ? 0.0f : in_units(joint, joint->params.effort_max);
    const float half     = JOINT_INTERVAL * friction + more;
    return (tribo_joint_force_t){.force = force, .low = force - half, .high = force + half};
}

void NAME(joint, report)(const joint_t *joint, tribo_joint_report_t *report)
{
    const bool  is_learned = joint->learned != 0u;
    const float friction   = in_units(joint, joint->friction);
    const float by         = 2.0f * in_units(joint, joint->spread) + JOINT_MODEL * friction;

    report->friction      = friction;
    report->low           = is_learned ? larger(friction - by, 0.0f) : 0.0f;
    report->high          = is_learned ? friction + by : in_units(joint, joint->params.effort_max);
    report->is_learned    = is_learned;
    report->load          = in_units(joint, joint->offset);
    report->share         = (float)joint->share * SHARE_UNIT;
    report->cause         = (tribo_joint_cause_t)joint->cause;
    report->bad_inputs    = joint->bad_inputs;
    report->limited_ticks = joint->limited_ticks;
}
