#include "background.h"

#include "params_name.h"

#include <signal.h>
#include <string.h>

#define WAIT_MS 10
#define TRIALS  1000

// NOLINTNEXTLINE(readability-non-const-parameter): a modbus_line_t's
static int receive_nothing(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    (void)bytes;
    (void)room;
    return 0;
}

const modbus_line_t background_line = {.receive = receive_nothing};

static unsigned read_registers(void *context, uint16_t address, uint16_t count, uint16_t *values)
{
    background_t            *background = context;
    const modbus_registers_t map        = registers_map(background->registers);
    for (int trial = 0; trial < TRIALS; trial++)
    {
        const unsigned        ticks  = gate_wait(background->gate);
        const modbus_status_t status = map.read(map.context, address, count, values);
        if (!gate_has_passed(background->gate, ticks))
        {
            return (unsigned)status;
        }
    }
    return MODBUS_BUSY;
}

static unsigned write_registers(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    static const uint16_t    stop       = REGISTERS_TRACE_STOP;
    background_t            *background = context;
    const modbus_registers_t map        = registers_map(background->registers);
    if (address == REGISTERS_COMMAND_AT && count == 1u && values[0] == REGISTERS_TRACE)
    {
        (void)map.write(map.context, address, 1, &stop);
        (void)gate_wait(background->gate);
    }
    return (unsigned)map.write(map.context, address, count, values);
}

static void count_event(modbus_t *counters, bus_event_t event)
{
    counters->frames += event == BUS_EXECUTED || event == BUS_REFUSED;
    counters->exceptions += event == BUS_REFUSED;
    counters->bad_frames += event == BUS_BAD_FRAME;
}

static void *work(void *context)
{
    background_t         *background = context;
    registers_t          *registers  = background->registers;
    const bus_registers_t map        = {.context = background, .read = read_registers, .write = write_registers};
    params_set_t          told       = registers->active->set;
    uint32_t              changes    = registers->protection_changes;
    while (!atomic_load(&background->stops))
    {
        count_event(&registers->modbus, bus_serve(background->bus, registers->modbus.unit, &map, WAIT_MS));
        registers_run(registers);
        drive_log(&registers->drive);
        params_name_changes(registers, &told, &changes);
    }
    return NULL;
}

bool background_start(background_t *background, registers_t *registers, gate_t *gate, bus_t *bus, common_error_t *error)
{
    sigset_t all;
    sigset_t before;
    *background = (background_t){.registers = registers, .gate = gate, .bus = bus};
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before); // signals are the loop's
    const int status = pthread_create(&background->thread, NULL, work, background);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return status == 0 || common_error_set(error, "no thread for the bus: %s", strerror(status));
}

void background_stop(background_t *background)
{
    atomic_store(&background->stops, true);
    (void)pthread_join(background->thread, NULL);
}
