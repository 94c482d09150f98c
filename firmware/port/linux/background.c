#include "background.h"

#include "params_name.h"
#include "realtime.h"
#include "signals.h"

#include <string.h>

#define WAIT_MS 10
#define TRIALS  1000
#define END_NS  INT64_C(2000000000) ///< a disk may take long to save params
#define LOOK_NS 1000000

// NOLINTNEXTLINE(readability-non-const-parameter): the type is that of a modbus_line_t's member
static int receive_nothing(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    (void)bytes;
    (void)room;
    return 0;
}

const modbus_line_t background_line = {.receive = receive_nothing};

static modbus_status_t read_registers(void *context, uint16_t address, uint16_t count, uint16_t *values)
{
    background_t            *background = context;
    const modbus_registers_t map        = registers_map(background->registers);
    for (int trial = 0; trial < TRIALS; trial++)
    {
        const unsigned        ticks  = gate_wait(background->gate);
        const modbus_status_t status = map.read(map.context, address, count, values);
        if (!gate_has_passed(background->gate, ticks))
        {
            return status;
        }
    }
    return MODBUS_BUSY;
}

static modbus_status_t write_registers(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    static const uint16_t    stop       = REGISTERS_TRACE_STOP;
    background_t            *background = context;
    const modbus_registers_t map        = registers_map(background->registers);
    const bool               arms = address == REGISTERS_COMMAND_AT && count == 1u && values[0] == REGISTERS_TRACE;
    if (arms && registers_can_trace(background->registers))
    {
        (void)map.write(map.context, address, 1, &stop);
        (void)gate_wait(background->gate);
    }
    return map.write(map.context, address, count, values);
}

static modbus_status_t stop_drive(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    const background_t      *background = context;
    const modbus_registers_t map        = registers_map(background->registers);
    return map.stop(map.context, address, count, values);
}

static void forget_client(void *context)
{
    const background_t *background = context;
    registers_forget_client(background->registers);
}

static void *work(void *context)
{
    background_t       *background = context;
    registers_t        *registers  = background->registers;
    const bus_service_t service    = {
           .modbus    = &registers->modbus,
           .registers = {.context = background, .read = read_registers, .write = write_registers, .stop = stop_drive},
           .leave     = forget_client};
    params_set_t told    = registers->active->set;
    uint32_t     changes = registers->protection_changes;
    while (!atomic_load(&background->stops))
    {
        bus_serve(background->bus, &service, WAIT_MS);
        if (registers_run(registers))
        {
            bus_was_away(background->bus);
        }
        drive_log(&registers->drive);
        params_name_changes(registers, &told, &changes);
    }
    atomic_store(&background->has_ended, true);
    return NULL;
}

bool background_start(background_t *background, registers_t *registers, gate_t *gate, bus_t *bus, common_error_t *error)
{
    sigset_t before;
    *background = (background_t){.registers = registers, .gate = gate, .bus = bus};
    signals_block(&before);
    const int status = pthread_create(&background->thread, NULL, work, background);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return status == 0 || common_error_set(error, "the bus's thread cannot be started: %s", strerror(status));
}

bool background_stop(background_t *background)
{
    const int64_t end_ns = realtime_now_ns() + END_NS;
    atomic_store(&background->stops, true);
    while (!atomic_load(&background->has_ended) && realtime_now_ns() < end_ns)
    {
        (void)realtime_sleep_until(realtime_now_ns() + LOOK_NS);
    }
    return atomic_load(&background->has_ended) && pthread_join(background->thread, NULL) == 0;
}
