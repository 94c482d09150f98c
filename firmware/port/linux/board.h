/// The board of tribo-drive: the devices and lines of a rig, or its simulation, behind the drive's port.

#ifndef LINUX_BOARD_H
#define LINUX_BOARD_H

#include "plant/plant.h"
#include "plant/sensor.h"
#include "port/port.h"
#include "rig.h"
#include "scenario/config.h"

typedef struct
{
    const rig_t *rig;
    lines_t     *lines;
    channel_t    sensor, dac;
    pwm_t        pwm;

    sim_plant_config_t plant_config;
    sim_plant_t       *plant; ///< null: devices
    sim_sensor_t       plant_sensor;
    unsigned           plant_steps; ///< a tick

    float    idle;   ///< the output at no current
    float    output; ///< the last one
    bool     failed; ///< a device or a line did not do as told
    uint32_t time_us;
    port_t   port;
} board_t;

/// Opens everything; outputs are at no current, the power stage off. Must not move afterwards. False with why in `error`.
bool board_open(board_t *board, const rig_t *rig, const sim_scenario_t *scenario, sim_error_t *error);
void board_close(board_t *board);

/// The plant up to the next tick, if it is simulated.
void board_advance(board_t *board);

/// Command 0, then the power stage off. For any process that has the board open.
void board_off(void *context);

#endif
