// Load-dependent friction of real servo actuators, model m3: a base and a fraction of the load on the gearbox.
//
//     limit = (base + load |t_motor - t_external|) in newtons of this arm
//     f = limit sgn(w) + cv w, set-valued at rest
//
// Here u is the motor's and -F the external load, so |t_motor - t_external| is |u + F|: at rest breakaway is
// (base + 2 load F) / (1 - load) upwards, (base + 2 load F) / (1 + load) downwards. The scenario's breakaway L is not used.
//
// Source: M. Duclusaud, G. Passault, V. Padois, O. Ly, "Extended friction models for the physics simulation of servo
// actuators", 2024, and the parameters published with it (Rhoban BAM, m3). Torques are scaled so that the base is this
// arm's 0.007 N; the load coefficient is dimensionless and stays. Breakaway at 0.5 N is then 0.129, 0.090, 0.147 and
// 0.182 N for the four; the arm's is 0.157.

#include "plant/truth/arm.h"

#include <math.h>

typedef struct
{
    double base;
    double load;
    double scale;
    double viscous;
} parameters_t;

typedef struct
{
    parameters_t p;
    int          way; ///< direction of sliding, 0 at rest
} servo_t;

static double limit(const servo_t *servo, const sim_contact_t *contact)
{
    return servo->p.base * servo->p.scale + servo->p.load * fabs(contact->u_n + contact->force_n);
}

static double update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    const servo_t *servo = law;
    (void)z_end;
    return copysign(limit(servo, &step->start), end_speed) + servo->p.viscous * end_speed;
}

static double friction(const void *law, const sim_contact_t *now, const double z[])
{
    const servo_t *servo = law;
    (void)z;
    return servo->way == 0 ? now->n_n : servo->way * limit(servo, now) + servo->p.viscous * now->speed_deg_per_s;
}

enum
{
    STOPS_OR_SLIDES_UP,
    SLIDES_DOWN,
    GUARDS
};

static void guards(const void *law, const sim_contact_t *now, const double z[], double g[])
{
    const servo_t *servo = law;
    (void)z;
    const bool moves      = servo->way != 0;
    g[STOPS_OR_SLIDES_UP] = moves ? servo->way * now->speed_deg_per_s : limit(servo, now) - now->n_n;
    g[SLIDES_DOWN]        = moves ? 1.0 : limit(servo, now) + now->n_n;
}

static void cross(void *law, sim_contact_t *now, double z[], unsigned guard)
{
    servo_t *servo = law;
    (void)z;
    if (servo->way == 0)
    {
        servo->way = guard == SLIDES_DOWN ? -1 : 1;
        return;
    }
    now->speed_deg_per_s = 0.0;
    servo->way           = fabs(now->n_n) <= limit(servo, now) ? 0 : now->n_n > 0.0 ? 1 : -1;
}

static const sim_law_t law = {.size        = sizeof(servo_t),
                              .own_size    = sizeof(parameters_t),
                              .guard_count = GUARDS,
                              .update      = update,
                              .friction    = friction,
                              .guards      = guards,
                              .cross       = cross};

// clang-format off: one row a key
/// Defines one actuator: its defaults and its row.
#define SERVO(id, title, base_n_m, load_part) \
    static const common_key_t keys_##id[] = { \
        SIM_TRUTH_NUMBER(parameters_t, base, "base_N_m", "N m", 0.0, 100.0, base_n_m, "friction without load, " title), \
        SIM_TRUTH_NUMBER(parameters_t, load, "load", "-", 0.0, 0.9, load_part, "part of the load on the gearbox"), \
        SIM_TRUTH_NUMBER(parameters_t, scale, "scale_N_per_N_m", "N/(N m)", 1e-6, 1e3, 0.007 / (base_n_m), "force at this arm divided by the actuator's torque"), \
        SIM_TRUTH_NUMBER(parameters_t, viscous, "viscous_N_s_per_deg", "N s/deg", 0.0, 10.0, 0.0, "damping added to the arm's own"), \
        SIM_TRUTH_END, \
    }; \
    SIM_ARM_TRUTH(servo_##id, law, keys_##id)
// clang-format on

SERVO(mx106, "MX-106", 0.1134, 0.108);
SERVO(mx64, "MX-64", 0.1022, 0.0758);
SERVO(xl330, "XL-330", 0.00888, 0.1217);
SERVO(erob80, "eRob80:100", 4.83, 0.148);
