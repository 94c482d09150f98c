// A force axis at 1 kHz, with its friction taken out. The two functions are yours: sensor, drive.

#include <tribo.h>

static tribo_axis_f32_t axis;

float read_force_n();
void command_n(float u); // end-point force, e.g. as a current

void setup()
{
    tribo_axis_f32_config_t config             = tribo_axis_f32_config(); // empty: refused until what follows is given
    config.sample_time_s                       = 0.001f;
    config.u_min_n                             = -20.0f;
    config.u_max_n                             = 20.0f;
    config.positive                            = {0.07f, 0.3f}; // breakaway: N, and N per N of load; within a factor of 3
    config.feedforward.actuator_pole_rad_per_s = 200.0f;
    config.feedforward.sensor_pole_rad_per_s   = 55.0f;
    config.controller                          = tribo_pi(1.0f, 56.0f); // tuned without friction
    const tribo_status_t status                = tribo_axis_f32_init(&axis, &config);
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
    }
    due += 1000;
    const float r = 5.0f + 2.0f * sinf(1e-6f * due);
    command_n(tribo_axis_f32_step(&axis, r, read_force_n()));
}
