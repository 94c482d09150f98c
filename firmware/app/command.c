#include "app/command.h"

#include <stddef.h>
#include <string.h>

static command_t command_of(const char *line)
{
    static const struct
    {
        const char *line;
        command_t   command;
    } commands[] = {{"start", COMMAND_START},
                    {"ack", COMMAND_ACKNOWLEDGE},
                    {"?", COMMAND_REPORT},
                    {"+", COMMAND_UP},
                    {"-", COMMAND_DOWN}};

    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
    {
        if (strcmp(line, commands[i].line) == 0)
        {
            return commands[i].command;
        }
    }
    return COMMAND_NONE;
}

command_t command_take(command_reader_t *reader, uint8_t byte)
{
    if (byte == 'x')
    {
        command_spoil(reader);
        return COMMAND_STOP;
    }
    if (byte == '\r' || byte == '\n')
    {
        const command_t command = reader->spoilt ? COMMAND_NONE : command_of(reader->line);
        *reader                 = (command_reader_t){0};
        return command;
    }
    if (byte == 0u || reader->length >= COMMAND_LENGTH_MAX)
    {
        command_spoil(reader);
        return COMMAND_NONE;
    }
    reader->line[reader->length++] = (char)byte;
    return COMMAND_NONE;
}

void command_pause(command_reader_t *reader, uint32_t silent_us)
{
    if (silent_us > COMMAND_SILENT_US)
    {
        *reader = (command_reader_t){0};
    }
}

void command_spoil(command_reader_t *reader)
{
    reader->spoilt = true;
}
