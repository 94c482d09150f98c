// The rig of the closed loop in the test machine: reads the duty that the drive has set, moves the simulated plant by a tick,
// and sets the converter's code, in lock-step with tribo-drive --ticks.
//
//     linux_vm_plant SCENARIO.yaml DUTY_FILE I2C_BUS TICKS IN OUT
//
// Prints the RMS of r - F in N over the scenario's metrics window. Duty 0.5 is no force, 0 and 1 are -2 N and 2 N; the converter
// (an ADS1115, 0.0625 mV a code) reads 1 N as 1024 mV.

#include "loop/reference.h"
#include "scenario/plant_config.h"

#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define CONVERTER   0x48
#define CONVERSION  0 ///< its register of the result
#define CODES_PER_N (1024.0 / 0.0625)
#define FULL_DUTY_N 4.0
#define PERIOD_NS   50000.0

static int fail(const char *what)
{
    perror(what);
    return 1;
}

static double read_duty(int file)
{
    char          text[32];
    const ssize_t length          = pread(file, text, sizeof text - 1, 0);
    text[length > 0 ? length : 0] = '\0';
    return strtod(text, NULL) / PERIOD_NS;
}

/// The chip sends the high byte first, SMBus the low one.
static int set_code(int bus, double force_n)
{
    const double                code = fmin(fmax(round(force_n * CODES_PER_N), -32768.0), 32767.0);
    const unsigned              bits = (unsigned)(int)code & 0xffffu;
    union i2c_smbus_data        data = {.word = (__u16)(bits >> 8 | bits << 8)};
    struct i2c_smbus_ioctl_data call = {.read_write = I2C_SMBUS_WRITE,
                                        .command    = CONVERSION,
                                        .size       = I2C_SMBUS_WORD_DATA,
                                        .data       = &data};
    return ioctl(bus, I2C_SMBUS, &call);
}

int main(int count, char **arguments)
{
    static common_error_t error;
    common_scenario_t    *scenario = sim_scenario_create();
    common_reference_t    reference;
    if (count != 7 || scenario == NULL || !common_scenario_load(scenario, arguments[1], &error) ||
        !sim_scenario_check(scenario, &error) || !common_reference_init(&reference, scenario, &error))
    {
        (void)fprintf(stderr, "linux_vm_plant: %s\n", error.text);
        return 1;
    }
    const sim_config_t      *config = sim_scenario_config(scenario);
    const unsigned           steps  = sim_plant_steps(config);
    const sim_plant_config_t of     = sim_plant_config_of(config);
    sim_plant_t             *plant  = sim_plant_create(&of, sim_truth_models[config->plant.model]);
    const long               ticks  = strtol(arguments[4], NULL, 10);
    const int                duty   = open(arguments[2], O_RDONLY);
    const int                bus    = open(arguments[3], O_RDWR);
    // The drive opens its ends in this order. One that does not come ends this program.
    (void)alarm(60);
    const int out = open(arguments[5], O_WRONLY);
    const int in  = open(arguments[6], O_RDONLY);
    if (plant == NULL || duty < 0 || bus < 0 || out < 0 || in < 0 || ioctl(bus, I2C_SLAVE_FORCE, CONVERTER) != 0)
    {
        return fail("linux_vm_plant");
    }
    double squares = 0.0;
    long   counted = 0;
    for (long tick = 0; tick < ticks; tick++)
    {
        const double t_s     = (double)tick * config->loop.sample_time_s;
        const double error_n = common_reference_at(&reference, t_s) - sim_plant_force(plant);
        char         byte    = '.';
        if (set_code(bus, sim_plant_filtered_force(plant)) != 0 || write(out, &byte, 1) != 1 || read(in, &byte, 1) != 1)
        {
            return fail("linux_vm_plant: lock-step");
        }
        const double        u_n = (read_duty(duty) - 0.5) * FULL_DUTY_N;
        sim_plant_signals_t unused;
        for (unsigned step = 0; step < steps; step++)
        {
            sim_plant_step(plant, u_n, &unused);
        }
        if (t_s >= config->metrics.start_s)
        {
            squares += error_n * error_n;
            counted++;
        }
    }
    (void)printf("rms %.6f\n", sqrt(squares / (double)counted));
    return 0;
}
