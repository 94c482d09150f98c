// This port has no bus and no store, because the link uses the line and the host sends the params.

#include "port/emulated/devices.h"

#include <stddef.h>

void devices_open(void)
{
}

bool devices_have_bus(void)
{
    return false;
}

// NOLINTNEXTLINE(readability-non-const-parameter): the type is that of a modbus_line_t's member
static int receive_nothing(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    (void)bytes;
    (void)room;
    return 0;
}

const modbus_line_t *devices_line(void)
{
    static const modbus_line_t line = {.receive = receive_nothing};
    return &line;
}

const store_flash_t *devices_flash(void)
{
    return NULL;
}
