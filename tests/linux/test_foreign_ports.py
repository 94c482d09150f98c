"""tribo-link where no drive answers: other services, answers that are none, addresses that cannot be. It ends, and says what is wrong."""

import contextlib
import os
import pty
import socket
import struct
import subprocess
import termios
import threading
import time

import pytest

from conftest import LINK

PATIENCE_S = 60  # for a loaded machine; what never ends takes longer


def link(*arguments, **environment):
    done = subprocess.run([LINK, *arguments], capture_output=True, text=True, timeout=PATIENCE_S, check=False, stdin=subprocess.DEVNULL,
                          env={**os.environ, **environment})
    return done.returncode, done.stderr


def send_slowly(client, text, pause_s=0.3):
    for byte in text:
        client.sendall(bytes([byte]))
        time.sleep(pause_s)


def answer(request, number=0, protocol=0, unit=1, words=b"\0\0\0\x08"):
    return struct.pack(">HHHBBB", (struct.unpack(">H", request[:2])[0] + number) % 65536, protocol, 3 + len(words), unit, 3, len(words)) + words


def ssh(client):
    client.sendall(b"SSH-2.0-OpenSSH_9.2p1 Debian-2\r\n")
    client.recv(1)
    client.recv(300)
    time.sleep(PATIENCE_S)


def http(client):
    client.recv(300)
    client.sendall(b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n")


def echo(client):
    while data := client.recv(300):
        client.sendall(data)


def closes(client):
    pass


def closes_late(client):
    client.recv(300)
    time.sleep(1)


def resets(client):
    client.recv(300)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def is_silent(client):
    time.sleep(PATIENCE_S)


def half_a_frame(client):
    client.sendall(answer(client.recv(300))[:9])
    time.sleep(PATIENCE_S)


def half_a_frame_and_close(client):
    client.sendall(answer(client.recv(300))[:9])


def a_byte_at_a_time(client):
    send_slowly(client, answer(client.recv(300), words=bytes(250)))


def without_end(client):
    while True:
        client.sendall(bytes(65536))


def frames_without_end(client):
    frame = answer(client.recv(300), number=7) * 200
    while True:
        client.sendall(frame)


def another_transaction(client):
    while request := client.recv(300):
        client.sendall(answer(request, number=1))


def another_protocol(client):
    while request := client.recv(300):
        client.sendall(answer(request, protocol=1))


def another_unit(client):
    while request := client.recv(300):
        client.sendall(answer(request, unit=2))


def too_much(client):
    while request := client.recv(300):
        client.sendall(answer(request, words=bytes(8)))


def the_version_and_no_more(client):
    client.sendall(answer(client.recv(300)))
    time.sleep(PATIENCE_S)


def the_version_and_dribbles(client):
    client.sendall(answer(client.recv(300)))
    send_slowly(client, answer(client.recv(300), words=bytes(250)))


def another_device(client):
    """That is Modbus, and no drive."""
    while request := client.recv(300):
        client.sendall(answer(request, words=bytes(2 * struct.unpack(">H", request[10:12])[0])))


@contextlib.contextmanager
def listening(kind, family=socket.AF_INET, address="127.0.0.1"):
    listener = socket.socket(family)
    listener.bind((address, 0))
    listener.listen(16)

    def serve(client):
        with client, contextlib.suppress(OSError):
            kind(client)

    def accept():
        with contextlib.suppress(OSError):
            while True:
                threading.Thread(target=serve, args=[listener.accept()[0]], daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    yield listener.getsockname()[1]
    listener.shutdown(socket.SHUT_RDWR)
    listener.close()


FOREIGN = [ssh, http, echo, closes, closes_late, resets, is_silent, half_a_frame, half_a_frame_and_close, a_byte_at_a_time, without_end, frames_without_end,
           another_transaction, another_protocol, another_unit, too_much, the_version_and_no_more, the_version_and_dribbles]


@pytest.mark.parametrize("kind", FOREIGN, ids=lambda kind: kind.__name__)
def test_it_ends_where_another_service_answers(kind):
    with listening(kind) as port:
        status, said = link("-d", f"tcp:127.0.0.1:{port}", "status")
    assert status == 2 and said.startswith(f"tribo-link: tcp:127.0.0.1:{port}: no answer from unit 1"), said
    assert len(said.splitlines()) == 1


def test_the_words_say_who_answers():
    with listening(ssh) as port:
        assert "the answer is not Modbus" in link("-d", f"tcp:127.0.0.1:{port}")[1]
    with listening(another_unit) as port:
        assert "no answer from unit 1: unit 2 answers" in link("-d", f"tcp:127.0.0.1:{port}")[1]
    with listening(another_device) as port:
        assert "has registers of version 0" in link("-d", f"tcp:127.0.0.1:{port}")[1]


def test_a_drive_that_missed_its_turn_is_queried_again():
    clients = []

    def busy_at_first(client):
        clients.append(client)
        if len(clients) > 1:
            another_device(client)
        else:
            is_silent(client)

    with listening(busy_at_first) as port:
        assert "has registers of version 0" in link("-d", f"tcp:127.0.0.1:{port}")[1]


@pytest.mark.parametrize(("address", "wrong"), [
    ("127.0.0.1:99999", "port: value 99999: 1 to 65535"),
    ("127.0.0.1:65536", "port: value 65536: 1 to 65535"),
    ("127.0.0.1:18446744073709551617", "port: value 18446744073709551617: 1 to 65535"),
    ("127.0.0.1:0", "port: value 0: 1 to 65535"),
    ("127.0.0.1:-1", "port: value -1: 1 to 65535"),
    ("127.0.0.1:+1502", "port: value +1502: 1 to 65535"),
    ("127.0.0.1: 1502", "port: value  1502: 1 to 65535"),
    ("127.0.0.1:1502x", "port: value 1502x: 1 to 65535"),
    ("127.0.0.1:mbap", "port: value mbap: 1 to 65535"),
    ("127.0.0.1:", 'port: value "": 1 to 65535'),
    ("[::1]:", 'port: value "": 1 to 65535'),
    ("[::1]:99999", "port: value 99999: 1 to 65535"),
    ("no-such-host.invalid", "host unknown: no-such-host.invalid"),
    ("no-such-host.invalid:1502", "host unknown: no-such-host.invalid"),
    ("256.256.256.256", "host unknown: 256.256.256.256"),
    ("a host", "host unknown: a host"),
    ("[fe80::1%nosuchline]:1502", "host unknown: fe80::1%nosuchline"),
    ("", "host: empty"),
    (":1502", "host: empty"),
    ("[]:1502", "host: empty"),
    ("h" * 300, "host: too long"),
    ("::1", "an IPv6 address is expected in brackets"),
    ("::1:1502", "an IPv6 address is expected in brackets"),
    ("[::1", "[HOST]:PORT is expected"),
    ("[::1]1502", "[HOST]:PORT is expected"),
    ("127.0.0.1:1502:1502", "an IPv6 address is expected in brackets"),
])
def test_an_address_is_checked_by_its_parts(address, wrong):
    status, said = link("-d", f"tcp:{address}", "status")
    assert status == 2 and said.startswith(f"tribo-link: tcp:{address}: {wrong}"), said


def test_a_missing_port_is_refused_by_the_operating_system():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        device = f"tcp:127.0.0.1:{free.getsockname()[1]}"
    assert link("-d", device, "status") == (2, f"tribo-link: {device}: Connection refused\n")


def relay_to(port):
    def relay(client):
        with socket.create_connection(("127.0.0.1", port)) as drive:
            def back():
                with contextlib.suppress(OSError):
                    while data := drive.recv(4096):
                        client.sendall(data)
                    client.shutdown(socket.SHUT_RDWR)
            threading.Thread(target=back, daemon=True).start()
            while data := client.recv(4096):
                drive.sendall(data)
            drive.shutdown(socket.SHUT_RDWR)  # a close alone would wait for the thread
    return relay


@pytest.mark.skipif(not socket.has_ipv6, reason="this machine has no IPv6")
@pytest.mark.parametrize("host", ["[::1]", "[0:0:0:0:0:0:0:1]"])
def test_an_ipv6_address_is_reached(demo, host):
    with listening(relay_to(int(demo.tcp.split(":")[-1])), socket.AF_INET6, "::1") as port:
        assert link("-d", f"tcp:{host}:{port}", "status") == (0, "")
    with listening(relay_to(int(demo.tcp.split(":")[-1]))) as port:
        assert link("-d", f"tcp:[127.0.0.1]:{port}", "status") == (0, "")
        assert link("-d", f"tcp:localhost:{port}", "status") == (0, "")


@pytest.mark.parametrize(("address", "wrong"), [
    ("127.0.0.1:99999", "port: value 99999"), ("127.0.0.1:", 'port: value ""'), ("127.0.0.1:80x", "port: value 80x"), ("127.0.0.1", "HOST:PORT is expected"),
    ("::1:80", "an IPv6 address is expected in brackets"), ("no-such-host.invalid:80", "host unknown: no-such-host.invalid"), ("[::1", "[HOST]:PORT is expected"), (":80", "host: empty"),
])
def test_addresses_of_watch_and_serve_are_checked_likewise(demo, address, wrong):
    for words in (["watch", "--udp", address], ["watch", "--teleplot", address], ["serve", "--listen", address]):
        status, said = link("-d", demo.tcp, *words)
        assert status == 2 and said.startswith(f"tribo-link: {words[0]}: {words[1]} {address}: {wrong}"), said


def test_serve_prints_the_address_that_it_listens_on(demo):
    for listen, printed in (("127.0.0.2:0", "http://127.0.0.2:"), ("[::1]:0", "http://[::1]:"), ("localhost:0", "http://")):
        with subprocess.Popen([LINK, "-d", demo.tcp, "serve", "--listen", listen], stdout=subprocess.PIPE, text=True) as served:
            url = served.stdout.readline().split()[0]
            assert url.startswith(printed)
            done = subprocess.run(["curl", "-sg", "-o", "/dev/null", "-w", "%{http_code}", url], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
            served.terminate()
        assert done.stdout == "200"


def test_a_device_is_a_serial_line(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    for device, wrong in ((tmp_path, "is a folder, not a serial line"), (file, "is another file, not a serial line"),
                          ("/dev/null", "is another file, not a serial line"), (tmp_path / "none", "No such file or directory; a line is a file in /dev"),
                          ("127.0.0.1:1502", "a network tcp:HOST[:PORT]")):
        status, said = link("-d", str(device), "status")
        assert status == 2 and said.startswith(f"tribo-link: {device}: ") and wrong in said, said
    assert "--device is empty" in link("-d", "", "status")[1]


@pytest.mark.parametrize("baud", ["123456", "0", "-1", "9600x", "", "4000001", "1e5"])
def test_an_unsupported_baud_rate_is_refused(baud):
    """libmodbus takes 9600 for what it does not know."""
    status, said = link("-d", "/dev/null", "--baud", baud)
    assert status == 2 and f"--baud {baud}: one of 1200, 2400, 4800, 9600, " in said and "/dev/null" not in said


@pytest.mark.parametrize("unit", ["0", "248", "-1", "1.5", "x", ""])
def test_a_unit_is_one_of_modbus(unit):
    status, said = link("-d", "/dev/null", "-u", unit)
    assert status == 2 and f"--unit {unit}: a whole number from 1 to 247 is expected" in said


@pytest.mark.parametrize("text", [bytes(range(256)) * 10, b"\x01\x03\xf0" + bytes(300), b"$GPGGA,123519\r\n" * 40], ids=["bytes", "frame", "gps"])
def test_it_ends_on_a_line_that_dribbles(text):
    """Another device that sends a byte now and then."""
    master, slave = pty.openpty()
    attributes = termios.tcgetattr(slave)
    attributes[0] = attributes[1] = attributes[3] = 0
    termios.tcsetattr(slave, termios.TCSANOW, attributes)
    is_over = threading.Event()

    def dribble():
        for byte in text * 10:
            with contextlib.suppress(OSError):
                os.write(master, bytes([byte]))
            if is_over.wait(0.3):
                return

    thread = threading.Thread(target=dribble, daemon=True)
    thread.start()
    status, said = link("-d", os.ttyname(slave), "status")
    is_over.set()
    thread.join(timeout=300)
    os.close(master)
    os.close(slave)
    assert status == 2 and "unit 1" in said, said


def test_an_empty_variable_counts_as_unset():
    assert "no drive answers as unit 1" in link("status", TRIBO_LINK_DEVICE="")[1] or link("ports")[0] == 0


@pytest.mark.parametrize("out", ["folder", "none/trace.csv"])
def test_a_trace_that_cannot_be_written_says_why(demo, tmp_path, out):
    (tmp_path / "folder").mkdir()
    status, said = link("-d", demo.tcp, "trace", "--wait", "0.1", "-o", str(tmp_path / out))
    assert status == 2 and str(tmp_path / out) in said and ("folder" in said or "directory" in said.lower())
