"""A headless Chromium under the DevTools protocol, over two pipes: no driver, no socket, no library."""

import base64
import itertools
import json
import os
import select
import shutil
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import pytest
from torquebench import run
from torquebench.reporting import report
from torquebench.scenarios.result import REFUSED, RunResult
from torquebench.scenarios.store import Store

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
PATIENCE = 60.0
"""Time after which a browser that says nothing is taken for dead [s]."""


class Tab:
    """A page in the browser, with all that it asked for and complained about."""

    def __init__(self, binary: str, profile: Path) -> None:
        ours_out, theirs_in = os.pipe()
        theirs_out, ours_in = os.pipe()

        def wire() -> None:
            # The browser reads commands on 3 and answers on 4; the ends are moved away first, lest one hide the other.
            moved_in, moved_out = (os.dup(end) for end in (theirs_out, theirs_in))
            os.dup2(moved_in, 3)
            os.dup2(moved_out, 4)

        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
        flags += ["--remote-debugging-pipe", f"--user-data-dir={profile}", "--disable-background-networking"]
        # Whatever a page asks of the network fails here as it would on the train.
        flags += ["--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1280,900", "about:blank"]
        self.process = subprocess.Popen(
            [binary, *flags], preexec_fn=wire, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(theirs_out)
        os.close(theirs_in)
        self._in, self._out, self._buffer = ours_in, ours_out, b""
        self._numbers, self._session = itertools.count(1), None
        self.requests, self.complaints = [], []
        targets = self.call("Target.getTargets")["targetInfos"]
        target = next(item["targetId"] for item in targets if item["type"] == "page")
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: object) -> dict:
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._in, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
            self._note(answer)

    def open(self, page: Path, fragment: str = "") -> "Tab":
        self.requests.clear()
        self.complaints.clear()
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=page.resolve().as_uri() + fragment)
        self.wait("document.readyState === 'complete' && location.protocol === 'file:'")
        return self

    def run(self, script: str) -> object:
        """Return the value of an expression in the page; a promise is waited for."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def wait(self, condition: str) -> None:
        """Wait until an expression is true."""
        until = time.monotonic() + PATIENCE
        while not self.run(f"Boolean({condition})"):
            assert time.monotonic() < until, f"never true: {condition}"
            time.sleep(0.02)

    def press(self, key: str, code: int = 0, text: str = "") -> None:
        key_codes = {"key": key, "windowsVirtualKeyCode": code, "text": text}
        self.call("Input.dispatchKeyEvent", type="keyDown", **key_codes)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)

    def emulate(self, width: int = 1280, height: int = 900, media: str = "", **features: str) -> None:
        """Give the page a size, a medium and media features, ``prefers_color_scheme="dark"``."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600
        )
        wanted = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.call("Emulation.setEmulatedMedia", media=media, features=wanted)

    def picture(self, file: Path, *, whole: bool = False) -> None:
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        file.write_bytes(base64.b64decode(data))

    def pdf(self) -> bytes:
        return base64.b64decode(self.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"])

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._in)
        os.close(self._out)

    def _note(self, event: dict) -> None:
        method, told = event.get("method", ""), event.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(told["exceptionDetails"])[:400])
        elif method == "Runtime.consoleAPICalled":
            self.complaints.append(json.dumps(told["args"])[:400])
        elif method == "Log.entryAdded":
            self.complaints.append(told["entry"]["text"])

    def _read(self) -> dict:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._out], [], [], PATIENCE)
            assert ready, "the browser says nothing"
            read = os.read(self._out, 1 << 20)
            assert read, "the browser is gone"
            self._buffer += read
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)


@pytest.fixture(scope="session")
def tab(tmp_path_factory):
    """A tab of a browser that has no network."""
    binary = next((path for name in NAMES if (path := shutil.which(name))), None)
    if binary is None:
        pytest.skip(f"no browser on this machine: none of {', '.join(NAMES)} is installed")
    opened = Tab(binary, tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


HOSTILE = [
    "<script>document.title='owned'</script>",
    "\"'><img src=x onerror=document.title='owned'>",
    "\u202eرجل\u2066 آلي",
    "n" * 90,
]
"""Controllers with names that would like to be more than names."""


@pytest.fixture(scope="session")
def campaign(tmp_path_factory):
    """A small campaign: two controllers on two motions, one of them repeated, and copies under hostile names."""
    folder = tmp_path_factory.mktemp("campaign") / "store"
    changes = ['trajectories=["T1", "T6"]', "loads=[{mass = 1.5}]", "laps=1", 'knowledge=["none"]', "tier=actuated"]
    run("quick", out=folder, controllers=["flexiv_factory", "computed_torque"], changes=changes, workers=1)
    with Store.read(folder) as store:
        made = [(found, store._trace_bytes(found.trace)) for found in store.runs()]
    with Store.write(folder) as store:
        for found, trace in made:
            same = found.specification
            copies = [replace(same, controller=name) for name in HOSTILE]
            if same.controller == "computed_torque":
                copies += [replace(same, repetition=number) for number in range(1, 7)]
            for copy in copies:
                store.put(
                    copy.address("copied"), copy, [replace(found.result, trace=trace, repetition=copy.repetition)]
                )
        refused = replace(made[0][0].specification, controller="mpc")
        reason = "</script><script>document.title='owned'</script>"
        store.put(refused.address("copied"), refused, [RunResult(role="run", status=REFUSED, cause="x", reason=reason)])
    return report(folder)
