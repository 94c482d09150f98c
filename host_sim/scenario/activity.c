#include "scenario/activity.h"

#include <math.h>

void sim_activity_add(sim_activity_t *activity, double r_n, double u_n, bool q)
{
    if (activity->continues)
    {
        const double move   = u_n - activity->u_n;
        const bool   turned = (move > activity->move_n && activity->last_move_n < -activity->move_n) ||
                            (move < -activity->move_n && activity->last_move_n > activity->move_n);
        activity->u_variation_n += fabs(move);
        activity->r_variation_n += fabs(r_n - activity->r_n);
        activity->chatter_ticks += turned && activity->turned;
        activity->q_switches += q != activity->q;
        activity->last_move_n = move;
        activity->turned      = turned;
    }
    activity->r_n = r_n;
    activity->u_n = u_n;
    activity->q   = q;
    activity->ticks++;
    activity->continues = true;
}

void sim_activity_break(sim_activity_t *activity)
{
    activity->continues   = false;
    activity->turned      = false;
    activity->last_move_n = 0.0;
}

double sim_activity_variation_ratio(const sim_activity_t *activity)
{
    return activity->r_variation_n > 0.0 ? activity->u_variation_n / activity->r_variation_n : (double)NAN;
}
