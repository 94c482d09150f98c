#include "serve.h"

#include "status.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
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
#include <time.h>
#include <unistd.h>

#define CLIENTS_MAX  24
#define REQUEST_MAX  8192u
#define ANSWER_MAX   (4u * 1024u * 1024u)
#define WORDS_MAX    40
#define TOKEN_DIGITS 32
#define IDLE_S       10.0 ///< that a client has to say what it wants

extern const unsigned char link_page[]; // page.html, see CMakeLists.txt
extern const size_t        link_page_length;

/// A connection, and the command that answers it.
typedef struct
{
    int    fd; ///< -1: free
    bool   has_events;
    double since_s;
    char   request[REQUEST_MAX + 1];
    size_t length;
    pid_t  command; ///< 0: none
    int    output;  ///< of the command
    char  *answer;
    size_t answer_length;
} client_t;

typedef struct
{
    link_bus_t    *bus;
    const serve_t *options;
    int            listener, port;
    char           token[TOKEN_DIGITS + 1];
    client_t       clients[CLIENTS_MAX];
} server_t;

static double now_s(void)
{
    struct timespec time;
    (void)clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

// --- answers -------------------------------------------------------------------------------------------------------

static void forget(client_t *client)
{
    if (client->command != 0)
    {
        (void)kill(client->command, SIGTERM);
        (void)waitpid(client->command, NULL, 0);
        (void)close(client->output);
    }
    free(client->answer);
    (void)close(client->fd);
    *client = (client_t){.fd = -1};
}

/// All of it, within a second: a browser on this machine reads what it asked for.
static bool send_all(const client_t *client, const char *bytes, size_t length)
{
    struct pollfd ready = {.fd = client->fd, .events = POLLOUT};
    while (length > 0u)
    {
        const ssize_t sent = send(client->fd, bytes, length, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0 && (errno != EAGAIN || poll(&ready, 1, 1000) != 1))
        {
            return false;
        }
        bytes += sent > 0 ? sent : 0;
        length -= sent > 0 ? (size_t)sent : 0u;
    }
    return true;
}

#define SAFE                                                                                                           \
    "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\nReferrer-Policy: "         \
    "no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\nContent-Security-Policy: default-src 'none'; "        \
    "script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; img-src data:; frame-ancestors "       \
    "'none'\r\nConnection: close\r\n"

static void answer(client_t *client, const char *status, const char *type, const char *body, size_t length)
{
    char      head[1024];
    const int size = snprintf(head,
                              sizeof head,
                              "HTTP/1.1 %s\r\nContent-Type: %s; charset=utf-8\r\nContent-Length: %zu\r\n" SAFE "\r\n",
                              status,
                              type,
                              length);
    (void)(send_all(client, head, (size_t)size) && send_all(client, body, length));
    forget(client);
}

static void refuse(client_t *client, const char *status, const char *why)
{
    answer(client, status, "text/plain", why, strlen(why));
}

static void answer_page(const server_t *server, client_t *client)
{
    static const char mark[] = "%TOKEN%";
    const char *const text   = (const char *)link_page;
    const char *const at     = strstr(text, mark);
    const size_t      length = link_page_length - (sizeof mark - 1u) + TOKEN_DIGITS;
    char             *page   = malloc(length + 1u);
    if (page == NULL)
    {
        refuse(client, "500 Internal Server Error", "out of memory");
        return;
    }
    (void)snprintf(page, length + 1u, "%.*s%s%s", (int)(at - text), text, server->token, at + sizeof mark - 1u);
    answer(client, "200 OK", "text/html", page, length);
    free(page);
}

/// The texts of the list have nothing that JSON would have to escape but a backslash or a quote.
static void write_text(FILE *file, const char *text)
{
    (void)fputc('"', file);
    for (; *text != '\0'; text++)
    {
        (void)fprintf(file, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    }
    (void)fputc('"', file);
}

static void answer_list(const server_t *server, client_t *client)
{
    size_t            count, size = 0;
    char             *text      = NULL;
    const link_row_t *list      = link_list(&count);
    FILE             *file      = open_memstream(&text, &size);
    const char       *separator = "[";
    if (file == NULL)
    {
        refuse(client, "500 Internal Server Error", "out of memory");
        return;
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
        (void)fprintf(file, "\"protects\":%s,\"text\":", list[i].protects ? "true" : "false");
        write_text(file, list[i].text);
        (void)fputc('}', file);
        separator = ",";
    }
    (void)fputs("]", file);
    if (fclose(file) == 0)
    {
        answer(client, "200 OK", "application/json", text, size);
    }
    free(text);
}

static void begin_events(client_t *client)
{
    static const char head[] = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n" SAFE "\r\n";
    client->has_events       = send_all(client, head, sizeof head - 1u);
    if (!client->has_events)
    {
        forget(client);
    }
}

// --- commands: this program once more, with their own words --------------------------------------------------------

static void run_command(const server_t *server, client_t *client, char *const words[])
{
    int   ends[2];
    char *arguments[WORDS_MAX + 8] = {"tribo-link", "-d", NULL, "-u", NULL, "--baud", NULL};
    int   count                    = 7;
    arguments[2]                   = (char *)link_bus_name(server->bus);
    arguments[4]                   = (char *)server->options->unit;
    arguments[6]                   = (char *)server->options->baud;
    for (int i = 0; words[i] != NULL; i++)
    {
        arguments[count++] = words[i];
    }
    arguments[count] = NULL;
    if (pipe2(ends, O_CLOEXEC) != 0)
    {
        refuse(client, "503 Service Unavailable", "no pipe");
        return;
    }
    client->command = fork();
    if (client->command == 0)
    {
        (void)dup2(ends[1], STDOUT_FILENO);
        (void)dup2(ends[1], STDERR_FILENO);
        (void)execv("/proc/self/exe", arguments);
        _exit(127);
    }
    (void)close(ends[1]);
    client->output = ends[0];
    if (client->command < 0)
    {
        client->command = 0;
        (void)close(ends[0]);
        refuse(client, "503 Service Unavailable", "no process");
    }
}

/// What it has said; at its end the answer.
static void read_command(client_t *client)
{
    ssize_t count = -1;
    char *larger  = client->answer_length < ANSWER_MAX ? realloc(client->answer, client->answer_length + 65536u) : NULL;
    if (larger != NULL)
    {
        client->answer = larger;
        count          = read(client->output, client->answer + client->answer_length, 65536u);
    }
    if (count > 0)
    {
        client->answer_length += (size_t)count;
        return;
    }
    int status = 1;
    (void)waitpid(client->command, &status, 0);
    (void)close(client->output);
    client->command = 0;
    answer(client, status == 0 ? "200 OK" : "409 Conflict", "text/plain", client->answer, client->answer_length);
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

/// An option of a trace that names no file.
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

/// The words of a page's command as those of the command line, or null. Nothing that writes a file, and no option but a trace's.
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

/// A header's value in `value`; empty if there is none, or more than one.
static void find_header(const char *request, const char *name, char value[256])
{
    const size_t length = strlen(name);
    int          found  = 0;
    value[0]            = '\0';
    for (const char *line = strstr(request, "\r\n"); line != NULL && line[2] != '\r'; line = strstr(line + 2, "\r\n"))
    {
        if (strncasecmp(line + 2, name, length) == 0 && line[2 + length] == ':')
        {
            const char  *start = line + 3 + length + strspn(line + 3 + length, " ");
            const size_t size  = strcspn(start, "\r");
            (void)snprintf(value, 256, "%.*s", (int)(size < 255u ? size : 255u), start);
            found++;
        }
    }
    if (found > 1)
    {
        value[0] = '\0';
    }
}

/// Whether HOST:PORT is a name of this server.
static bool is_own_name(const server_t *server, const char *host)
{
    const char *const names[] = {"127.0.0.1", "localhost", "[::1]", server->options->allow};
    char              full[256];
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

/// The first thing that is wrong with who asks; null if nothing is.
static const char *check_origin(const server_t *server, const char *request, bool changes)
{
    char host[256], origin[256], token[256];
    find_header(request, "Host", host);
    find_header(request, "Origin", origin);
    find_header(request, "X-Tribo-Token", token);
    if (!is_own_name(server, host))
    {
        return "Host is none of this server's names";
    }
    if (origin[0] != '\0' && (strncmp(origin, "http://", 7) != 0 || !is_own_name(server, origin + 7)))
    {
        return "Origin is another page";
    }
    return changes && strcmp(token, server->token) != 0 ? "X-Tribo-Token is not the page's" : NULL;
}

static void serve_get(const server_t *server, client_t *client, const char *path)
{
    if (strcmp(path, "/") == 0)
    {
        answer_page(server, client);
    }
    else if (strcmp(path, "/events") == 0)
    {
        begin_events(client);
    }
    else if (strcmp(path, "/list") == 0)
    {
        answer_list(server, client);
    }
    else if (strcmp(path, "/values") == 0)
    {
        run_command(server, client, (char *[]){"params", "get", NULL});
    }
    else
    {
        refuse(client, "404 Not Found", "there is no such page");
    }
}

/// A request that is there as a whole. `body` ends with a zero byte.
static void serve_request(const server_t *server, client_t *client, char *body)
{
    char  method[8], path[64];
    char *words[WORDS_MAX + 1];
    if (sscanf(client->request, "%7s %63s HTTP/1", method, path) != 2)
    {
        refuse(client, "400 Bad Request", "no request of HTTP");
        return;
    }
    const bool  is_post = strcmp(method, "POST") == 0;
    const char *wrong   = check_origin(server, client->request, is_post);
    if (wrong != NULL)
    {
        refuse(client, "403 Forbidden", wrong);
    }
    else if (is_post && strcmp(path, "/do") == 0)
    {
        if (take_words(body, words))
        {
            run_command(server, client, words);
        }
        else
        {
            refuse(client, "400 Bad Request", "no command of the page");
        }
    }
    else if (strcmp(method, "GET") == 0)
    {
        serve_get(server, client, path);
    }
    else
    {
        refuse(client, "405 Method Not Allowed", "GET is expected, or POST /do");
    }
}

static void read_request(const server_t *server, client_t *client)
{
    const ssize_t count =
        recv(client->fd, client->request + client->length, REQUEST_MAX - client->length, MSG_DONTWAIT);
    if (count <= 0)
    {
        if (count == 0 || errno != EAGAIN)
        {
            forget(client);
        }
        return;
    }
    if (client->has_events || client->command != 0)
    {
        return; // it has said all
    }
    client->length += (size_t)count;
    client->request[client->length] = '\0';
    char *end                       = strstr(client->request, "\r\n\r\n");
    char  size[256];
    if (end != NULL)
    {
        find_header(client->request, "Content-Length", size);
        const size_t wanted = (size_t)strtoul(size, NULL, 10);
        const size_t there  = client->length - (size_t)(end + 4 - client->request);
        if (wanted > REQUEST_MAX || strlen(client->request) != client->length)
        {
            refuse(client, "400 Bad Request", "too long, or a zero byte");
            return;
        }
        if (there >= wanted)
        {
            end[4 + wanted] = '\0';
            serve_request(server, client, end + 4);
            return;
        }
    }
    if (client->length == REQUEST_MAX)
    {
        refuse(client, "413 Content Too Large", "a request is at most 8 KB");
    }
}

// --- the loop ------------------------------------------------------------------------------------------------------

static volatile sig_atomic_t is_over;

static void end_serving(int signal_number)
{
    (void)signal_number;
    is_over = 1;
}

static void take_client(server_t *server)
{
    const int fd = accept4(server->listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    int       i  = 0;
    while (i < CLIENTS_MAX && server->clients[i].fd >= 0)
    {
        i++;
    }
    if (fd >= 0 && i < CLIENTS_MAX)
    {
        server->clients[i] = (client_t){.fd = fd, .since_s = now_s()};
    }
    else if (fd >= 0)
    {
        (void)close(fd);
    }
}

/// Requests and commands, until it is time for a sample.
static void attend(server_t *server, double until_s)
{
    while (is_over == 0)
    {
        struct pollfd events[1 + 2 * CLIENTS_MAX];
        const double  left_s = until_s - now_s();
        events[0]            = (struct pollfd){.fd = server->listener, .events = POLLIN};
        for (int i = 0; i < CLIENTS_MAX; i++)
        {
            client_t  *client = &server->clients[i];
            const bool is_old =
                client->fd >= 0 && !client->has_events && client->command == 0 && now_s() - client->since_s > IDLE_S;
            if (is_old)
            {
                forget(client);
            }
            events[1 + 2 * i] = (struct pollfd){.fd = client->fd, .events = POLLIN};
            events[2 + 2 * i] = (struct pollfd){.fd = client->command != 0 ? client->output : -1, .events = POLLIN};
        }
        if (left_s <= 0.0 || poll(events, 1 + 2 * CLIENTS_MAX, (int)ceil(1e3 * left_s)) < 0)
        {
            return;
        }
        for (int i = 0; i < CLIENTS_MAX; i++)
        {
            client_t *client = &server->clients[i];
            if (events[2 + 2 * i].revents != 0)
            {
                read_command(client);
            }
            else if (client->fd >= 0 && events[1 + 2 * i].revents != 0)
            {
                read_request(server, client);
            }
        }
        if (events[0].revents != 0)
        {
            take_client(server);
        }
    }
}

/// To whoever listens; who does not keep up is left.
static void send_events(server_t *server, const char *text, size_t length)
{
    static const char head[] = "data: ";
    char              event[STATUS_SAMPLE_MAX + sizeof head];
    const size_t size = sizeof head - 1u + length + 1u; // the sample ends with a line's end, the event with one more
    memcpy(event, head, sizeof head - 1u);
    memcpy(event + sizeof head - 1u, text, length);
    event[size - 1u] = '\n';
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        client_t *client = &server->clients[i];
        if (client->fd >= 0 && client->has_events &&
            send(client->fd, event, size, MSG_NOSIGNAL | MSG_DONTWAIT) != (ssize_t)size)
        {
            forget(client);
        }
    }
}

static bool has_listeners(const server_t *server)
{
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        if (server->clients[i].fd >= 0 && server->clients[i].has_events)
        {
            return true;
        }
    }
    return false;
}

/// The bus is not held but for a sample.
static bool sample_and_attend(server_t *server)
{
    double next_s = now_s();
    link_bus_release(server->bus);
    while (is_over == 0)
    {
        if (has_listeners(server))
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
        next_s = fmax(next_s + 1.0 / server->options->rate_hz, now_s());
        attend(server, next_s);
    }
    return true;
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
    struct sockaddr_in6 bound = {.sin6_port = 0};
    socklen_t           size  = sizeof bound;
    if (server->listener < 0 || bind(server->listener, found->ai_addr, found->ai_addrlen) != 0 ||
        listen(server->listener, 16) != 0 || getsockname(server->listener, (struct sockaddr *)&bound, &size) != 0)
    {
        return link_complain("serve: --listen %s: %s", listen_on, strerror(errno));
    }
    server->port = ntohs(bound.sin6_port); // where sin_port is, too
    return true;
}

static bool open_listener(server_t *server)
{
    char                  host[256];
    struct addrinfo      *found  = NULL;
    const char           *text   = server->options->listen;
    const char           *colon  = strrchr(text, ':');
    const struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE};
    if (colon == NULL || (size_t)(colon - text) >= sizeof host)
    {
        return link_complain("serve: --listen %s: HOST:PORT is expected", text);
    }
    const bool is_in_brackets = text[0] == '[' && colon > text && colon[-1] == ']';
    (void)snprintf(host, sizeof host, "%.*s", (int)(colon - text) - 2 * is_in_brackets, text + is_in_brackets);
    if (getaddrinfo(host, colon + 1, &wanted, &found) != 0)
    {
        return link_complain("serve: --listen %s: there is no such address", text);
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
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        server.clients[i].fd = -1;
    }
    if (!make_token(&server) || !open_listener(&server))
    {
        return false;
    }
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)printf("http://%s:%d/   Ctrl-C ends it, not the drive\n",
                 options->allow != NULL ? options->allow : "127.0.0.1",
                 server.port);
    (void)fflush(stdout);
    const bool ok = sample_and_attend(&server);
    for (int i = 0; i < CLIENTS_MAX; i++)
    {
        if (server.clients[i].fd >= 0)
        {
            forget(&server.clients[i]);
        }
    }
    (void)close(server.listener);
    return ok;
}
