// tribo-drive runs the drive on the devices and lines of a Linux board.

#include "program.h"

int main(int count, char **arguments)
{
    return program_run(count, arguments, NULL);
}
