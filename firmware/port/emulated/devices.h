/// Optional devices of an emulated board, over semihosting: a bus and a flash. The emulator's command line selects them
/// (-semihosting-config ...,arg=bus,arg=flash) and passes them as open files, DEVICES_BUS and DEVICES_FLASH.

#ifndef EMULATED_DEVICES_H
#define EMULATED_DEVICES_H

#include "app/modbus.h"
#include "app/store.h"

#include <stdbool.h>

#define DEVICES_BUS          "/dev/fd/5" ///< a terminal that does not wait (raw, VMIN and VTIME 0)
#define DEVICES_FLASH        "/dev/fd/6" ///< a file with both sectors, one after the other
#define DEVICES_SECTOR_WORDS 1024u

void devices_open(void);

bool devices_have_bus(void);

/// Returns the bus; a silent line if there is none.
const modbus_line_t *devices_line(void);

/// Returns the flash; null if there is none.
const store_flash_t *devices_flash(void);

#endif
