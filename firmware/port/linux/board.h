/// The board of tribo-drive: the devices and lines of a rig, or its simulation, behind the drive's port.

#ifndef LINUX_BOARD_H
#define LINUX_BOARD_H

#include "app/drive.h"
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

    const drive_t  *drive;  ///< null: its config is still the rig's
    volatile float *idle;   ///< the output at no current, shared with the supervisor
    float           output; ///< the last one
    bool            failed; ///< a device or a line did not do as told

    // The drive's clock. With no `slack_ns` it is the machine's; else the schedule's, as long as the loop is no more than that
    // behind it.
    int64_t  slack_ns, due_ns;
    uint32_t due_us;
    port_t   port;
} board_t;

/// Opens everything; outputs are at no current, the power stage off. Must not move afterwards. False with why in `error`.
bool board_open(board_t *board, const rig_t *rig, const sim_scenario_t *scenario, sim_error_t *error);
void board_close(board_t *board);

/// From here on the config is that of `drive`, which a bus may change.
void board_attach(board_t *board, const drive_t *drive);

/// The config that the next tick begins with.
const drive_config_t *board_config(const board_t *board);

/// Before each tick, which is due at `due_ns` of realtime_now_ns, and `number` periods after the first.
void board_begin(board_t *board, uint64_t number, int64_t due_ns);

/// After each tick: the plant up to the next one, if it is simulated.
void board_advance(board_t *board);

/// Command 0, then the power stage off. For any process that has the board open.
void board_off(void *context);

#endif
