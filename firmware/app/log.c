#include "app/log.h"

void log_text(const port_t *port, const char *text)
{
    for (; *text != '\0'; text++)
    {
        port->log_byte(port->context, (uint8_t)*text);
    }
}

void log_number(const port_t *port, uint32_t number)
{
    char  digits[11] = "";
    char *digit      = digits + sizeof digits - 1;
    do
    {
        *--digit = (char)('0' + number % 10u);
        number /= 10u;
    } while (number > 0u);
    log_text(port, digit);
}
