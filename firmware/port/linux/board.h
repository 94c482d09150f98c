/// The board of tribo-drive and tribo-desk: the devices and lines of a rig, or a desk's plant, behind the drive's port.

#ifndef LINUX_BOARD_H
#define LINUX_BOARD_H

#include "app/drive.h"
#include "desk.h"
#include "port/port.h"
#include "rig.h"

typedef struct
{
    const rig_t *rig;
    lines_t     *lines;
    channel_t    sensor, dac;
    pwm_t        pwm;

    counter_t       position;
    channel_t       measured[RIG_MEASURED];
    unsigned        measured_at; ///< index of the quantity read last
    port_measured_t latest;

    const desk_t *desk; ///< null: devices
    void         *plant;

    const drive_t  *drive;  ///< null: the config is still that of the rig
    volatile float *idle;   ///< the output at no current, shared with the supervisor
    float           output; ///< the last command
    bool            failed; ///< a device or a line has refused an access

    // State of the power stage.
    bool     is_on, is_off_long;    ///< enable is on; enable has been off for ready_off_ms
    bool     reads_enable;          ///< whether the chip can read its outputs
    uint32_t off_us;                ///< when it was turned off
    const char *volatile complaint; ///< fault found in the last tick; null: none
    const char *logged;             ///< the last complaint that was logged

    bool     pulse; ///< level of the heartbeat's line
    uint64_t pulse_ticks;

    // The drive's clock. If `slack_ns` is 0 it is the machine's clock, otherwise that of the schedule while the loop is no
    // more than `slack_ns` behind it.
    int64_t  slack_ns, due_ns;
    uint32_t due_us;
    port_t   port;
} board_t;

/// Opens everything, with outputs at no current and the power stage off. The board must not move afterwards. Returns false
/// with the cause in `error`.
bool board_open(board_t                 *board,
                const rig_t             *rig,
                const desk_t            *desk,
                const common_scenario_t *scenario,
                common_error_t          *error);
void board_close(board_t *board);

/// Uses the config of `drive` from now on, which a bus may change. Returns false, with the cause in `error`, if the power
/// stage reports ready although it is off.
bool board_attach(board_t *board, const drive_t *drive, common_error_t *error);

/// Returns the config with which the next tick begins.
const drive_config_t *board_config(const board_t *board);

/// Call before each tick. The tick is due at `due_ns` of realtime_now_ns, `number` periods after the first.
void board_begin(board_t *board, uint64_t number, int64_t due_ns);

/// Call after each tick of an attached drive: toggles the heartbeat line unless something has failed.
void board_pulse(board_t *board);

/// Call after each tick: advances the desk's plant to the next one, if there is a plant.
void board_advance(board_t *board);

/// Turns the power stage off, then commands 0. For any process that has the board open.
void board_off(void *context);

#endif
