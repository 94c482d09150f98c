// The drive behind its bus: any bytes, cut into ticks anywhere. Nothing but a frame with the right CRC changes what the drive
// runs with, what is staged, or what is asked of it.

#include "fuzz.h"

#include "app/registers.h"

#include <string.h>

static const uint8_t *input;
static size_t         left;
static uint32_t       now_us;

unsigned fuzz_good;

static bool read_sensor(void *context, loop_force_t *reading)
{
    (void)context;
    *reading = 0;
    return true;
}

static void command(void *context, loop_force_t output)
{
    (void)context;
    (void)output;
}

static void enable(void *context, bool on)
{
    (void)context;
    (void)on;
}

static uint32_t inputs(void *context)
{
    (void)context;
    return 0;
}

static uint32_t time_us(void *context)
{
    (void)context;
    return now_us;
}

/// The first byte says how many follow in this tick: none lets a frame end.
static int receive(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    if (left == 0u)
    {
        return 0;
    }
    size_t count = *input % 17u;
    input++;
    left--;
    count = count < left ? count : left;
    count = count < room ? count : room;
    memcpy(bytes, input, count);
    input += count;
    left -= count;
    return (int)count;
}

static size_t send(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    (void)bytes;
    return count;
}

static registers_t         registers;
static const modbus_line_t line = {.receive = receive, .send = send};

static unsigned requests(void)
{
    const drive_t *drive = &registers.drive;
    return (unsigned)drive->starts + drive->stops + drive->acknowledgements + drive->tares + drive->references;
}

/// Padding and all: a tick that writes nothing does not write that either.
static bool is_same(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint32_t         ring[64];
    static params_set_t     defaults;
    static const port_t     port = {.sensor      = {.full_units = 4.0f},
                                    .output      = {.full_units = 4.0f},
                                    .read_sensor = read_sensor,
                                    .command     = command,
                                    .enable      = enable,
                                    .inputs      = inputs,
                                    .time_us     = time_us};
    const registers_board_t parts =
        {.port = &port, .line = &line, .defaults = &defaults, .baud = 115200, .ring = ring, .ring_words = 64};
    defaults = params_default();
    input    = data;
    left     = size;
    registers_load(&registers, &parts);
    registers_start(&registers, DRIVE_FAULT_NONE);
    while (left > 0u || registers.modbus.silence < 3u)
    {
        const uint32_t             frames = registers.modbus.frames;
        const unsigned             asked  = requests();
        const params_set_t         staged = registers.staged;
        const registers_requests_t shown  = registers.requests;
        const params_t            *active = registers.active;
        now_us += 1000u;
        registers_tick(&registers);
        registers_run(&registers);
        if (registers.modbus.frames == frames)
        {
            ALWAYS(requests() == asked && registers.active == active);
            ALWAYS(is_same(&staged, &registers.staged, sizeof staged));
            ALWAYS(is_same(&shown, &registers.requests, sizeof shown));
        }
        fuzz_good += registers.modbus.frames - frames;
    }
    return 0;
}
