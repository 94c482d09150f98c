// A force axis at 1 kHz for a board without an FPU: 2^31 is 80 N. The two functions are yours: sensor, drive.

#include <tribo.h>

static tribo_axis_q31_t axis;

int32_t read_force_q31(); // e.g. counts of a converter with 80 N at its end, shifted to 32 bits
void command_q31(int32_t u);

void setup()
{
    tribo_axis_f32_config_t config             = tribo_axis_f32_config(); // in N; empty: refused until what follows is given
    config.sample_time_s                       = 0.001f;
    config.u_min_n                             = -20.0f;
    config.u_max_n                             = 20.0f;
    config.positive                            = {0.07f, 0.3f}; // breakaway: N, and N per N of load; within a factor of 3
    config.feedforward.actuator_pole_rad_per_s = 200.0f;
    config.feedforward.sensor_pole_rad_per_s   = 55.0f;
    config.controller                          = tribo_pi(1.0f, 56.0f); // tuned without friction
    const tribo_status_t status                = tribo_axis_q31_init(&axis, &config, 80.0f);
    if (status != TRIBO_OK)
    {
        Serial.begin(115200);
        Serial.println(tribo_status_text(status)); // the field and its range; u stays 0
    }
}

void loop()
{
    static uint32_t due = micros();
    while (static_cast<int32_t>(micros() - due) < 0)
    {
        tribo_axis_q31_learn(&axis); // a tick does not
    }
    due += 1000;
    command_q31(tribo_axis_q31_step(&axis, 1 << 27, read_force_q31())); // 5 N
}
