"""tribo-link serve among clients that mean harm: pages of other sites, connections that say nothing, bytes that come one by one. Beside
them a host renews its reference, and the page keeps its stop."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

from conftest import CLOCK_RIG, free_port, until
from test_serve import ROOT, STRANGERS, Served, posted, raw

sys.path.insert(0, str(ROOT / "tests/browser"))
import chromium  # noqa: E402

LINK = os.environ["TRIBO_LINK"]
REFERENCE_MS = 3000  # beyond what a loaded machine takes from a host


class TcpDrive:
    """tribo-desk on TCP, whose reference a host renews."""

    def __init__(self, drive):
        self.port = free_port()
        self.tcp = f"tcp:127.0.0.1:{self.port}"
        drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{listen: 127.0.0.1, port: {self.port}}}\ndrive: {{reference_ms: {REFERENCE_MS}}}\n")
        self.process, _ = drive.begin()
        self.link("start")
        self.host = subprocess.Popen([LINK, "-d", self.tcp, "reference", "0.2"], stderr=subprocess.DEVNULL)
        until(lambda: self.status()["r_N"] > 0.1, "it does not renew")

    def link(self, *arguments):
        done = subprocess.run([LINK, "-d", self.tcp, *arguments], capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def status(self):
        return json.loads(self.link("status", "--json"))

    def goes_on(self, ticks):
        """For so many ticks, with the host's reference."""
        end = self.status()["tick"] + ticks
        until(lambda: self.status()["tick"] >= end, "it does not tick")
        now = self.status()
        assert (now["state_text"], now["fault"], self.host.poll()) == ("run", 0, None)

    def end(self):
        for process in (self.host, self.process):
            process.terminate()
            process.wait(timeout=300)


@pytest.fixture
def rig(drive):
    made = TcpDrive(drive)
    yield made
    made.end()


@pytest.fixture
def page(rig):
    made = Served(rig)
    yield made
    made.process.send_signal(signal.SIGINT)
    assert made.process.wait(timeout=300) == 0


@contextlib.contextmanager
def attack(*kinds):
    """Each kind is called again and again, in a thread of its own."""
    is_over = threading.Event()

    def repeat(kind):
        while not is_over.is_set():
            with contextlib.suppress(OSError):
                kind(is_over)
            is_over.wait(0.01)

    threads = [threading.Thread(target=repeat, args=[kind], daemon=True) for kind in kinds]
    for thread in threads:
        thread.start()
    yield
    is_over.set()
    for thread in threads:
        thread.join(timeout=300)


def image(page, path="/values"):
    """What a browser sends for an <img> of another site."""
    def kind(_):
        with raw(page, f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\nSec-Fetch-Site: cross-site\r\n\r\n".encode()) as link:
            said = link.recv(100)
            assert not said or said.split()[1] == b"403"
    return kind


def idle(page, text=b"", count=80):
    """So many connections that say no more than this, again as soon as they are closed."""
    def kind(is_over):
        with contextlib.ExitStack() as stack:
            links = [stack.enter_context(raw(page, text)) for _ in range(count)]
            for link in links:
                link.settimeout(0.1)
            while not is_over.is_set():
                for link in links:
                    with contextlib.suppress(TimeoutError):
                        if not link.recv(4096):
                            return
                    if is_over.is_set():
                        return
    return kind


def dribble(page, text):
    """A byte now and then."""
    def kind(is_over):
        with raw(page, b"") as link:
            for byte in text:
                link.sendall(bytes([byte]))
                if is_over.wait(0.2):
                    return
    return kind


def strangers(page):
    head = f"POST /do HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\n".encode()
    return [*[image(page)] * 6, image(page, "/events"), image(page, "/"), idle(page), idle(page, head), *[dribble(page, head * 50)] * 8,
            idle(page, head + b"Content-Length: 1000\r\n\r\nsta")]


def test_clients_without_token_start_no_command_and_the_reference_goes_on(rig, page):
    seen = []
    with attack(*strangers(page)):
        end = rig.status()["tick"] + 2 * REFERENCE_MS
        while rig.status()["tick"] < end:
            seen.append(page.commands())
        rig.goes_on(1)
        assert max(seen) == 0
        assert page.do("stop") == (200, "")
    assert page.state() == "idle"


def test_the_page_keeps_its_connections_among_clients_without_token(rig, page):
    with attack(*strangers(page)):
        for _ in range(5):
            assert page.ask("GET", "/list")[0] == 200 and page.ask("GET", "/values")[0] == 200
        assert page.do("params", "set", "compensator.gain=0.8")[0] == 200
        with raw(page, f"{page.head('GET', '/events')}\r\n".encode()) as events:
            said = b""
            while said.count(b"data: ") < 20:
                said += events.recv(4096)
    rig.goes_on(1)


@pytest.mark.parametrize("text", ["", "GET / HTTP/1.1\r\nHost: x\r\n"])
def test_who_dribbles_its_headers_is_hung_up_on(page, text):
    """Bytes keep coming, so the limit of an idle connection alone would never end it."""
    begin = time.monotonic()
    with raw(page, text.encode()) as link, contextlib.suppress(ConnectionError):
        link.settimeout(0.2)
        while time.monotonic() - begin < 200:
            with contextlib.suppress(TimeoutError):
                if not link.recv(100):
                    break
            link.sendall(b"a" if text else b"")
    assert time.monotonic() - begin < 200


def test_who_dribbles_its_body_is_hung_up_on(rig, page):
    begin = time.monotonic()
    with raw(page, posted(page, "start", 8000)) as link, contextlib.suppress(ConnectionError):
        link.settimeout(0.2)
        while time.monotonic() - begin < 200:
            with contextlib.suppress(TimeoutError):
                if not link.recv(100):
                    break
            link.sendall(b"a")
    assert time.monotonic() - begin < 200
    rig.goes_on(1)


def test_the_body_of_a_request_without_token_is_not_read(page):
    for headers in STRANGERS:
        lines = {"Host": f"127.0.0.1:{page.port}", "X-Tribo-Token": page.token} | {name.replace("_", "-"): value for name, value in headers.items()}
        head = "".join(f"{name}: {value}\r\n" for name, value in lines.items() if value is not None)
        with raw(page, f"POST /do HTTP/1.1\r\n{head}Content-Length: 8000\r\n\r\n".encode()) as link:
            assert link.recv(100).split()[1] == b"403"


def trace(page):
    return raw(page, posted(page, "trace\n--trigger=rise\n--watch=F_N\n--level=1000\n--wait=200"))


def test_commands_come_one_at_a_time(rig, page):
    """This holds for the page's own requests, too. A trace may wait next to them, because they do what it waits for."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(trace(page))
        until(lambda: page.commands() == 1, "no trace")
        asked = [stack.enter_context(raw(page, f"{page.head('GET', '/values')}\r\n".encode())) for _ in range(8)]
        most, answers = 0, []
        while len(answers) < len(asked):
            most = max(most, page.commands())
            with contextlib.suppress(TimeoutError):
                asked[len(answers)].settimeout(0.002)
                answers.append(asked[len(answers)].recv(100).split()[1])
        assert set(answers) == {b"200"} and most == 2
        assert page.do("trace") == (409, "a trace is being recorded: one at a time")
        rig.goes_on(1)


def taken(rig):
    """A client that has the drive's one place: commands wait for it."""
    while True:
        other = socket.create_connection(("127.0.0.1", rig.port))
        other.sendall(bytes.fromhex("000100000006010300000002"))
        if other.recv(100)[7:8] == b"\3":  # otherwise another client has it
            return other
        other.close()


def test_a_stop_ends_what_works_and_what_waits_but_a_trace(rig, page):
    rig.host.terminate()
    rig.host.wait(timeout=300)
    with contextlib.ExitStack() as stack:
        stack.enter_context(trace(page))
        until(lambda: page.commands() == 1, "no trace")
        with taken(rig):
            waiting = [stack.enter_context(raw(page, posted(page, "params\nset\ncompensator.gain=0.7")))]
            until(lambda: page.commands() == 2, "no command")
            waiting += [stack.enter_context(raw(page, posted(page, "start"))) for _ in range(4)]
            stop = stack.enter_context(raw(page, posted(page, "stop")))
            for link in waiting:
                said = link.recv(4096)
                assert said.split()[1] == b"409" and said.endswith(b"ended by a stop")
        assert stop.recv(100).split()[1] == b"200"
        assert page.state() == "idle" and page.commands() == 1


def test_commands_that_wait_are_few(rig, page):
    with contextlib.ExitStack() as stack:
        stack.enter_context(taken(rig))
        links = [stack.enter_context(raw(page, f"{page.head('GET', '/values')}\r\n".encode())) for _ in range(12)]
        refused = [link.recv(4096) for link in links[9:]]
        assert all(said.split()[1] == b"503" and said.endswith(b"too many commands wait") for said in refused)
    until(lambda: page.commands() == 0, "commands of clients that have left")


def test_who_leaves_does_not_wait(rig, page):
    with taken(rig):
        with raw(page, f"{page.head('GET', '/values')}\r\n".encode()), raw(page, posted(page, "params\nset\ncompensator.gain=0.7")):
            until(lambda: page.commands() == 1, "no command")
    until(lambda: page.commands() == 0, "it works on")
    assert "0.7" not in rig.link("params", "get", "compensator.gain")  # not set by who has left


@pytest.mark.skipif(chromium.PROGRAM is None, reason="needs chromium")
def test_a_page_of_another_site_in_a_browser(rig, page, tmp_path):
    """A foreign page, such as an issue tracker, holds pictures, scripts, frames, sockets and forms of this server."""
    address = f"http://127.0.0.1:{page.port}"
    hostile = tmp_path / "hostile.html"
    hostile.write_text(f"""<body><script>let count = 0;
const again = () => {{ for (const path of ["values", "values", "values", "values", "values", "values", "events", "list", ""]) {{
    const image = new Image(); image.onload = image.onerror = () => {{ count++; }}; image.src = "{address}/" + path + "?" + Math.random(); }} }};
setInterval(again, 50);
new EventSource("{address}/events"); new WebSocket("{address.replace('http', 'ws')}/do");
for (const mode of ["no-cors", "cors"]) fetch("{address}/values", {{mode}}).catch(() => 0);
</script><script src="{address}/values"></script><link rel="stylesheet" href="{address}/values"><iframe src="{address}/"></iframe></body>""", encoding="utf-8")
    with chromium.chromium() as new_page:
        own = new_page()
        own.open(page.url)
        own.wait("Number(document.body.dataset.samples) > 3 && Number(document.body.dataset.params) > 100")
        other = new_page()
        other.ask("Page.navigate", url=hostile.as_uri())  # a page that loads for ever is never complete
        other.wait("typeof count !== 'undefined' && count > 100")
        rig.goes_on(REFERENCE_MS)
        assert page.commands() == 0
        own.evaluate("document.getElementById('stop').click()")
        until(lambda: rig.status()["state_text"] == "idle", "no stop")


@pytest.mark.skipif(chromium.PROGRAM is None, reason="needs chromium")
def test_pages_that_nobody_sees_leave_the_stop_a_connection(rig, page):
    """A browser has six to a server, and each page that listens keeps one."""
    with chromium.chromium() as new_page:
        pages = [new_page() for _ in range(7)]
        for one in pages:
            one.open(page.url)
            one.wait("document.getElementById('said') !== null")
            if one is not pages[-1]:
                one.evaluate("Object.defineProperty(document, 'hidden', {value: true}); document.dispatchEvent(new Event('visibilitychange'))")
        pages[-1].wait("Number(document.body.dataset.samples) > 3")
        pages[-1].evaluate("document.getElementById('stop').click()")
        until(lambda: rig.status()["state_text"] == "idle", "no stop")
