#include "serve.h"

#include "address.h"
#include "status.h"
#include "support/clock.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <microhttpd.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define CLIENTS_MAX   64
#define SPARE         16u ///< places kept free for new clients, see make_room
#define LISTENERS_MAX 24
#define WAITING_MAX   8
#define REQUEST_MAX   8192u  ///< bytes of a request's body
#define MEMORY_MAX    16384u ///< bytes for a connection's headers and the event being sent
#define ANSWER_MAX    (4u * 1024u * 1024u)
#define WORDS_MAX     40
#define TOKEN_DIGITS  32
#define IDLE_S        10u ///< a client that neither sends nor receives for this long is disconnected

extern const unsigned char link_page[]; // page.html, see CMakeLists.txt
extern const size_t        link_page_length;

/// The stage of a client's request. Each stage has a time limit, which a client cannot extend by sending more bytes.
typedef enum
{
    FREE,
    ASKING,    ///< sends its headers; its token has not been checked yet
    SENDING,   ///< sends the body; its token is right
    WAITING,   ///< waits for an earlier command to end
    WORKING,   ///< its command runs
    ANSWERING, ///< receives its answer
    LISTENING, ///< receives samples
    STAGES
} stage_t;

static const double patience_s[STAGES] = {[FREE]      = (double)INFINITY,
                                          [ASKING]    = 3.0,
                                          [SENDING]   = 10.0,
                                          [WAITING]   = (double)INFINITY,
                                          [WORKING]   = (double)INFINITY,
                                          [ANSWERING] = 60.0,
                                          [LISTENING] = (double)INFINITY};

/// A connection and its one request.
typedef struct
{
    stage_t                stage;
    double                 since_s;
    struct MHD_Connection *connection;
    int                    socket;
    char                   body[REQUEST_MAX + 1u];
    size_t                 length;
    char                  *words[WORDS_MAX + 1]; ///< the words of its command
    uint64_t               turn;                 ///< the position of its command in the order of arrival
    pid_t                  command;              ///< the process that makes the answer, while it runs
    int                    output, status;
    bool                   has_ended; ///< whether the command has ended
    char                  *answer;
    size_t                 answer_length;
    bool                   waits; ///< whether the client waits for the next sample
    char                   event[STATUS_SAMPLE_MAX + 8u];
    size_t                 event_length, event_sent;
} request_t;

typedef struct
{
    link_bus_t        *bus;
    const serve_t     *options;
    struct MHD_Daemon *http;
    int                listener, port;
    char               name[LINK_HOST_MAX + 2]; ///< the address it listens on, as in a URL
    char               token[TOKEN_DIGITS + 1];
    uint64_t           turns; ///< commands received so far
    request_t          requests[CLIENTS_MAX];
} server_t;

static volatile sig_atomic_t is_over;

static void end_serving(int signal_number)
{
    (void)signal_number;
    is_over = 1;
}

static void enter(request_t *request, stage_t stage)
{
    request->stage   = stage;
    request->since_s = common_clock_s();
}

static int count_in(const server_t *server, stage_t stage)
{
    int count = 0;
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        count += server->requests[i].stage == stage ? 1 : 0;
    }
    return count;
}

// --- answers -------------------------------------------------------------------------------------------------------

static void add_safe_headers(struct MHD_Response *response, const char *type)
{
    static const char *const safe[][2] = {
        {"Cache-Control", "no-store"},
        {"X-Content-Type-Options", "nosniff"},
        {"X-Frame-Options", "DENY"},
        {"Referrer-Policy", "no-referrer"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Content-Security-Policy",
         "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; img-src "
         "data:; "
         "frame-ancestors 'none'"},
        {"Connection", "close"},
    };
    (void)MHD_add_response_header(response, "Content-Type", type);
    for (size_t i = 0; i < sizeof safe / sizeof safe[0]; i++)
    {
        (void)MHD_add_response_header(response, safe[i][0], safe[i][1]);
    }
}

/// Sends and frees the response; a null response ends the connection.
static enum MHD_Result send_response(request_t           *request,
                                     unsigned             status,
                                     struct MHD_Response *response,
                                     const char          *type)
{
    if (response == NULL)
    {
        return MHD_NO;
    }
    add_safe_headers(response, type);
    enter(request, ANSWERING);
    const enum MHD_Result result = MHD_queue_response(request->connection, status, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result answer(request_t *request, unsigned status, const char *type, char *body, size_t length)
{
    struct MHD_Response *response = MHD_create_response_from_buffer(length, body, MHD_RESPMEM_MUST_COPY);
    return send_response(request, status, response, type);
}

static enum MHD_Result refuse(request_t *request, unsigned status, const char *why)
{
    return answer(request, status, "text/plain; charset=utf-8", (char *)why, strlen(why));
}

static enum MHD_Result answer_page(const server_t *server, request_t *request)
{
    static const char mark[] = "%TOKEN%";
    const char *const text   = (const char *)link_page;
    const char *const at     = strstr(text, mark);
    const size_t      length = link_page_length - (sizeof mark - 1u) + TOKEN_DIGITS;
    char             *page   = malloc(length + 1u);
    if (page == NULL)
    {
        return MHD_NO;
    }
    (void)snprintf(page, length + 1u, "%.*s%s%s", (int)(at - text), text, server->token, at + sizeof mark - 1u);
    const enum MHD_Result result = answer(request, MHD_HTTP_OK, "text/html; charset=utf-8", page, length);
    free(page);
    return result;
}

/// Writes a text of the register list as JSON. Such a text has no control characters, so only backslash and quote are escaped.
static void write_text(FILE *file, const char *text)
{
    (void)fputc('"', file);
    for (; *text != '\0'; text++)
    {
        (void)fprintf(file, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    }
    (void)fputc('"', file);
}

static enum MHD_Result answer_list(const server_t *server, request_t *request)
{
    size_t            count, size = 0;
    char             *text      = NULL;
    const link_row_t *list      = link_list(&count);
    FILE             *file      = open_memstream(&text, &size);
    const char       *separator = "[";
    if (file == NULL)
    {
        return MHD_NO;
    }
    for (size_t i = 0; i < count; i++)
    {
        const bool is_there = link_bus_feeds_forward(server->bus) || !link_is_of_feedforward(&list[i]);
        if (list[i].group != LINK_PARAM || !is_there)
        {
            continue;
        }
        (void)fprintf(file, "%s{\"name\":\"%s\",\"unit\":\"%s\",", separator, list[i].name, list[i].unit);
        (void)fprintf(file, "\"low\":%.9g,\"high\":%.9g,", list[i].low, list[i].high);
        (void)fprintf(file, "\"protects\":%s,", list[i].protects ? "true" : "false");
        (void)fprintf(file, "\"wired\":%s,\"text\":", list[i].wired ? "true" : "false");
        write_text(file, list[i].text);
        (void)fputc('}', file);
        separator = ",";
    }
    (void)fputs("]", file);
    const bool            is_whole = fclose(file) == 0;
    const enum MHD_Result result   = is_whole ? answer(request, MHD_HTTP_OK, "application/json", text, size) : MHD_NO;
    free(text);
    return result;
}

/// Sends the rest of the newest sample; after that the connection waits for the next sample.
static ssize_t read_event(void *of, uint64_t position, char *buffer, size_t room)
{
    request_t   *request = of;
    const size_t left    = request->event_length - request->event_sent;
    const size_t count   = left < room ? left : room;
    (void)position;
    if (is_over != 0)
    {
        return MHD_CONTENT_READER_END_OF_STREAM;
    }
    if (count == 0u)
    {
        MHD_suspend_connection(request->connection);
        request->waits = true;
        return 0;
    }
    memcpy(buffer, request->event + request->event_sent, count);
    request->event_sent += count;
    return (ssize_t)count;
}

static enum MHD_Result begin_events(const server_t *server, request_t *request)
{
    if (count_in(server, LISTENING) >= LISTENERS_MAX)
    {
        return refuse(request, MHD_HTTP_SERVICE_UNAVAILABLE, "too many pages are open: close one");
    }
    struct MHD_Response *response =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, sizeof request->event, read_event, request, NULL);
    const enum MHD_Result result = send_response(request, MHD_HTTP_OK, response, "text/event-stream; charset=utf-8");
    enter(request, LISTENING);
    return result;
}

// --- commands: this program is run again with the command's words --------------------------------------------------------

static bool is_command(const request_t *request, const char *name)
{
    return strcmp(request->words[0], name) == 0;
}

/// The command's process; its answer is what it says until it ends. False: none was made.
static bool start_command(const server_t *server, request_t *request)
{
    int   ends[2];
    char *arguments[WORDS_MAX + 8] = {"tribo-link", "-d", NULL, "-u", NULL, "--baud", NULL};
    int   count                    = server->options->baud != NULL ? 7 : 5;
    arguments[2]                   = (char *)link_bus_name(server->bus);
    arguments[4]                   = (char *)server->options->unit;
    arguments[6]                   = (char *)server->options->baud;
    for (int i = 0; request->words[i] != NULL; i++)
    {
        arguments[count++] = request->words[i];
    }
    arguments[count] = NULL;
    if (pipe2(ends, O_CLOEXEC) != 0)
    {
        return false;
    }
    // Until exec the child has this program's signal handlers, which would swallow a signal, so all signals are blocked.
    sigset_t all;
    sigset_t before;
    (void)sigfillset(&all);
    (void)sigprocmask(SIG_SETMASK, &all, &before);
    request->command = fork();
    if (request->command == 0)
    {
        (void)signal(SIGINT, SIG_DFL);
        (void)signal(SIGTERM, SIG_DFL);
        (void)sigprocmask(SIG_SETMASK, &before, NULL);
        (void)dup2(ends[1], STDOUT_FILENO);
        (void)dup2(ends[1], STDERR_FILENO);
        (void)execv("/proc/self/exe", arguments);
        _exit(127);
    }
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    (void)close(ends[1]);
    if (request->command < 0)
    {
        (void)close(ends[0]);
        return false;
    }
    request->output = ends[0];
    enter(request, WORKING);
    return true;
}

/// Resumes the connection, which then receives its answer.
static void resume(request_t *request, int status)
{
    request->status    = status;
    request->has_ended = true;
    enter(request, ANSWERING);
    MHD_resume_connection(request->connection);
}

/// Cancels a command; `why` becomes its answer.
static void drop_command(request_t *request, const char *why)
{
    free(request->answer);
    request->answer        = strdup(why);
    request->answer_length = request->answer != NULL ? strlen(why) : 0u;
    resume(request, 1);
}

static void end_command(request_t *request)
{
    int status = 0;
    (void)waitpid(request->command, &status, 0);
    (void)close(request->output);
    resume(request, status);
}

/// Stops a command that runs or waits for its turn.
static void stop_command(request_t *request, const char *why)
{
    if (request->stage == WORKING)
    {
        (void)kill(request->command, SIGTERM);
        (void)waitpid(request->command, NULL, 0);
        (void)close(request->output);
    }
    drop_command(request, why);
}

/// Reads the command's output. When the command ends, its answer is sent.
static void read_command(request_t *request)
{
    ssize_t count = -1;
    char   *larger =
        request->answer_length < ANSWER_MAX ? realloc(request->answer, request->answer_length + 65536u) : NULL;
    if (larger != NULL)
    {
        request->answer = larger;
        count           = read(request->output, request->answer + request->answer_length, 65536u);
    }
    if (count > 0)
    {
        request->answer_length += (size_t)count;
        return;
    }
    end_command(request);
}

/// Cancels the other commands when a stop arrives, because none of them may act after it. A trace only records, so it continues.
static void make_way(server_t *server)
{
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        request_t *request = &server->requests[i];
        const bool is_one  = request->stage == WAITING || request->stage == WORKING;
        if (is_one && !is_command(request, "stop") && !is_command(request, "trace"))
        {
            stop_command(request, "ended by a stop");
        }
    }
}

/// Whether a trace runs, or whether another command runs. One of each may run at a time, because a trace may wait for an effect of
/// the other command.
static bool is_working(const server_t *server, bool is_trace)
{
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        const request_t *request = &server->requests[i];
        if (request->stage == WORKING && is_command(request, "trace") == is_trace)
        {
            return true;
        }
    }
    return false;
}

/// Starts the command that has waited longest, unless one runs.
static void start_next(server_t *server)
{
    request_t *next = NULL;
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        request_t *request = &server->requests[i];
        if (request->stage == WAITING && (next == NULL || request->turn < next->turn))
        {
            next = request;
        }
    }
    if (next != NULL && !is_working(server, is_command(next, "trace")) && !start_command(server, next))
    {
        drop_command(next, "there is no room for a process");
    }
}

/// Queues a command; the client is answered when it ends. A stop goes before all others.
static enum MHD_Result queue_command(server_t *server, request_t *request)
{
    if (is_command(request, "trace") && is_working(server, true))
    {
        return refuse(request, MHD_HTTP_CONFLICT, "a trace is being recorded: one at a time");
    }
    if (is_command(request, "stop"))
    {
        make_way(server);
    }
    if (count_in(server, WAITING) >= WAITING_MAX)
    {
        return refuse(request, MHD_HTTP_SERVICE_UNAVAILABLE, "too many commands wait");
    }
    request->turn = server->turns++;
    MHD_suspend_connection(request->connection);
    enter(request, WAITING);
    start_next(server);
    return MHD_YES;
}

static bool is_one_of(const char *word, const char *const list[])
{
    int i = 0;
    while (list[i] != NULL && strcmp(list[i], word) != 0)
    {
        i++;
    }
    return list[i] != NULL;
}

/// Whether `word` is an option of trace that names no file.
static bool is_of_trace(const char *word)
{
    static const char *const options[] =
        {"--signals=", "--decimation=", "--trigger=", "--watch=", "--level=", "--after=", "--wait=", NULL};
    int i = 0;
    while (options[i] != NULL && strncmp(word, options[i], strlen(options[i])) != 0)
    {
        i++;
    }
    return options[i] != NULL;
}

/// Splits a page's command into words for the command line; false if it is not allowed. Allowed are commands that write no file,
/// and the options of a trace.
static bool take_words(char *text, char *words[WORDS_MAX + 1])
{
    static const char *const plain[]  = {"start", "stop", "tare", "restore", "forget", NULL};
    static const char *const params[] = {"set", "save", "defaults", NULL};
    char                    *given[WORDS_MAX];
    int                      count = 0, used = 0;
    char                    *rest = NULL;
    for (char *word = strtok_r(text, "\n", &rest); word != NULL && count < WORDS_MAX - 4;
         word       = strtok_r(NULL, "\n", &rest))
    {
        given[count++] = word;
    }
    if (count == 0)
    {
        return false;
    }
    words[used++]       = given[0];
    const bool is_trace = strcmp(given[0], "trace") == 0;
    if (strcmp(given[0], "acknowledge") == 0)
    {
        words[0]      = "fault";
        words[used++] = "--acknowledge";
    }
    else if (strcmp(given[0], "reference") == 0)
    {
        words[used++] = "--hold=0"; // written once
    }
    else if (!is_trace && !(count == 1 && is_one_of(given[0], plain)) &&
             !(count > 1 && strcmp(given[0], "params") == 0 && is_one_of(given[1], params)))
    {
        return false;
    }
    if (!is_trace)
    {
        words[used++] = "--";
    }
    for (int i = 1; i < count; i++)
    {
        if (is_trace && !is_of_trace(given[i]))
        {
            return false;
        }
        words[used++] = given[i];
    }
    words[used] = NULL;
    return true;
}

// --- requests ------------------------------------------------------------------------------------------------------

/// A header or an argument: its last value and how often it occurs.
typedef struct
{
    const char *name, *value;
    int         count;
} header_t;

static enum MHD_Result note_value(void *of, enum MHD_ValueKind kind, const char *name, const char *value)
{
    header_t *header = of;
    (void)kind;
    if (strcasecmp(name, header->name) == 0)
    {
        header->value = value != NULL ? value : "";
        header->count++;
    }
    return MHD_YES;
}

static header_t find_value(struct MHD_Connection *connection, enum MHD_ValueKind kind, const char *name)
{
    header_t header = {.name = name};
    (void)MHD_get_connection_values(connection, kind, note_value, &header);
    return header;
}

/// Whether HOST:PORT is a name of this server.
static bool is_own_name(const server_t *server, const char *host)
{
    const char *const names[] = {"127.0.0.1", "localhost", "[::1]", server->name, server->options->allow};
    char              full[LINK_HOST_MAX + 16];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
    {
        (void)snprintf(full, sizeof full, "%s:%d", names[i] != NULL ? names[i] : "", server->port);
        if (names[i] != NULL && strcasecmp(host, full) == 0)
        {
            return true;
        }
    }
    return false;
}

/// Compares in constant time, so that the time does not reveal the first wrong digit.
static bool is_token(const server_t *server, const char *text)
{
    unsigned differs = 0;
    if (strlen(text) != TOKEN_DIGITS)
    {
        return false;
    }
    for (size_t i = 0; i < TOKEN_DIGITS; i++)
    {
        differs |= (unsigned)text[i] ^ (unsigned)server->token[i];
    }
    return differs == 0u;
}

/// Returns the first reason to refuse the caller, or null. All paths need the token, because even those that only show values
/// query the drive.
static const char *check_caller(const server_t *server, struct MHD_Connection *connection, bool may_be_in_url)
{
    const header_t host   = find_value(connection, MHD_HEADER_KIND, "Host");
    const header_t origin = find_value(connection, MHD_HEADER_KIND, "Origin");
    const header_t site   = find_value(connection, MHD_HEADER_KIND, "Sec-Fetch-Site");
    header_t       token  = find_value(connection, MHD_HEADER_KIND, "X-Tribo-Token");
    if (host.count != 1 || !is_own_name(server, host.value))
    {
        return "Host is none of this server's names";
    }
    if (origin.count > 0 &&
        (origin.count > 1 || strncmp(origin.value, "http://", 7) != 0 || !is_own_name(server, origin.value + 7)))
    {
        return "Origin is another page";
    }
    if (site.count > 0 &&
        (site.count > 1 || (strcmp(site.value, "same-origin") != 0 && strcmp(site.value, "none") != 0)))
    {
        return "another page asks: enter the address that tribo-link serve has printed";
    }
    if (token.count == 0 && may_be_in_url)
    {
        token = find_value(connection, MHD_GET_ARGUMENT_KIND, "token");
    }
    return token.count != 1 || !is_token(server, token.value)
               ? "the token is missing or another: enter the address that tribo-link serve has printed"
               : NULL;
}

static enum MHD_Result serve_get(server_t *server, request_t *request, const char *path)
{
    static char *const values[] = {"params", "get", NULL};
    if (strcmp(path, "/") == 0)
    {
        return answer_page(server, request);
    }
    if (strcmp(path, "/events") == 0)
    {
        return begin_events(server, request);
    }
    if (strcmp(path, "/list") == 0)
    {
        return answer_list(server, request);
    }
    if (strcmp(path, "/values") == 0)
    {
        memcpy(request->words, values, sizeof values);
        return queue_command(server, request);
    }
    return refuse(request, MHD_HTTP_NOT_FOUND, "there is no such page");
}

static enum MHD_Result serve_post(server_t *server, request_t *request)
{
    if (request->length > REQUEST_MAX)
    {
        return refuse(request, MHD_HTTP_CONTENT_TOO_LARGE, "a request is at most 8 KB");
    }
    request->body[request->length] = '\0';
    if (strlen(request->body) != request->length || !take_words(request->body, request->words))
    {
        return refuse(request, MHD_HTTP_BAD_REQUEST, "no command of the page");
    }
    return queue_command(server, request);
}

/// Called when a request's headers have arrived. A request that is not from the page is refused before its body is read.
static enum MHD_Result begin_request(server_t *server, request_t *request, const char *method)
{
    const char *wrong = check_caller(server, request->connection, strcmp(method, "GET") == 0);
    if (wrong != NULL)
    {
        return refuse(request, MHD_HTTP_FORBIDDEN, wrong);
    }
    enter(request, SENDING);
    return MHD_YES;
}

/// Serves a request that has arrived completely.
static enum MHD_Result serve_request(server_t *server, request_t *request, const char *method, const char *path)
{
    if (strcmp(method, "POST") == 0 && strcmp(path, "/do") == 0)
    {
        return serve_post(server, request);
    }
    if (strcmp(method, "GET") == 0)
    {
        return serve_get(server, request, path);
    }
    return refuse(request, MHD_HTTP_METHOD_NOT_ALLOWED, "GET is expected, or POST /do");
}

static request_t *request_of(struct MHD_Connection *connection)
{
    return MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context;
}

/// Called with a request's headers, with each piece of its body, at its end, and once more when its command has ended.
static enum MHD_Result take_request(void                  *of,
                                    struct MHD_Connection *connection,
                                    const char            *path,
                                    const char            *method,
                                    const char            *version,
                                    const char            *piece,
                                    size_t                *size,
                                    void                 **own)
{
    server_t  *server  = of;
    request_t *request = request_of(connection);
    (void)version;
    if (request == NULL)
    {
        return MHD_NO;
    }
    if (*own == NULL)
    {
        *own = request;
        return begin_request(server, request, method);
    }
    if (*size > 0u)
    {
        const size_t room = REQUEST_MAX - (request->length < REQUEST_MAX ? request->length : REQUEST_MAX);
        memcpy(request->body + request->length, piece, *size < room ? *size : room);
        request->length += *size;
        *size = 0u;
        return MHD_YES;
    }
    if (request->has_ended)
    {
        const unsigned status = request->status == 0 ? MHD_HTTP_OK : MHD_HTTP_CONFLICT;
        return answer(request, status, "text/plain; charset=utf-8", request->answer, request->answer_length);
    }
    return serve_request(server, request, method, path);
}

// --- connections ---------------------------------------------------------------------------------------------------

/// Disconnects a client. The server then handles it like a client that has disconnected itself.
static void hang_up(const request_t *request)
{
    (void)shutdown(request->socket, SHUT_RDWR);
}

/// When few places are free, disconnects one client: the oldest of those whose token has not been checked, otherwise of those that
/// receive an answer or send a body.
static void make_room(server_t *server)
{
    static const stage_t order[] = {ASKING, ANSWERING, SENDING};
    const request_t     *oldest  = NULL;
    if (count_in(server, FREE) >= (int)SPARE)
    {
        return;
    }
    for (size_t k = 0; oldest == NULL && k < sizeof order / sizeof order[0]; k++)
    {
        for (int i = 0; i < CLIENTS_MAX; i++)
        {
            const request_t *request = &server->requests[i];
            if (request->stage == order[k] && (oldest == NULL || request->since_s < oldest->since_s))
            {
                oldest = request;
            }
        }
    }
    if (oldest != NULL)
    {
        hang_up(oldest);
    }
}

static void note_connection(void                               *of,
                            struct MHD_Connection              *connection,
                            void                              **context,
                            enum MHD_ConnectionNotificationCode what)
{
    server_t  *server  = of;
    request_t *request = *context;
    if (what == MHD_CONNECTION_NOTIFY_CLOSED)
    {
        if (request != NULL)
        {
            free(request->answer);
            request->stage = FREE;
        }
        return;
    }
    make_room(server);
    int i = 0;
    while (i < CLIENTS_MAX && server->requests[i].stage != FREE)
    {
        i++;
    }
    if (i < CLIENTS_MAX)
    {
        server->requests[i] =
            (request_t){.connection = connection,
                        .socket = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd};
        enter(&server->requests[i], ASKING);
        *context = &server->requests[i];
    }
}

/// Disconnects the clients whose time limit has passed, and returns when the next limit passes.
static double hang_up_on_slow(const server_t *server)
{
    const double now_s  = common_clock_s();
    double       next_s = (double)INFINITY;
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        const request_t *request = &server->requests[i];
        const double     end_s   = request->since_s + patience_s[request->stage];
        if (now_s >= end_s)
        {
            hang_up(request);
        }
        next_s = fmin(next_s, fmax(end_s, now_s + 0.1));
    }
    return next_s;
}

// --- the loop ------------------------------------------------------------------------------------------------------

/// Reads the output of commands, and ends the commands of clients that have disconnected.
static void attend_commands(server_t *server, const struct pollfd events[2 * CLIENTS_MAX])
{
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        request_t *request = &server->requests[i];
        if (events[2 * i + 1].revents != 0)
        {
            stop_command(request, "");
        }
        else if (events[2 * i].revents != 0)
        {
            read_command(request);
        }
    }
    start_next(server);
}

/// Serves requests and commands until it is time for a sample. A client that disconnects ends its command.
static void attend(server_t *server, double until_s)
{
    const int http = MHD_get_daemon_info(server->http, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd;
    while (is_over == 0 && MHD_run(server->http) == MHD_YES)
    {
        struct pollfd      events[1 + 2 * CLIENTS_MAX];
        unsigned long long http_ms = 0;
        double             wait_ms = ceil(1e3 * (fmin(until_s, hang_up_on_slow(server)) - common_clock_s()));
        events[2 * CLIENTS_MAX]    = (struct pollfd){.fd = http, .events = POLLIN};
        for (int i = 0; i < CLIENTS_MAX; i++)
        {
            const request_t *request = &server->requests[i];
            const bool       works   = request->stage == WORKING;
            const bool       is_one  = works || request->stage == WAITING;
            events[2 * i]            = (struct pollfd){.fd = works ? request->output : -1, .events = POLLIN};
            events[2 * i + 1]        = (struct pollfd){.fd = is_one ? request->socket : -1, .events = POLLRDHUP};
        }
        if (until_s <= common_clock_s())
        {
            return;
        }
        if (MHD_get_timeout(server->http, &http_ms) == MHD_YES)
        {
            wait_ms = fmin(wait_ms, (double)http_ms);
        }
        if (poll(events, 1 + 2 * CLIENTS_MAX, (int)fmax(wait_ms, 0.0)) < 0)
        {
            return;
        }
        attend_commands(server, events);
    }
}

/// Sends a sample to all listeners. A listener that has not received the previous one completely misses this one.
static void send_events(server_t *server, const char *text, size_t length)
{
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        request_t *request = &server->requests[i];
        if (request->stage == LISTENING && request->waits)
        {
            // The sample ends with a newline; an event needs a second one.
            request->event_length =
                (size_t)snprintf(request->event, sizeof request->event, "data: %.*s\n", (int)length, text);
            request->event_sent = 0u;
            request->waits      = false;
            MHD_resume_connection(request->connection);
        }
    }
}

/// Takes samples at the set rate and serves requests between them. The bus is held during a sample only, so commands can use it.
static bool sample_and_attend(server_t *server)
{
    double next_s = common_clock_s();
    link_bus_release(server->bus);
    while (is_over == 0)
    {
        if (count_in(server, LISTENING) > 0 && !is_working(server, false))
        {
            char         text[STATUS_SAMPLE_MAX];
            const bool   is_taken = link_bus_take(server->bus);
            const size_t length   = is_taken ? status_sample(server->bus, text) : 0u;
            if (length == 0u)
            {
                return is_over != 0;
            }
            link_bus_release(server->bus);
            send_events(server, text, length);
        }
        next_s = fmax(next_s + 1.0 / server->options->rate_hz, common_clock_s());
        attend(server, next_s);
    }
    return true;
}

/// Ends all suspended requests; libmicrohttpd cannot stop while there is one.
static void end_requests(server_t *server)
{
    is_over = 1;
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        request_t *request = &server->requests[i];
        if (request->stage == WORKING || request->stage == WAITING)
        {
            stop_command(request, "the server ends");
        }
        else if (request->stage == LISTENING && request->waits)
        {
            request->waits = false;
            MHD_resume_connection(request->connection);
        }
    }
}

static bool is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET)
    {
        struct sockaddr_in in;
        memcpy(&in, address, sizeof in);
        return (ntohl(in.sin_addr.s_addr) >> 24) == 127u;
    }
    struct sockaddr_in6 in6;
    memcpy(&in6, address, sizeof in6);
    return address->sa_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&in6.sin6_addr);
}

/// Stores the address that the server listens on, as in a URL.
static void name_address(server_t *server, const struct sockaddr_storage *bound, socklen_t size)
{
    char host[LINK_HOST_MAX] = "";
    (void)getnameinfo((const struct sockaddr *)bound, size, host, sizeof host, NULL, 0, NI_NUMERICHOST);
    (void)snprintf(server->name, sizeof server->name, bound->ss_family == AF_INET6 ? "[%s]" : "%s", host);
}

static bool bind_to(server_t *server, const struct addrinfo *found)
{
    const char *listen_on = server->options->listen;
    const int   yes       = 1;
    if (!is_loopback(found->ai_addr) && server->options->allow == NULL)
    {
        return link_complain(
            "serve: --listen %s is not this machine alone: --allow NAME is to say by which name others may call it",
            listen_on);
    }
    server->listener = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    (void)setsockopt(server->listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    struct sockaddr_storage bound = {.ss_family = AF_UNSPEC};
    socklen_t               size  = sizeof bound;
    if (server->listener < 0 || bind(server->listener, found->ai_addr, found->ai_addrlen) != 0 ||
        listen(server->listener, SOMAXCONN) != 0 ||
        getsockname(server->listener, (struct sockaddr *)&bound, &size) != 0)
    {
        return link_complain("serve: --listen %s: %s", listen_on, strerror(errno));
    }
    struct sockaddr_in in;
    memcpy(&in, &bound, sizeof in);
    server->port = ntohs(in.sin_port); // sin6_port is at the same offset
    name_address(server, &bound, size);
    return true;
}

static bool open_listener(server_t *server)
{
    char                  name[512];
    link_address_t        address;
    const char           *text   = server->options->listen;
    const struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE};
    (void)snprintf(name, sizeof name, "serve: --listen %s", text);
    struct addrinfo *found = link_address_find(name, text, NULL, 0, &wanted, &address);
    if (found == NULL)
    {
        return false;
    }
    const bool ok = bind_to(server, found);
    freeaddrinfo(found);
    return ok;
}

static bool make_token(server_t *server)
{
    unsigned char bytes[TOKEN_DIGITS / 2];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
    {
        return link_complain("serve: no random numbers");
    }
    for (size_t i = 0; i < sizeof bytes; i++)
    {
        (void)snprintf(server->token + 2 * i, 3, "%02x", bytes[i]);
    }
    return true;
}

bool serve(link_bus_t *bus, const serve_t *options)
{
    static server_t        server;
    const struct sigaction action = {.sa_handler = end_serving}; // without SA_RESTART
    server                        = (server_t){.bus = bus, .options = options, .listener = -1};
    if (!make_token(&server) || !open_listener(&server))
    {
        return false;
    }
    server.http = MHD_start_daemon(MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME,
                                   0,
                                   NULL,
                                   NULL,
                                   take_request,
                                   &server,
                                   MHD_OPTION_LISTEN_SOCKET,
                                   server.listener,
                                   MHD_OPTION_CONNECTION_LIMIT,
                                   (unsigned)CLIENTS_MAX,
                                   MHD_OPTION_CONNECTION_TIMEOUT,
                                   IDLE_S,
                                   MHD_OPTION_CONNECTION_MEMORY_LIMIT,
                                   (size_t)MEMORY_MAX,
                                   MHD_OPTION_NOTIFY_CONNECTION,
                                   note_connection,
                                   &server,
                                   MHD_OPTION_END);
    if (server.http == NULL)
    {
        (void)close(server.listener);
        return link_complain("serve: the HTTP server does not start");
    }
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)printf("http://%s:%d/?token=%s   Ctrl-C ends it, not the drive\n",
                 options->allow != NULL ? options->allow : server.name,
                 server.port,
                 server.token);
    const bool ok = (fflush(stdout) == 0 || link_complain("standard output: cannot be written: %s", strerror(errno))) &&
                    sample_and_attend(&server);
    end_requests(&server);
    MHD_stop_daemon(server.http);
    return ok;
}
