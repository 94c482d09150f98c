#include "app/modbus.h"

#include "app/crc16.h"

#include <string.h>

#define FRAME_MIN           4u // unit, function, CRC
#define WRITE_MAX_WITH_READ 121u

enum
{
    READ_REGISTERS       = 3,
    WRITE_REGISTER       = 6,
    WRITE_REGISTERS      = 16,
    READ_WRITE_REGISTERS = 23
};

// --- the line ------------------------------------------------------------------------------------------------------

/// A frame ends after 3.5 characters of 11 bits, or 1.75 ms above 19200 baud, rounded up to whole ticks, because the last
/// byte may have arrived at the end of its tick.
void modbus_init(modbus_t *modbus, uint8_t unit, uint32_t baud, uint32_t period_us)
{
    const uint32_t silence_us = baud > 19200u ? 1750u : 38500000u / baud;
    const uint32_t tick_us    = period_us > 0u
                                    ? period_us
                                    : 1u; // a config with a period of 0 is refused, but the refusal is read over this bus
    *modbus = (modbus_t){.unit = unit, .silent_ticks = silence_us / tick_us + (silence_us % tick_us > 0u)};
}

#define TICK_BYTES 64u // most bytes that a tick takes; the next one takes the rest

void modbus_take(modbus_t *modbus, const modbus_line_t *line)
{
    uint8_t   bytes[TICK_BYTES];
    const int count = line->receive(line->context, bytes, sizeof bytes);
    if (count == 0)
    {
        modbus->silence += modbus->silence != UINT32_MAX;
        if (modbus->silence == modbus->silent_ticks)
        {
            if (modbus->spoilt && !modbus->complete)
            {
                modbus->length = 0;
            }
            modbus->complete = modbus->complete || modbus->length > 0u;
            modbus->spoilt   = false;
        }
        return;
    }
    modbus->silence = 0;
    if (count < 0 || modbus->complete || (size_t)count > sizeof modbus->frame - modbus->length)
    {
        modbus->spoilt = true;
    }
    if (modbus->spoilt)
    {
        modbus->lost = true;
        return;
    }
    memcpy(modbus->frame + modbus->length, bytes, (size_t)count);
    modbus->length = (uint16_t)(modbus->length + (unsigned)count);
}

static bool is_frame(const uint8_t *frame, size_t length)
{
    return length >= FRAME_MIN && length <= MODBUS_FRAME_MAX && crc16(frame, length) == 0u;
}

/// Handles bytes between two silences that are not a frame.
static void pass_on_stray(modbus_t *modbus, const modbus_line_t *line, modbus_source_t source)
{
    if (source == MODBUS_LATE)
    {
        modbus->lost = true;
    }
    else if (line->stray != NULL)
    {
        line->stray(line->context, modbus->frame, modbus->length);
    }
}

void modbus_serve(modbus_t                 *modbus,
                  const modbus_line_t      *line,
                  const modbus_registers_t *registers,
                  modbus_source_t           source)
{
    if (modbus->complete)
    {
        const uint32_t bad_frames = modbus->bad_frames;
        modbus->answer_length =
            (uint16_t)modbus_execute(modbus, registers, source, modbus->frame, modbus->length, modbus->answer);
        if (modbus->bad_frames != bad_frames)
        {
            pass_on_stray(modbus, line, source);
        }
        modbus->answer_sent = 0;
        modbus->length      = 0;
        modbus->complete    = false; // last: from here on the tick writes the frame
    }
    if (modbus->answer_sent < modbus->answer_length)
    {
        const size_t left   = (size_t)modbus->answer_length - modbus->answer_sent;
        const size_t sent   = line->send(line->context, modbus->answer + modbus->answer_sent, left);
        modbus->answer_sent = (uint16_t)(modbus->answer_sent + sent);
    }
}

// --- a frame -------------------------------------------------------------------------------------------------------

static uint16_t get(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] << 8 | bytes[1]);
}

static void put(uint8_t *bytes, uint16_t value)
{
    bytes[0] = (uint8_t)(value >> 8);
    bytes[1] = (uint8_t)value;
}

/// A decoded request. A count of 0 means no read or no write.
typedef struct
{
    uint16_t       read_address, read_count;
    uint16_t       write_address, write_count;
    const uint8_t *values; ///< the values to write
} request_t;

static bool fits(uint16_t address, uint16_t count)
{
    return (uint32_t)address + count <= 0x10000u;
}

/// Decodes `data`, the `size` bytes between function and CRC.
static modbus_status_t parse(request_t *request, uint8_t function, const uint8_t *data, size_t size)
{
    size_t   head      = 0; // bytes before the values
    uint16_t read_max  = 0;
    uint16_t write_max = 0;
    *request           = (request_t){0};
    switch (function)
    {
    case READ_REGISTERS:
        head     = 4;
        read_max = MODBUS_READ_MAX;
        break;
    case WRITE_REGISTER:
        head      = 2;
        write_max = 1;
        break;
    case WRITE_REGISTERS:
        head      = 5;
        write_max = MODBUS_WRITE_MAX;
        break;
    case READ_WRITE_REGISTERS:
        head      = 9;
        read_max  = MODBUS_READ_MAX;
        write_max = WRITE_MAX_WITH_READ;
        break;
    default:
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if (size < head)
    {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (read_max > 0u)
    {
        request->read_address = get(data);
        request->read_count   = get(data + 2);
    }
    if (write_max > 0u)
    {
        const uint8_t *part    = data + (read_max > 0u ? 4 : 0);
        request->write_address = get(part);
        request->write_count   = function == WRITE_REGISTER ? 1u : get(part + 2);
        request->values        = data + head;
    }
    const bool has_byte_count = function == WRITE_REGISTERS || function == READ_WRITE_REGISTERS;
    const bool good           = (read_max == 0u || (request->read_count >= 1u && request->read_count <= read_max)) &&
                      (write_max == 0u || (request->write_count >= 1u && request->write_count <= write_max)) &&
                      size == head + 2u * request->write_count &&
                      (!has_byte_count || data[head - 1u] == 2u * request->write_count);
    if (!good)
    {
        return MODBUS_ILLEGAL_VALUE;
    }
    return fits(request->read_address, request->read_count) && fits(request->write_address, request->write_count)
               ? MODBUS_OK
               : MODBUS_ILLEGAL_ADDRESS;
}

static modbus_status_t write_values(const modbus_registers_t *registers,
                                    modbus_source_t           source,
                                    const request_t          *request)
{
    uint16_t values[MODBUS_WRITE_MAX];
    for (size_t i = 0; i < request->write_count; i++)
    {
        values[i] = get(request->values + 2u * i);
    }
    return (source == MODBUS_MASTER
                ? registers->write
                : registers->stop)(registers->context, request->write_address, request->write_count, values);
}

static modbus_status_t read_values(const modbus_registers_t *registers,
                                   modbus_source_t           source,
                                   const request_t          *request,
                                   uint16_t                 *values)
{
    return source == MODBUS_GUEST
               ? MODBUS_BUSY
               : registers->read(registers->context, request->read_address, request->read_count, values);
}

/// Executes a request. Function 23 writes before it reads. A trial read before the write prevents it if the registers to read do
/// not exist; whether their values can be read may depend on the write.
static modbus_status_t perform(const modbus_registers_t *registers,
                               modbus_source_t           source,
                               const request_t          *request,
                               uint16_t                 *values)
{
    modbus_status_t status = MODBUS_OK;
    if (request->read_count > 0u)
    {
        status = read_values(registers, source, request, values);
    }
    if (status != MODBUS_ILLEGAL_ADDRESS && request->write_count > 0u)
    {
        status = write_values(registers, source, request);
        if (status == MODBUS_OK && request->read_count > 0u)
        {
            status = read_values(registers, source, request, values);
        }
    }
    return status;
}

/// Returns the size of the answer without its frame.
static size_t write_answer(uint8_t *answer, const uint8_t *pdu, const request_t *request, const uint16_t *values)
{
    answer[0] = pdu[0];
    if (request->read_count == 0u)
    {
        memcpy(answer + 1, pdu + 1, 4); // address, and value or count
        return 5;
    }
    answer[1] = (uint8_t)(2u * request->read_count);
    for (size_t i = 0; i < request->read_count; i++)
    {
        put(answer + 2u + 2u * i, values[i]);
    }
    return 2u + 2u * (size_t)request->read_count;
}

size_t modbus_answer(modbus_t                 *modbus,
                     const modbus_registers_t *registers,
                     modbus_source_t           source,
                     const uint8_t            *request,
                     size_t                    size,
                     uint8_t                   answer[MODBUS_PDU_MAX])
{
    request_t       parsed;
    uint16_t        values[MODBUS_READ_MAX];
    modbus_status_t status = parse(&parsed, request[0], request + 1, size - 1u);
    if (status == MODBUS_OK)
    {
        status = perform(registers, source, &parsed, values);
    }
    modbus->frames++;
    modbus->heard += source != MODBUS_GUEST;
    if (status == MODBUS_OK)
    {
        return write_answer(answer, request, &parsed, values);
    }
    modbus->exceptions++;
    answer[0] = (uint8_t)(request[0] | 0x80u);
    answer[1] = (uint8_t)status;
    return 2;
}

size_t modbus_execute(modbus_t                 *modbus,
                      const modbus_registers_t *registers,
                      modbus_source_t           source,
                      const uint8_t            *frame,
                      size_t                    length,
                      uint8_t                   answer[MODBUS_FRAME_MAX])
{
    if (!is_frame(frame, length))
    {
        modbus->bad_frames++;
        return 0;
    }
    const bool all = frame[0] == MODBUS_BROADCAST;
    if (frame[0] != modbus->unit && !(all && (frame[1] == WRITE_REGISTER || frame[1] == WRITE_REGISTERS)))
    {
        return 0;
    }

    const uint32_t exceptions = modbus->exceptions;
    const size_t   pdu        = length - FRAME_MIN + 1u;
    size_t size = modbus_answer(modbus, registers, all ? MODBUS_GUEST : source, frame + 1, pdu, answer + 1) + 1u;
    if (all)
    {
        modbus->exceptions = exceptions; // a broadcast has no answer, hence no exception
        return 0;
    }
    answer[0]          = frame[0];
    const uint16_t crc = crc16(answer, size);
    answer[size]       = (uint8_t)crc;
    answer[size + 1u]  = (uint8_t)(crc >> 8);
    return size + 2u;
}
