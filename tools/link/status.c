#include "status.h"

#include "address.h"
#include "app/registers.h"
#include "support/clock.h"

#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define WORDS (REGISTERS_COMMAND_AT / 2u)

const char *status_state_text(uint32_t state)
{
    static const char *const texts[] =
        {[DRIVE_IDLE] = "idle", [DRIVE_RUN] = "run", [DRIVE_FAULT] = "fault", [DRIVE_STARTING] = "starting"};
    return state < sizeof texts / sizeof texts[0] ? texts[state] : "unknown";
}

void status_refusal(unsigned command, uint32_t state, uint32_t fault, char reason[STATUS_REASON_MAX])
{
    const bool  runs = state == DRIVE_RUN || state == DRIVE_STARTING;
    const char *way  = "; the state may have changed meanwhile: look at tribo-link status";
    if (command == REGISTERS_ACKNOWLEDGE && (runs || state == DRIVE_IDLE))
    {
        way = ", not in fault: nothing is to be acknowledged";
    }
    else if (runs)
    {
        way = command == REGISTERS_START ? " already" : ": tribo-link stop ends that, then try again";
    }
    else if (state == DRIVE_FAULT)
    {
        way = ": remove the cause, then tribo-link fault --acknowledge";
    }
    (void)snprintf(reason,
                   STATUS_REASON_MAX,
                   "the drive is in %s%s%s%s%s",
                   status_state_text(state),
                   state == DRIVE_FAULT ? " (" : "",
                   state == DRIVE_FAULT ? drive_fault_text((drive_fault_t)fault) : "",
                   state == DRIVE_FAULT ? ")" : "",
                   way);
}

/// Returns the text of the lowest warning bit, which is enough to make a person look.
static const char *warning_text(uint32_t warnings)
{
    return warnings != 0u ? drive_warning_text((drive_warning_t)(warnings & (~warnings + 1u))) : "none";
}

/// Returns the text of a register's value, or an empty text if the number needs none.
static const char *text_of(const link_row_t *row, uint32_t word)
{
    const char *text = "";
    text             = strcmp(row->name, "warnings") == 0 ? warning_text(word) : text;
    text             = strcmp(row->name, "state") == 0 ? status_state_text(word) : text;
    text             = strcmp(row->name, "fault") == 0 ? drive_fault_text((drive_fault_t)word) : text;
    text             = strcmp(row->name, "store") == 0 ? store_status_text((store_status_t)word) : text;
    text             = strcmp(row->name, "outcome") == 0 ? link_outcome_text(word) : text;
    return text;
}

static double number_of(const link_row_t *row, uint32_t word)
{
    return row->is_float ? (double)link_float(word) : (double)word;
}

static bool read_words(link_bus_t *bus, uint32_t words[WORDS])
{
    memset(words, 0, WORDS * sizeof words[0]);
    return link_bus_read(bus, REGISTERS_STATE_AT, words + REGISTERS_STATE_AT / 2u, REGISTERS_STATE_COUNT) &&
           link_bus_read(bus, REGISTERS_SIGNALS_AT, words + REGISTERS_SIGNALS_AT / 2u, REGISTERS_SIGNAL_COUNT) &&
           (!link_bus_feeds_forward(bus) || link_bus_read(bus,
                                                          REGISTERS_COMPENSATION_AT,
                                                          words + REGISTERS_COMPENSATION_AT / 2u,
                                                          REGISTERS_COMPENSATION_COUNT));
}

static void write_json_number(FILE *file, const link_row_t *row, uint32_t word)
{
    const double number = number_of(row, word);
    if (isfinite(number))
    {
        (void)fprintf(file, "\"%s\":%.*g", row->name, row->is_float ? 9 : 10, number);
    }
    else
    {
        (void)fprintf(file, "\"%s\":null", row->name);
    }
}

static void write_json_row(FILE *file, const link_row_t *row, uint32_t word)
{
    const char *text = text_of(row, word);
    write_json_number(file, row, word);
    if (text[0] != '\0')
    {
        (void)fprintf(file, ",\"%s_text\":\"%s\"", row->name, text);
    }
}

static void print_row(const link_row_t *row, uint32_t word)
{
    const char *text = text_of(row, word);
    (void)printf("%s: %.*g%s%s%s%s\n",
                 row->name,
                 row->is_float ? 9 : 10,
                 number_of(row, word),
                 row->unit[0] != '\0' ? " " : "",
                 row->unit,
                 text[0] != '\0' ? "  # " : "",
                 text);
}

bool status_show(link_bus_t *bus, bool json)
{
    uint32_t          words[WORDS];
    size_t            count;
    const link_row_t *list = link_list(&count);
    if (!read_words(bus, words))
    {
        return false;
    }
    const char *separator = "{";
    for (size_t i = 0; i < count; i++)
    {
        const bool is_there = link_bus_feeds_forward(bus) || !link_is_of_feedforward(&list[i]);
        if (!is_there || (list[i].group != LINK_STATE && list[i].group != LINK_SIGNAL))
        {
            continue;
        }
        if (json)
        {
            (void)fputs(separator, stdout);
            write_json_row(stdout, &list[i], words[list[i].address / 2u]);
            separator = ",";
        }
        else
        {
            print_row(&list[i], words[list[i].address / 2u]);
        }
    }
    (void)fputs(json ? "}\n" : "", stdout);
    return true;
}

static uint32_t word_of(const uint32_t words[WORDS], const char *name)
{
    return words[link_find(name)->address / 2u];
}

static double value_of(const uint32_t words[WORDS], const char *name)
{
    return number_of(link_find(name), word_of(words, name));
}

/// Reads a word of the active set of params; 0 if it cannot be read.
static uint32_t active_word(link_bus_t *bus, const char *name)
{
    uint32_t       word    = 0;
    const uint32_t address = link_find(name)->address + (REGISTERS_ACTIVE_AT - REGISTERS_STAGED_AT);
    return link_bus_read(bus, (uint16_t)address, &word, 1) ? word : 0u;
}

/// What the active method does. A method that is off learns nothing, although the registers keep the last learned values.
typedef struct
{
    bool learns, compensates;
} method_t;

static method_t method_of(link_bus_t *bus)
{
    if (!link_bus_feeds_forward(bus))
    {
        return (method_t){.compensates = link_float(active_word(bus, "compensator.gain")) > 0.0f};
    }
    const uint32_t method = active_word(bus, "compensator.method");
    const bool     learns = method == PARAMS_METHOD_FEEDFORWARD || method == PARAMS_METHOD_SENSORLESS;
    const bool     is_on  = method == PARAMS_METHOD_PAPER && link_float(active_word(bus, "compensator.gain")) > 0.0f;
    return (method_t){.learns = learns, .compensates = learns || is_on};
}

/// Prints what the method has learned, and the share of the compensation that is added to u.
static void print_method(link_bus_t *bus, const uint32_t words[WORDS], const char *end)
{
    const method_t method = method_of(bus);
    if (method.learns)
    {
        (void)printf("learned  L %8.4f N up (variance %.2f)   %8.4f N down (%.2f)%s",
                     value_of(words, "learned_positive_N"),
                     value_of(words, "learned_positive_relative_variance"),
                     value_of(words, "learned_negative_N"),
                     value_of(words, "learned_negative_relative_variance"),
                     end);
    }
    (void)printf("warnings %s; ", warning_text(word_of(words, "warnings")));
    if (!method.compensates)
    {
        (void)printf("friction is not compensated%s", end);
    }
    else
    {
        (void)printf("compensation is in by %.0f %%%s", 100.0 * value_of(words, "friction_fade"), end);
    }
}

static void print_short(link_bus_t *bus, const uint32_t words[WORDS], const char *end)
{
    const uint32_t fault = word_of(words, "fault");
    (void)printf("drive    %s, %s, tick %u%s",
                 link_bus_name(bus),
                 word_of(words, "q31") != 0u ? "Q31" : "float32",
                 word_of(words, "tick"),
                 end);
    (void)printf("state    %s%s%s%s",
                 status_state_text(word_of(words, "state")),
                 fault != 0u ? ": " : "",
                 fault != 0u ? drive_fault_text((drive_fault_t)fault) : "",
                 end);
    (void)printf("force    r %8.4f N   F %8.4f N   r - F %8.2f mN%s",
                 value_of(words, "r_N"),
                 value_of(words, "F_N"),
                 1e3 * (value_of(words, "r_N") - value_of(words, "F_N")),
                 end);
    (void)printf("command  u %8.4f N   of it compensation %8.4f N   at a limit in %u ticks%s",
                 value_of(words, "u_N"),
                 value_of(words, "friction_term_N"),
                 word_of(words, "limited_ticks"),
                 end);
    if (link_bus_feeds_forward(bus))
    {
        print_method(bus, words, end);
    }
    if (word_of(words, "max_tick_us") > 0u) // a simulated drive does not measure itself
    {
        (void)printf("time     a tick took %.0f us at most, its start was %.0f us late at most%s",
                     value_of(words, "max_tick_us"),
                     value_of(words, "max_late_us"),
                     end);
    }
}

bool status_show_short(link_bus_t *bus)
{
    uint32_t words[WORDS];
    if (!read_words(bus, words))
    {
        return false;
    }
    print_short(bus, words, "\n");
    return true;
}

// --- live ----------------------------------------------------------------------------------------------------------

/// The signals of a sample that are sent.
static const char *const sent[] = {"tick",
                                   "state",
                                   "fault",
                                   "limits",
                                   "max_tick_us",
                                   "max_late_us",
                                   "r_N",
                                   "F_N",
                                   "u_N",
                                   "e_N",
                                   "controller_N",
                                   "friction_term_N",
                                   "F_hat_N",
                                   "n_N",
                                   "L_N",
                                   "f_hat_N",
                                   "warnings",
                                   "friction_fade",
                                   "learned_positive_N",
                                   "learned_positive_relative_variance",
                                   "learned_negative_N",
                                   "learned_negative_relative_variance"};

/// Returns the Unix time, which listeners expect.
static double wall_clock_s(void)
{
    struct timespec time;
    (void)clock_gettime(CLOCK_REALTIME, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/// Writes a sample in one of the two formats.
static size_t write_sample(char text[STATUS_SAMPLE_MAX], link_bus_t *bus, const uint32_t words[WORDS], bool teleplot)
{
    const double   time_s = wall_clock_s();
    const method_t method = method_of(bus);
    FILE          *file   = fmemopen(text, STATUS_SAMPLE_MAX, "w");
    if (file == NULL)
    {
        return 0;
    }
    if (!teleplot)
    {
        (void)fprintf(file, "{\"timestamp\":%.6f", time_s);
    }
    for (size_t i = 0; i < sizeof sent / sizeof sent[0]; i++)
    {
        const link_row_t *row = link_find(sent[i]);
        if ((!link_bus_feeds_forward(bus) && link_is_of_feedforward(row)) ||
            (!method.learns && strncmp(row->name, "learned", strlen("learned")) == 0) ||
            (!method.compensates && strcmp(row->name, "friction_fade") == 0))
        {
            continue;
        }
        const uint32_t word = words[row->address / 2u];
        if (teleplot)
        {
            (void)fprintf(file, "%s:%.3f:%.9g\n", row->name, 1e3 * time_s, number_of(row, word));
        }
        else
        {
            (void)fputc(',', file);
            write_json_row(file, row, word);
        }
    }
    (void)fputs(teleplot ? "" : "}\n", file);
    const long length = ftell(file);
    return fclose(file) == 0 && length > 0 ? (size_t)length : 0u;
}

size_t status_sample(link_bus_t *bus, char text[STATUS_SAMPLE_MAX])
{
    uint32_t words[WORDS];
    return read_words(bus, words) ? write_sample(text, bus, words, false) : 0u;
}

/// Returns a connected socket, or a negative number after printing an error. `option` is the option that named the address.
static int open_udp(const char *option, const char *text)
{
    char                  name[512];
    link_address_t        address;
    const struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_DGRAM};
    (void)snprintf(name, sizeof name, "watch: %s %s", option, text);
    struct addrinfo *found = link_address_find(name, text, NULL, 1, &wanted, &address);
    if (found == NULL)
    {
        return -1;
    }
    int socket_of = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
    if (socket_of < 0 || connect(socket_of, found->ai_addr, found->ai_addrlen) != 0)
    {
        (void)link_complain("%s: %s", name, strerror(errno));
        (void)(socket_of >= 0 ? close(socket_of) : 0);
        socket_of = -1;
    }
    freeaddrinfo(found);
    return socket_of;
}

/// Sends a sample. It is no error if nobody listens, because a listener may start later.
static void send_sample(int socket_of, link_bus_t *bus, const uint32_t words[WORDS], bool teleplot)
{
    if (socket_of >= 0)
    {
        char         text[STATUS_SAMPLE_MAX];
        const size_t length = write_sample(text, bus, words, teleplot);
        (void)!send(socket_of, text, length, 0);
    }
}

#define PLOT_COLUMNS 64

/// The latest values of a signal, newest last.
typedef struct
{
    const char *title, *unit;
    double      factor;
    double      value[PLOT_COLUMNS];
} trail_t;

static void draw_trail(const trail_t *trail, int count)
{
    static const char *const blocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    double                   low      = HUGE_VAL;
    double                   high     = -HUGE_VAL;
    for (int i = PLOT_COLUMNS - count; i < PLOT_COLUMNS; i++)
    {
        low  = fmin(low, trail->value[i]);
        high = fmax(high, trail->value[i]);
    }
    (void)printf("%-6s ", trail->title);
    for (int i = 0; i < PLOT_COLUMNS; i++)
    {
        const double part = high > low ? (trail->value[i] - low) / (high - low) : 0.0;
        (void)fputs(i < PLOT_COLUMNS - count || !isfinite(part) ? " " : blocks[(int)(7.0 * part + 0.5)], stdout);
    }
    (void)printf("  %.4g to %.4g %s\033[K\n", trail->factor * low, trail->factor * high, trail->unit);
}

static void draw_view(link_bus_t *bus, const uint32_t words[WORDS], trail_t trails[3], int *count)
{
    const double values[3] = {value_of(words, "F_N"),
                              value_of(words, "r_N") - value_of(words, "F_N"),
                              value_of(words, "u_N")};
    *count                 = *count < PLOT_COLUMNS ? *count + 1 : PLOT_COLUMNS;
    (void)fputs("\033[H", stdout);
    print_short(bus, words, "\033[K\n");
    (void)fputs("\033[K\n", stdout);
    for (int i = 0; i < 3; i++)
    {
        memmove(trails[i].value, trails[i].value + 1, sizeof trails[i].value - sizeof trails[i].value[0]);
        trails[i].value[PLOT_COLUMNS - 1] = values[i];
        draw_trail(&trails[i], *count);
    }
    (void)fputs("\033[K\nCtrl-C ends this view, not the drive.\033[J", stdout);
    (void)fflush(stdout);
}

static volatile sig_atomic_t is_over;

static void end(int signal_number)
{
    (void)signal_number;
    is_over = 1;
}

static void catch_signals(void)
{
    const struct sigaction action = {.sa_handler = end}; // without SA_RESTART
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGPIPE, &action, NULL);
}

/// Handles a failed write. If the reader closed the pipe, the view ends silently, as after a signal; other failures are errors.
static bool complain_of_output(void)
{
    const int why = errno;
    clearerr(stdout);
    return why == EPIPE || link_complain("standard output: cannot be written: %s", strerror(why));
}

static bool sample(link_bus_t *bus, const status_watch_t *watch, int udp, int teleplot, bool has_view)
{
    trail_t      trails[3] = {{.title = "F", .unit = "N", .factor = 1.0},
                              {.title = "r - F", .unit = "mN", .factor = 1e3},
                              {.title = "u", .unit = "N", .factor = 1.0}};
    int          count     = 0;
    const double start_s   = common_clock_s();
    double       next_s    = start_s;
    while (is_over == 0 && common_clock_s() - start_s < watch->hold_s)
    {
        uint32_t words[WORDS];
        if (!read_words(bus, words))
        {
            return is_over != 0;
        }
        send_sample(udp, bus, words, false);
        send_sample(teleplot, bus, words, true);
        if (watch->json)
        {
            char         text[STATUS_SAMPLE_MAX];
            const size_t length = write_sample(text, bus, words, false);
            (void)fwrite(text, 1, length, stdout);
            if (fflush(stdout) != 0)
            {
                return complain_of_output();
            }
        }
        if (has_view)
        {
            draw_view(bus, words, trails, &count);
        }
        next_s += 1.0 / watch->rate_hz;
        const double rest_s = next_s - common_clock_s();
        next_s              = rest_s < 0.0 ? common_clock_s() : next_s; // the line is too slow for this rate
        if (is_over == 0 && !link_bus_rest(bus, rest_s > 1e-3 ? (int)(1e3 * rest_s) : 1))
        {
            return is_over != 0;
        }
    }
    return true;
}

bool status_watch(link_bus_t *bus, const status_watch_t *watch)
{
    const bool sends    = watch->json || watch->udp != NULL || watch->teleplot != NULL;
    const bool has_view = !watch->json && isatty(STDOUT_FILENO) != 0;
    if (!sends && !has_view)
    {
        return link_complain("watch: standard output is no terminal: --json, --udp or --teleplot is expected");
    }
    const int udp      = watch->udp != NULL ? open_udp("--udp", watch->udp) : -1;
    const int teleplot = watch->teleplot != NULL ? open_udp("--teleplot", watch->teleplot) : -1;
    if ((watch->udp != NULL && udp < 0) || (watch->teleplot != NULL && teleplot < 0))
    {
        return false;
    }
    catch_signals();
    (void)fputs(has_view ? "\033[?1049h\033[?25l" : "", stdout); // alternate screen, cursor hidden
    const bool ok = sample(bus, watch, udp, teleplot, has_view);
    (void)fputs(has_view ? "\033[?25h\033[?1049l" : "", stdout);
    return ok;
}
