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

    channel_t       measured[RIG_MEASURED];
    unsigned        measured_at; ///< of them, the one read last
    port_measured_t latest;

    const desk_t *desk; ///< null: devices
    void         *plant;

    const drive_t  *drive;  ///< null: its config is still the rig's
    volatile float *idle;   ///< the output at no current, shared with the supervisor
    float           output; ///< the last one
    bool            failed; ///< a device or a line did not do as told

    // The power stage.
    bool     is_on, is_off_long;    ///< enable; and for ready_off_ms
    bool     reads_enable;          ///< the chip can
    uint32_t off_us;                ///< when it was turned off
    const char *volatile complaint; ///< of the last tick; null: none
    const char *told;               ///< the last one that was logged

    bool     pulse; ///< level of the heartbeat's line
    uint64_t pulse_ticks;

    // The drive's clock. With no `slack_ns` it is the machine's; else the schedule's, as long as the loop is no more than that
    // behind it.
    int64_t  slack_ns, due_ns;
    uint32_t due_us;
    port_t   port;
} board_t;

/// Opens everything; outputs are at no current, the power stage off. Must not move afterwards. False with why in `error`.
bool board_open(board_t                 *board,
                const rig_t             *rig,
                const desk_t            *desk,
                const common_scenario_t *scenario,
                common_error_t          *error);
void board_close(board_t *board);

/// From here on the config is that of `drive`, which a bus may change. False, with why in `error`, if the power stage is ready
/// though it is off.
bool board_attach(board_t *board, const drive_t *drive, common_error_t *error);

/// The config that the next tick begins with.
const drive_config_t *board_config(const board_t *board);

/// Before each tick, which is due at `due_ns` of realtime_now_ns, and `number` periods after the first.
void board_begin(board_t *board, uint64_t number, int64_t due_ns);

/// After each tick of a drive that is attached: the next edge of the heartbeat's line, as long as all is well.
void board_pulse(board_t *board);

/// After each tick: the desk's plant up to the next one, if there is one.
void board_advance(board_t *board);

/// The power stage off, then command 0. For any process that has the board open.
void board_off(void *context);

#endif
