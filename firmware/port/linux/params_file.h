/// A file that replaces the two flash sectors of the drive's store (app/store.h). The kernel may write a file's blocks in
/// any order, so everything before a mark is flushed to the disk first. Whenever the power fails, the file holds either the
/// old params or the new ones.

#ifndef LINUX_PARAMS_FILE_H
#define LINUX_PARAMS_FILE_H

#include "app/store.h"
#include "support/error.h"

#define PARAMS_FILE_SECTOR_WORDS 2048u

typedef struct
{
    int           file; ///< -1: none
    store_flash_t flash;
} params_file_t;

/// Opens `path` exclusively and creates an empty file if there is none. Returns false with the cause in `error`, also for a
/// file that is not a store. `store` must not move afterwards.
bool params_file_open(params_file_t *store, const char *path, common_error_t *error);
void params_file_close(params_file_t *store);

#endif
