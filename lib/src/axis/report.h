// What an axis reports. This text serves both arithmetics and is included by axis.h.

#define PRIOR_DEVIATION 0.45f // standard deviation of the configured breakaway before learning, as a part of it
#define MODEL_DEVIATION 0.02f // standard deviation that learning does not remove, as a part of breakaway
#define FAR_BELOW       3.0f // learned friction at its upper limit, or a load instead, as a multiple of the configured one
#define FAR_ABOVE       0.2f    // learned friction at its lower limit
#define LEARNED_LOW     0.25f   // V_0, and twice V_2, below which the configured breakaway is far too large
#define SETTLED         0.2f    // relative variance of friction that slides both ways settle
#define LONG_PRESLIDING 1.15f   // least V_2 in V_0 of an arm whose presliding is too long for the configured one
#define NO_PRESLIDING   (-0.1f) // largest V_2 in V_0 of an arm whose presliding is too short
#define CLEAR           0.4f    // least V_0 with which V_2 says so

/// True if friction is at the upper limit of learning, or if a load many times the configured breakaway takes its place
/// while slides both ways have not settled friction.
static bool is_far_below(const axis_t *axis)
{
    const tribo_feedforward_learning_t *const learning = &axis->active->feedforward.learning;
    const tribo_feedforward_learner_t *const  learner  = &axis->feedforward.learner;

    const float load = magnitude(tribo_learner_load(learning, learner, axis->active->usual_force_n));
    return tribo_learner_sliding(learning, learner) >= FAR_BELOW ||
           (learner->P[0] > SETTLED && load > FAR_BELOW * learning->breakaway_n);
}

static uint32_t bit_if(bool is_set, uint32_t bit)
{
    return is_set ? bit : 0u;
}

/// Completes a report by breakaway_factor and the warnings of a wrong breakaway or presliding.
static void report_far(const axis_t *axis, tribo_axis_report_t *report)
{
    const tribo_feedforward_learning_t *const learning = &axis->active->feedforward.learning;
    const tribo_feedforward_learner_t *const  learner  = &axis->feedforward.learner;

    const uint32_t guard      = report->warnings & (WARN_HUNTING | WARN_OVERSHOOT);
    const bool     is_settled = learner->P[0] <= SETTLED;
    const float    V_0        = tribo_learner_sliding(learning, learner);
    const float    V_2        = learning->deviation[2] * learner->a[2];
    if (axis->is_far_below != 0u)
    {
        report->breakaway_factor = FAR_BELOW;
        report->high_n[0]        = TRIBO_F32_FORCE_MAX_N;
        report->high_n[1]        = TRIBO_F32_FORCE_MAX_N;
        report->warnings |= WARN_TOO_SMALL;
    }
    else if (is_settled && V_0 < LEARNED_LOW && 2.0f * magnitude(V_2) < LEARNED_LOW)
    {
        report->breakaway_factor = FAR_ABOVE;
        report->warnings |= WARN_TOO_LARGE;
    }
    else if (guard != 0u && is_settled)
    {
        report->warnings |= bit_if(V_0 >= CLEAR && V_2 > LONG_PRESLIDING * V_0, WARN_LONG) |
                            bit_if(V_0 >= CLEAR && V_2 < NO_PRESLIDING * V_0, WARN_SHORT);
    }
}

void NAME(axis, report)(const axis_t *axis, tribo_axis_report_t *report)
{
    *report = (tribo_axis_report_t){.breakaway_factor = 1.0f, .share = 1.0f};
    if (axis->active == NULL)
    {
        return;
    }
    const float                 B       = axis->active->feedforward.learning.breakaway_n;
    const tribo_guard_cause_t   cause   = axis->guard.cause;
    tribo_feedforward_learned_t learned = {.L_n = 0.0f};
    for (uint32_t direction = TRIBO_BREAKAWAY_POSITIVE; direction <= TRIBO_BREAKAWAY_NEGATIVE; direction++)
    {
        learned            = axis_learned(axis, direction);
        const float prior  = PRIOR_DEVIATION * root_f32(limit_f32(learned.relative_variance, 0.0f, 1.0f)) * B;
        const float spread = 2.0f * (prior + MODEL_DEVIATION * learned.L_n);

        report->breakaway_n[direction] = learned.L_n;
        report->low_n[direction]       = larger(learned.L_n - spread, 0.0f);
        report->high_n[direction]      = learned.L_n + spread;
    }
    report->travel_n      = learned.travel_n;
    report->times_less    = tribo_learner_times_less(&axis->feedforward.learner);
    report->share         = axis_share(axis);
    report->bad_inputs    = axis->bad_inputs;
    report->limited_ticks = axis->controller.limited_ticks;
    report->forgotten     = learned.forgotten;
    report->late          = learned.late;
    report->warnings =
        bit_if(report->bad_inputs > 0u, WARN_BAD_INPUT) | bit_if(report->limited_ticks > 0u, WARN_LIMITED) |
        bit_if(cause == TRIBO_GUARD_HUNTING, WARN_HUNTING) | bit_if(cause == TRIBO_GUARD_OVERSHOOT, WARN_OVERSHOOT) |
        bit_if(report->forgotten > 0u, WARN_FORGOTTEN) |
        bit_if(report->late > 0u && learned.travel_n == 0.0f, WARN_LATE) | bit_if(axis->is_miscalled != 0u, WARN_CALLS);
    report_far(axis, report);
}
