#include "bus.h"

#include "address.h"
#include "status.h"
#include "support/clock.h"

#include "tribo/status.h"

#include <errno.h>
#include <fcntl.h>
#include <modbus.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#define NETWORK "tcp:"
#define PORT    "1502" // of a drive on Linux, if its configuration has no other

#define RESPONSE_S  2    // a later answer is flushed within as long again; one after that would be taken for the next
#define COMMAND_S   20   // the drive answers a command once it is done: a set takes a slow or emulated one seconds
#define OUTCOME_S   20.0 // a flash may take seconds
#define TRIALS      3    // a frame may be lost on a line, or cut by the log of a drive that has just started
#define FRAME_WORDS 60   // of 32 bits
#define PAUSE_MS    100

#define FRAME_BYTES  256
#define BYTE_BITS    10
#define LOCK_WAIT_S  3.0
#define LOCK_LOOK_MS 2
#define ANSWER_US    200000 ///< of a drive that is looked for

struct link_bus
{
    int lock; ///< of the line's file, held from command to command; negative: a network, whose connection is the lock
    modbus_t   *modbus;
    const char *device;
    int         unit;
    double      frames_s; ///< that a request and its answer take on the line
    bool        feeds_forward;
};

bool link_complain(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    (void)fputs("tribo-link: ", stderr);
    (void)vfprintf(stderr, format, args);
    (void)fputc('\n', stderr);
    va_end(args);
    return false;
}

float link_float(uint32_t word)
{
    float number;
    memcpy(&number, &word, sizeof number);
    return number;
}

uint32_t link_word(float number)
{
    uint32_t word;
    memcpy(&word, &number, sizeof word);
    return word;
}

static void pause_ms(long ms)
{
    (void)nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000}, NULL);
}

// --- the time of an exchange ---------------------------------------------------------------------------------------
//
// libmodbus waits for the first byte of an answer and again for each that follows, and reads unwanted data to its end: a device
// that sends a byte now and then, or endlessly, would block it for ever. A timer then replaces its descriptor.

static int                   nowhere = -1; ///< /dev/null
static volatile sig_atomic_t guarded = -1; ///< the descriptor of the exchange
static volatile sig_atomic_t is_cut;

static void cut(int signal_number)
{
    const int error = errno;
    (void)signal_number;
    is_cut = 1;
    (void)dup2(nowhere, guarded);
    errno = error;
}

static bool prepare_timer(void)
{
    const struct sigaction action = {.sa_handler = cut};
    nowhere                       = nowhere < 0 ? open("/dev/null", O_RDWR | O_CLOEXEC) : nowhere;
    return (nowhere >= 0 && sigaction(SIGALRM, &action, NULL) == 0) || link_complain("/dev/null: %s", strerror(errno));
}

static void set_timer(double s)
{
    const struct itimerval time = {
        .it_value = {.tv_sec = (time_t)s, .tv_usec = (suseconds_t)(1e6 * (s - (double)(time_t)s))}};
    (void)setitimer(ITIMER_REAL, &time, NULL);
}

/// Limits the following exchange on the line to `s` from now on. end_exchange ends it.
static void begin_exchange(modbus_t *modbus, double s)
{
    is_cut  = 0;
    guarded = modbus_get_socket(modbus);
    set_timer(s);
}

/// Returns the result of the exchange; errno is ETIMEDOUT if its time ran out.
static int end_exchange(int got)
{
    const int error = errno;
    set_timer(0.0);
    guarded = -1;
    errno   = is_cut != 0 ? ETIMEDOUT : error;
    return is_cut != 0 ? -1 : got;
}

/// Includes the wait that follows a bad answer.
static void begin_frame(const link_bus_t *bus)
{
    begin_exchange(bus->modbus, 2.0 * RESPONSE_S + bus->frames_s);
}

static bool fail(const link_bus_t *bus, const char *what)
{
    if (errno == ETIMEDOUT)
    {
        return link_complain("%s: no answer from unit %d while %s", bus->device, bus->unit, what);
    }
    return link_complain("%s: unit %d, %s: %s", bus->device, bus->unit, what, modbus_strerror(errno));
}

static bool is_exception(int error)
{
    return error > MODBUS_ENOBASE && error < EMBBADCRC;
}

/// The trials of reads, and of writes that may arrive twice. A network loses nothing.
static bool is_lost(const link_bus_t *bus, int trial)
{
    return bus->lock >= 0 && is_cut == 0 && !is_exception(errno) && trial + 1 < TRIALS;
}

static void to_words(uint32_t *words, const uint16_t *values, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
    {
        words[i] = (uint32_t)values[2u * i] << 16 | values[2u * i + 1u];
    }
}

static void to_values(uint16_t *values, const uint32_t *words, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
    {
        values[2u * i]      = (uint16_t)(words[i] >> 16);
        values[2u * i + 1u] = (uint16_t)words[i];
    }
}

bool link_bus_read(link_bus_t *bus, uint16_t address, uint32_t *words, unsigned count)
{
    for (unsigned done = 0; done < count;)
    {
        uint16_t       values[2 * FRAME_WORDS] = {0};
        const unsigned part                    = count - done < FRAME_WORDS ? count - done : FRAME_WORDS;
        int            got                     = -1;
        for (int trial = 0; got < 0 && trial < TRIALS; trial++)
        {
            begin_frame(bus);
            got = end_exchange(modbus_read_registers(bus->modbus, address + 2 * (int)done, 2 * (int)part, values));
            if (got < 0 && !is_lost(bus, trial))
            {
                return fail(bus, "reading");
            }
        }
        to_words(words + done, values, part);
        done += part;
    }
    return true;
}

bool link_bus_write(link_bus_t *bus, uint16_t address, const uint32_t *words, unsigned count)
{
    for (unsigned done = 0; done < count;)
    {
        uint16_t       values[2 * FRAME_WORDS];
        const unsigned part = count - done < FRAME_WORDS ? count - done : FRAME_WORDS;
        int            got  = -1;
        to_values(values, words + done, part);
        for (int trial = 0; got < 0 && trial < TRIALS; trial++)
        {
            begin_frame(bus);
            got = end_exchange(modbus_write_registers(bus->modbus, address + 2 * (int)done, 2 * (int)part, values));
            if (got < 0 && !is_lost(bus, trial))
            {
                return fail(bus, "writing");
            }
        }
        done += part;
    }
    return true;
}

bool link_bus_window(link_bus_t *bus, uint32_t position, uint32_t *words, unsigned count)
{
    uint16_t          at[2];
    uint16_t          values[2 * LINK_WINDOW];
    const link_row_t *row = link_find("trace.position");
    to_values(at, &position, 1);
    for (int trial = 0;; trial++)
    {
        begin_frame(bus);
        const int got = end_exchange(
            modbus_write_and_read_registers(bus->modbus, row->address, 2, at, link_window_at, 2 * (int)count, values));
        if (got >= 0)
        {
            to_words(words, values, count);
            return true;
        }
        if (!is_lost(bus, trial))
        {
            return fail(bus, "reading the trace");
        }
    }
}

bool link_bus_state(link_bus_t *bus, const char *name, uint32_t *word)
{
    return link_bus_read(bus, link_find(name)->address, word, 1);
}

// --- commands ------------------------------------------------------------------------------------------------------

/// What the drive refused, and why.
typedef struct
{
    uint16_t          address;
    const link_row_t *row; ///< null if this program does not know the register
    const char       *name;
    uint32_t          status; ///< tribo_status_t
    double            value, low, high;
} refusal_t;

static bool read_refusal(link_bus_t *bus, refusal_t *refusal)
{
    uint32_t said[5];
    if (!link_bus_read(bus, link_find("refused_register")->address, said, 5))
    {
        return false;
    }
    const link_row_t *row = link_at((uint16_t)said[0]);
    *refusal              = (refusal_t){.address = (uint16_t)said[0],
                                        .row     = row,
                                        .name    = row != NULL ? row->name : "a param",
                                        .status  = said[1],
                                        .value   = (double)link_float(said[2]),
                                        .low     = (double)link_float(said[3]),
                                        .high    = (double)link_float(said[4])};
    return true;
}

/// Names the refused param, with the drive's own range.
static bool complain_of_set(link_bus_t *bus)
{
    refusal_t refusal;
    if (!read_refusal(bus, &refusal))
    {
        return false;
    }
    const link_row_t *row     = refusal.row;
    const char       *more    = refusal.status != TRIBO_OK ? tribo_status_text((tribo_status_t)refusal.status) : "";
    const bool        is_tick = row != NULL && refusal.low == refusal.high &&
                         (strcmp(row->name, "sample_time_s") == 0 || strcmp(row->name, "drive.period_us") == 0);
    if (is_tick)
    {
        more = "no set can change the ticks of a drive; its image or configuration does";
    }
    const char *comma    = more[0] != '\0' ? "; " : "";
    const bool  can_be_0 = row != NULL && row->can_be_0 && refusal.value != 0.0; // a ceiling may forbid that
    return link_complain("%s = %.7g is refused, the drive goes on as it was: %.7g to %.7g%s%s%s",
                         refusal.name,
                         refusal.value,
                         refusal.low,
                         refusal.high,
                         can_be_0 ? " or 0" : "",
                         comma,
                         more);
}

/// Reports the change that the refused set would have made.
static bool complain_of_protection(link_bus_t *bus, bool runs)
{
    refusal_t refusal;
    return read_refusal(bus, &refusal) &&
           link_complain("%s = %.7g is refused, the drive goes on as it was: it protects, and is %.7g%s",
                         refusal.name,
                         refusal.value,
                         refusal.low,
                         runs ? "; stop the drive first" : "; the drive is locked");
}

/// Names --after if the drive's ring is too short for it.
static bool complain_of_trace(link_bus_t *bus, const char *what)
{
    refusal_t refusal;
    if (!read_refusal(bus, &refusal))
    {
        return false;
    }
    return refusal.address == link_find("trace.after")->address
               ? link_complain("%s: --after %.7g: 0 to %.7g is expected, because the drive holds no more samples of so "
                               "many signals",
                               what,
                               refusal.value,
                               refusal.high)
               : link_complain("%s: refused: %s", what, link_outcome_text((uint32_t)LINK_TRACE_REFUSED));
}

/// Prints each protection register whose staged value differs from the drive's.
static bool say_changes(link_bus_t *bus)
{
    size_t            count;
    const link_row_t *list = link_list(&count);
    for (size_t i = 0; i < count; i++)
    {
        uint32_t staged = 0;
        uint32_t active = 0;
        if (list[i].group != LINK_PARAM || !list[i].protects)
        {
            continue;
        }
        if (!link_bus_read(bus, list[i].address, &staged, 1) ||
            !link_bus_read(bus, (uint16_t)(list[i].address + link_active_offset), &active, 1))
        {
            return false;
        }
        if (staged != active)
        {
            (void)fprintf(stderr,
                          "%s protects: from %.9g to %.9g\n",
                          list[i].name,
                          list[i].is_float ? (double)link_float(active) : (double)active,
                          list[i].is_float ? (double)link_float(staged) : (double)staged);
        }
    }
    return true;
}

static bool wait_for_outcome(link_bus_t *bus, uint32_t *outcome)
{
    const double end_s = common_clock_s() + OUTCOME_S;
    for (;;)
    {
        uint16_t   values[2] = {0, 0};
        const bool is_late   = common_clock_s() >= end_s;
        begin_frame(bus);
        const int got = end_exchange(modbus_read_registers(bus->modbus, link_find("outcome")->address, 2, values));
        if (got < 0 && (is_cut != 0 || is_exception(errno) || (bus->lock < 0 && errno != ETIMEDOUT)))
        {
            return fail(bus, "waiting");
        }
        to_words(outcome, values, 1);
        if (got >= 0 && *outcome != (uint32_t)LINK_BUSY)
        {
            return true;
        }
        if (is_late)
        {
            return got < 0 ? fail(bus, "waiting for the end of a command")
                           : link_complain("%s: unit %d has been busy with the command for more than %g s",
                                           bus->device,
                                           bus->unit,
                                           OUTCOME_S);
        }
        pause_ms(PAUSE_MS);
    }
}

/// Sends a command and returns its outcome.
static bool execute(link_bus_t *bus, unsigned command, const char *what, uint32_t *outcome)
{
    int got = -1;
    (void)modbus_set_response_timeout(bus->modbus, COMMAND_S, 0);
    for (int trial = 0; got < 0; trial++)
    {
        begin_exchange(bus->modbus, COMMAND_S + RESPONSE_S + bus->frames_s);
        got = end_exchange(modbus_write_register(bus->modbus, link_command_at, (uint16_t)command));
        if (got < 0 && errno == EMBXSBUSY && trial + 1 < TRIALS)
        {
            pause_ms(PAUSE_MS);
        }
        else if (got < 0 && errno != EMBXSFAIL)
        {
            return fail(bus, what);
        }
        else
        {
            break;
        }
    }
    (void)modbus_set_response_timeout(bus->modbus, RESPONSE_S, 0);
    return wait_for_outcome(bus, outcome);
}

static bool complain_of_state(link_bus_t *bus, unsigned command, const char *what)
{
    char     reason[STATUS_REASON_MAX];
    uint32_t state = 0;
    uint32_t fault = 0;
    if (!link_bus_state(bus, "state", &state) || !link_bus_state(bus, "fault", &fault))
    {
        return false;
    }
    status_refusal(command, state, fault, reason);
    return link_complain("%s: refused: %s", what, reason);
}

/// A drive without a store has none that has failed.
static bool complain_of_store(link_bus_t *bus, const char *what)
{
    uint32_t store = 0;
    return link_bus_state(bus, "store", &store) &&
           link_complain("%s: refused: %s",
                         what,
                         store == link_store_failed ? link_outcome_text((uint32_t)LINK_NOT_SAVED)
                                                    : "the drive has no store: add store: FILE to its "
                                                      "configuration, and start the program again");
}

static bool judge(link_bus_t *bus, unsigned command, uint32_t outcome, const char *what)
{
    if (outcome == (uint32_t)LINK_WRONG_STATE)
    {
        return complain_of_state(bus, command, what);
    }
    if (outcome == (uint32_t)LINK_NOT_SAVED)
    {
        return complain_of_store(bus, what);
    }
    if (outcome == (uint32_t)LINK_SET_REFUSED)
    {
        return complain_of_set(bus);
    }
    if (outcome == (uint32_t)LINK_TRACE_REFUSED)
    {
        return complain_of_trace(bus, what);
    }
    if (outcome == (uint32_t)LINK_PROTECTED || outcome == (uint32_t)LINK_LOCKED)
    {
        return complain_of_protection(bus, outcome == (uint32_t)LINK_PROTECTED);
    }
    return outcome == (uint32_t)LINK_DONE || link_complain("%s: refused: %s", what, link_outcome_text(outcome));
}

bool link_bus_command(link_bus_t *bus, unsigned command, const char *what)
{
    uint32_t outcome = (uint32_t)LINK_DONE;
    return execute(bus, command, what, &outcome) && judge(bus, command, outcome, what);
}

bool link_bus_apply(link_bus_t *bus, const char *what)
{
    const uint16_t lock    = link_find("unlock")->address;
    const uint32_t none    = 0;
    uint32_t       outcome = (uint32_t)LINK_DONE;
    if (!execute(bus, link_apply, what, &outcome))
    {
        return false;
    }
    if (outcome != (uint32_t)LINK_LOCKED)
    {
        return judge(bus, link_apply, outcome, what);
    }
    return say_changes(bus) && link_bus_write(bus, lock, &link_key, 1) && execute(bus, link_apply, what, &outcome) &&
           link_bus_write(bus, lock, &none, 1) && judge(bus, link_apply, outcome, what);
}

// --- the line ------------------------------------------------------------------------------------------------------

static bool check_lists(link_bus_t *bus)
{
    uint32_t version = 0;
    uint32_t layout  = 0;
    if (!link_bus_state(bus, "version", &version) || !link_bus_state(bus, "layout", &layout))
    {
        return false;
    }
    bus->feeds_forward = layout == link_layout(true);
    if (version != link_version || (!bus->feeds_forward && layout != link_layout(false)))
    {
        return link_complain(
            "%s: unit %d has registers of version %u with params 0x%08x, this program knows version %u "
            "with 0x%08x: take the tribo-link that was built with its firmware",
            bus->device,
            bus->unit,
            version,
            layout,
            link_version,
            link_layout(true));
    }
    return true;
}

/// The process that has a lock on the file; 0: none that can be seen.
static long find_holder(int file)
{
    struct stat is;
    char        line[256];
    char        where[64];
    long        holder = 0;
    FILE       *locks  = fstat(file, &is) == 0 ? fopen("/proc/locks", "re") : NULL;
    if (locks == NULL)
    {
        return 0;
    }
    (void)
        snprintf(where, sizeof where, " %02x:%02x:%lu ", major(is.st_dev), minor(is.st_dev), (unsigned long)is.st_ino);
    while (holder == 0 && fgets(line, sizeof line, locks) != NULL)
    {
        // 1: FLOCK  ADVISORY  WRITE 1234 00:18:5 0 EOF
        const char *mode = strstr(line, where) != NULL && strstr(line, "->") == NULL ? strstr(line, "WRITE") : NULL;
        holder           = mode != NULL ? strtol(mode + strlen("WRITE"), NULL, 10) : 0;
    }
    (void)fclose(locks);
    return holder;
}

static bool is_network(const char *device)
{
    return strncmp(device, NETWORK, strlen(NETWORK)) == 0;
}

static bool complain_of_holder(const link_bus_t *bus)
{
    char       path[64];
    char       name[32] = "?";
    const long holder   = find_holder(bus->lock);
    (void)snprintf(path, sizeof path, "/proc/%ld/comm", holder);
    FILE *comm = holder > 0 ? fopen(path, "re") : NULL;
    if (comm != NULL)
    {
        (void)!fgets(name, sizeof name, comm);
        name[strcspn(name, "\n")] = '\0';
        (void)fclose(comm);
    }
    return holder > 0 ? link_complain("%s: in use by %s, process %ld", bus->device, name, holder)
                      : link_complain("%s: in use by another program", bus->device);
}

/// Locks the line, because two programs on it would read each other's answers.
static bool lock_line(const link_bus_t *bus)
{
    const double end_s = common_clock_s() + LOCK_WAIT_S;
    while (flock(bus->lock, LOCK_EX | LOCK_NB) != 0)
    {
        if (errno != EWOULDBLOCK)
        {
            return link_complain("%s: cannot be locked: %s", bus->device, strerror(errno));
        }
        if (common_clock_s() >= end_s)
        {
            return complain_of_holder(bus);
        }
        pause_ms(LOCK_LOOK_MS);
    }
    return true;
}

/// Waits for a turn, because a drive serves one client at a time. On a loaded machine the drive itself may not run for
/// RESPONSE_S, so it is asked again.
static bool connect_network(const link_bus_t *bus)
{
    const double end_s = common_clock_s() + LOCK_WAIT_S;
    for (;;)
    {
        uint16_t values[2];
        if (modbus_connect(bus->modbus) != 0)
        {
            return link_complain("%s: %s", bus->device, modbus_strerror(errno));
        }
        (void)modbus_set_error_recovery(bus->modbus, MODBUS_ERROR_RECOVERY_NONE);
        begin_exchange(bus->modbus, RESPONSE_S);
        const int got = end_exchange(modbus_read_registers(bus->modbus, link_find("version")->address, 2, values));
        (void)modbus_set_error_recovery(bus->modbus, MODBUS_ERROR_RECOVERY_PROTOCOL);
        const bool is_busy = got < 0 && errno == EMBXSBUSY;
        if (got >= 0 || (is_exception(errno) && !is_busy))
        {
            return true;
        }
        const bool is_foreign = errno > MODBUS_ENOBASE && !is_busy;
        if (is_foreign || common_clock_s() >= end_s)
        {
            return link_complain("%s: no answer from unit %d, or it serves another program%s",
                                 bus->device,
                                 bus->unit,
                                 is_foreign ? "; the answer is not Modbus" : "");
        }
        modbus_close(bus->modbus);
        pause_ms(LOCK_LOOK_MS);
    }
}

/// libmodbus compares the unit of an answer only on a serial line, and only half of the protocol number.
static bool check_unit(link_bus_t *bus)
{
    enum
    {
        PROTOCOL_AT = 2, // of an answer on a network
        UNIT_AT     = 6
    };
    const uint16_t at                                = link_find("version")->address;
    const uint8_t  request[]                         = {(uint8_t)bus->unit, 3, (uint8_t)(at >> 8), (uint8_t)at, 0, 2};
    uint8_t        answer[MODBUS_TCP_MAX_ADU_LENGTH] = {0};
    begin_frame(bus);
    (void)modbus_send_raw_request(bus->modbus, request, sizeof request);
    if (end_exchange(modbus_receive_confirmation(bus->modbus, answer)) < 0)
    {
        return fail(bus, "reading");
    }
    if (answer[PROTOCOL_AT] != 0u || answer[PROTOCOL_AT + 1] != 0u)
    {
        return link_complain("%s: no answer from unit %d; the answer is not Modbus", bus->device, bus->unit);
    }
    return answer[UNIT_AT] == bus->unit ||
           link_complain("%s: no answer from unit %d: unit %d answers", bus->device, bus->unit, answer[UNIT_AT]);
}

void link_bus_release(link_bus_t *bus)
{
    if (bus->lock < 0)
    {
        modbus_close(bus->modbus);
        return;
    }
    (void)flock(bus->lock, LOCK_UN);
}

bool link_bus_take(link_bus_t *bus)
{
    return bus->lock < 0 ? connect_network(bus) : lock_line(bus);
}

bool link_bus_rest(link_bus_t *bus, int ms)
{
    link_bus_release(bus);
    pause_ms(ms);
    return link_bus_take(bus);
}

/// Makes a context that is not connected; null after a complaint.
static modbus_t *make_modbus(const char *device, int unit, int baud)
{
    modbus_t      *modbus = NULL;
    link_address_t address;
    if (is_network(device))
    {
        const struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
        struct addrinfo      *found  = link_address_find(device, device + strlen(NETWORK), PORT, 1, &wanted, &address);
        if (found == NULL)
        {
            return NULL;
        }
        freeaddrinfo(found);
        modbus = modbus_new_tcp_pi(address.host, address.port);
    }
    else
    {
        modbus = modbus_new_rtu(device, baud, 'N', 8, 1);
    }
    if (modbus == NULL || modbus_set_slave(modbus, unit) != 0)
    {
        (void)link_complain("%s: %s", device, modbus_strerror(errno));
        modbus_free(modbus);
        modbus = NULL;
    }
    return modbus;
}

static bool open_line(link_bus_t *bus)
{
    struct stat is;
    bus->lock = open(bus->device, O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (bus->lock < 0)
    {
        return link_complain("%s: %s%s",
                             bus->device,
                             strerror(errno),
                             errno == ENOENT ? "; a line is a file in /dev, a network tcp:HOST[:PORT]" : "");
    }
    if (isatty(bus->lock) == 0)
    {
        const bool is_folder = fstat(bus->lock, &is) == 0 && S_ISDIR(is.st_mode);
        return link_complain("%s: is %s, not a serial line", bus->device, is_folder ? "a folder" : "another file");
    }
    return lock_line(bus);
}

static bool open_bus(link_bus_t *bus, int baud)
{
    const bool is_line = !is_network(bus->device);
    bus->frames_s      = is_line ? 2.0 * FRAME_BYTES * BYTE_BITS / baud : 0.0;
    if (!prepare_timer() || (is_line && !open_line(bus)))
    {
        return false;
    }
    bus->modbus = make_modbus(bus->device, bus->unit, baud);
    if (bus->modbus == NULL)
    {
        return false;
    }
    if (is_line && modbus_connect(bus->modbus) != 0)
    {
        return link_complain("%s: %s", bus->device, modbus_strerror(errno));
    }
    (void)modbus_set_response_timeout(bus->modbus, RESPONSE_S, 0);
    (void)modbus_set_error_recovery(bus->modbus, MODBUS_ERROR_RECOVERY_PROTOCOL);
    return (is_line || (connect_network(bus) && check_unit(bus))) && check_lists(bus);
}

link_bus_t *link_bus_open(const char *device, int unit, int baud)
{
    link_bus_t *bus = calloc(1, sizeof *bus);
    if (bus == NULL)
    {
        (void)link_complain("out of memory");
        return NULL;
    }
    *bus = (link_bus_t){.device = device, .unit = unit, .lock = -1};
    if (!open_bus(bus, baud))
    {
        link_bus_close(bus);
        return NULL;
    }
    return bus;
}

bool link_bus_answers(const char *device, int unit, int baud)
{
    uint16_t  values[2];
    const int lock   = is_network(device) ? -1 : open(device, O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    modbus_t *modbus = make_modbus(device, unit, baud);
    bool      ok =
        modbus != NULL && prepare_timer() && (is_network(device) || (lock >= 0 && flock(lock, LOCK_EX | LOCK_NB) == 0));
    if (ok)
    {
        (void)modbus_set_response_timeout(modbus, 0, ANSWER_US);
        ok = modbus_connect(modbus) == 0;
        begin_exchange(modbus, 2e-6 * ANSWER_US);
        ok = end_exchange(ok ? modbus_read_registers(modbus, link_find("version")->address, 2, values) : -1) == 2 ||
             errno == EMBXSBUSY;
        modbus_close(modbus);
    }
    modbus_free(modbus);
    if (lock >= 0)
    {
        (void)close(lock);
    }
    return ok;
}

int link_bus_stop_beside(const char *device, int unit)
{
    uint16_t values[2];
    if (!is_network(device))
    {
        return 0;
    }
    modbus_t *modbus = prepare_timer() ? make_modbus(device, unit, 0) : NULL;
    if (modbus == NULL)
    {
        return -1;
    }
    bool ok = modbus_connect(modbus) == 0;
    if (ok)
    {
        begin_exchange(modbus, RESPONSE_S);
        ok = modbus_write_register(modbus, link_command_at, (uint16_t)link_stop) == 1 &&
             modbus_read_registers(modbus, link_find("version")->address, 2, values) < 0 && errno == EMBXSBUSY;
        (void)end_exchange(0);
        modbus_close(modbus);
    }
    modbus_free(modbus);
    return ok;
}

const char *link_bus_name(const link_bus_t *bus)
{
    return bus->device;
}

bool link_bus_feeds_forward(const link_bus_t *bus)
{
    return bus->feeds_forward;
}

void link_bus_close(link_bus_t *bus)
{
    if (bus != NULL && bus->modbus != NULL)
    {
        modbus_close(bus->modbus);
        modbus_free(bus->modbus);
    }
    if (bus != NULL && bus->lock >= 0)
    {
        (void)close(bus->lock);
    }
    free(bus);
}
