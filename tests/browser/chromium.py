"""Chromium without a window, steered over its debugging pipe: null-terminated JSON on descriptors 3 and 4. No package is needed."""

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

PROGRAM = shutil.which("chromium")
ARGUMENTS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", "--no-first-run", "--remote-debugging-pipe"]
PATIENCE_S = 300.0  # for what never happens: a loaded machine takes a minute for a page


class Page:
    def __init__(self, ask, session):
        self._ask, self._session = ask, session

    def ask(self, method, **parameters):
        return self._ask(method, parameters, self._session)

    def open(self, url):
        self.ask("Page.navigate", url=url)
        self.wait("document.readyState === 'complete' && location.href !== 'about:blank'")

    def evaluate(self, expression):
        """The value of an expression, or of the promise that it is."""
        answer = self.ask("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise AssertionError(answer["exceptionDetails"].get("exception", {}).get("description", answer["exceptionDetails"]))
        return answer["result"].get("value")

    def wait(self, expression):
        """Waits until the expression is true, and returns its value."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            value = self.evaluate(expression)
            if value:
                return value
            time.sleep(0.05)
        raise AssertionError(f"not true within {PATIENCE_S:g} s: {expression}; the page says: {self.evaluate('document.body.innerText')[:2000]}")

    def press(self, key, code):
        for kind in ("keyDown", "keyUp"):
            self.ask("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def resize(self, width, height):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)

    def picture(self, path):
        path.write_bytes(base64.b64decode(self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]))


def _connect(to_child, from_child):
    count, rest = 0, b""

    def ask(method, parameters, session=None):
        nonlocal count, rest
        count += 1
        message = {"id": count, "method": method, "params": parameters} | ({"sessionId": session} if session else {})
        os.write(to_child, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE_S
        while True:
            while b"\0" not in rest:
                if not select.select([from_child], [], [], max(end - time.monotonic(), 0.0))[0]:
                    raise AssertionError(f"chromium does not answer {method}")
                part = os.read(from_child, 1 << 20)
                assert part, "chromium has ended"
                rest += part
            one, rest = rest.split(b"\0", 1)
            answer = json.loads(one)
            if answer.get("id") == count:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    return ask


@contextlib.contextmanager
def chromium():
    """A function that opens an empty page."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        their_in, our_out = os.pipe()
        our_in, their_out = os.pipe()

        def wire():
            kept = [os.dup(their_in), os.dup(their_out)]  # neither is 3 or 4 by now, or both are safe to overwrite
            os.dup2(kept[0], 3)
            os.dup2(kept[1], 4)

        child = subprocess.Popen(
            [PROGRAM, *ARGUMENTS, f"--user-data-dir={profile}"],
            preexec_fn=wire, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        os.close(their_in)
        os.close(their_out)
        ask = _connect(our_out, our_in)

        def page():
            target = ask("Target.createTarget", {"url": "about:blank"})["targetId"]
            session = ask("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
            return Page(ask, session)

        try:
            yield page
        finally:
            child.kill()
            child.wait()
            os.close(our_out)
            os.close(our_in)
