// A position loop at 1 kHz, and the friction of its joint taken out. The three functions are yours: encoder, drive, loop.

#include <tribo.h>

static tribo_joint_f32_t joint;

float read_position_rad();
void command_n_m(float u); // e.g. by SimpleFOC's motor.move(u), or a current by CAN
float position_loop(float q_ref, float q);

void setup()
{
    tribo_joint_config_t config = tribo_joint_config(); // empty: refused until what follows is given
    config.sample_time_s        = 0.001f;
    config.effort_max           = 3.0f;    // N m
    config.travel               = 0.0015f; // rad, four counts of the encoder
    config.breakaway            = 0.3f;    // N m, a guess
    const tribo_status_t status = tribo_joint_f32_init(&joint, &config);
    if (status != TRIBO_OK)
    {
        Serial.begin(115200);
        Serial.println(tribo_status_text(status)); // the field and its range; u stays 0
    }
}

void loop()
{
    static uint32_t       due   = micros();
    static const uint32_t start = due;
    static const float    begin = read_position_rad();
    while (static_cast<int32_t>(micros() - due) < 0)
    {
    }
    due += 1000;
    const float q_ref = begin + 0.5f * sinf(1e-6f * (due - start)); // from where the joint is
    const float q     = read_position_rad();
    command_n_m(tribo_joint_f32_step(&joint, position_loop(q_ref, q), q_ref, q));
}
