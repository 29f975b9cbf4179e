"""Measure the live page: the e-stop, a closed page, the cost of viewers, the delay of pictures, and the page's size.

    python -m benchmarks.live_page

- The e-stop: Chromium presses the space bar of the page. The delay ends when the calls that stop the motors return.
- A closed page: a viewer drives, and its connection ends, or it falls silent. The delay ends with the tick that stops
  the wheels.
- Viewers: the time of a tick without its sleep, without a page and with 0, 1 and 4 viewers in another process. It is
  the sum of the medians of the phases. The runs are made in turns, and the table has the median of the rounds.
- Pictures: an app draws the time into each picture, 320 x 240 pixels at 20 Hz, and a script reads the time from the
  page's canvas. The delay ends in the frame of the browser that has the picture.

The exit status is 1 if a measurement misses its bound.
"""

from __future__ import annotations

import math
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from random import choice
from threading import Event, Thread
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from benchmarks.report import parse_options, print_table
from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.live.address import Address
from robotcore.live.live_view import LiveView
from robotcore.live.server import PAGE
from robotcore.runtime.observer import Observer, RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.safety.velocity_limits import STOPPED
from tests.robotcore.live.client import Client

ESTOP_S, CLOSED_S, PICTURE_S = 0.1, 0.3, 0.08
"""The bounds: the 99th percentiles of the e-stop and of a closed page, and the median of the pictures, in seconds."""

VIEWER_SHARE = 1.1
"""The greatest time of a tick with viewers, as a multiple of that without a viewer."""

PAGE_BYTES = 150_000

MOMENTS_MS = range(500, 1000)
"""The times between the first picture on the page and a press of the e-stop, in milliseconds."""

BITS, BLOCK_PX = 30, 10
"""The number of bits of the time in a picture, in milliseconds, and the side of the block of each."""

PRESS = """() => {
  const at = performance.timeOrigin + performance.now();
  window.dispatchEvent(new KeyboardEvent("keydown", {code: "Space", cancelable: true}));
  return at;
}"""

READ_DELAYS = """(duration) => new Promise((resolve) => {
  const canvas = document.querySelector("#camera"), delays = [], end = performance.now() + duration;
  let last = null;
  const read = () => {
    const now = performance.timeOrigin + performance.now();
    const pixels = canvas.getContext("2d").getImageData(0, 5, 300, 1).data;
    let stamp = 0;
    for (let bit = 0; bit < 30; bit++) stamp = stamp * 2 + (pixels[4 * (bit * 10 + 5)] > 127 ? 1 : 0);
    if (last !== null && stamp !== last) delays.push((now - stamp) % 2 ** 30);
    last = stamp;
    performance.now() < end ? requestAnimationFrame(read) : resolve(delays);
  };
  requestAnimationFrame(read);
})"""


class TurnAndShow(Behaviour):
    """Turns on the spot, and shows a picture with the time in it on the display."""

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE, Role.DISPLAY})

    def step(self, robot: Robot) -> Status:
        image = robot.camera.read().image.copy()
        robot.range.read()
        stamp = round(time.time() * 1000) % 2**BITS
        for bit in range(BITS):
            is_set = stamp >> (BITS - 1 - bit) & 1
            image[:BLOCK_PX, bit * BLOCK_PX : (bit + 1) * BLOCK_PX] = 255 * is_set
        robot.display.show(image)
        robot.drive.set_velocity(0.0, 0.8)
        return Status.RUNNING


class Context:
    """An observer that keeps the description of the run, and the time of the last tick that stopped the wheels."""

    def __init__(self) -> None:
        self.has_begun, self.stopped = Event(), Event()
        self.stop_time = 0.0

    def begin(self, run: RunContext) -> None:
        self.run = run
        self.has_begun.set()

    def tick(self, record: TickRecord) -> None:
        if record.sent != STOPPED and record.sent is not None:
            self.stopped.clear()
        elif not self.stopped.is_set():
            self.stop_time = time.time()
            self.stopped.set()

    def end(self, result: RunResult) -> None:
        self.result = result


class LiveRun:
    """A run in a thread, with a page or without one."""

    def __init__(self, *, has_page: bool = True, **request: Any) -> None:
        self.context, self.view = Context(), LiveView(Address()) if has_page else None
        observers: list[Observer] = [self.context, *([self.view] if self.view else [])]
        fields = {"app": TurnAndShow, "world": "open", "realtime": True, "has_operator": True, **request}
        self._thread = Thread(target=lambda: run(RunRequest(**fields), observers))
        self._thread.start()
        if not self.context.has_begun.wait(60):
            raise RuntimeError("the run did not begin")

    @property
    def link(self) -> str:
        assert self.view
        return self.view.link

    def join(self) -> RunResult:
        self._thread.join()
        return self.context.result

    def stop(self) -> None:
        self.context.run.emergency.press("the benchmark has ended")
        self._thread.join()


@contextmanager
def open_browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or shutil.which("google-chrome")
        yield playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])


def measure_press(page: Page, backend: str) -> float:
    """Return the delay in seconds from a press of the space bar until the motors are stopped."""
    live, stopped = LiveRun(backend=backend), list[float]()
    latch = live.context.run.emergency._latch  # noqa: SLF001  the last stop of the latch ends the delay
    latch.add_stop(lambda: stopped.append(time.time()))
    page.goto(live.link)
    page.locator("#camera[data-count]").wait_for()
    page.wait_for_timeout(choice(MOMENTS_MS))
    pressed = float(page.evaluate(PRESS)) / 1000
    live.join()
    return stopped[0] - pressed


def measure_presses(backends: list[str], presses: int) -> bool:
    rows, is_met = [], True
    with open_browser() as browser:
        for backend in backends:
            page = browser.new_page()
            delays = [measure_press(page, backend) for _ in range(presses)]
            is_met &= (p99 := percentile(delays, 0.99)) <= ESTOP_S
            rows.append((backend, str(presses), *format_ms(statistics.median(delays), p99, max(delays))))
    print_table(("backend", "presses of the e-stop", "median, ms", "p99, ms", "worst, ms"), rows)
    return is_met


def measure_ends(trials: int) -> bool:
    rows, is_met = [], True
    ways: dict[str, Callable[[Client], object]] = {
        "closed": lambda client: client.socket.socket.close(),
        "silent": lambda _: None,
    }
    for way, end in ways.items():
        delays = list(measure_driver_ends(trials, end))
        is_met &= len(delays) == trials and (p99 := percentile(delays, 0.99)) <= CLOSED_S
        rows.append((way, f"{len(delays)}/{trials}", *format_ms(statistics.median(delays), p99, max(delays))))
    print_table(("the driver's page is", "stopped", "median, ms", "p99, ms", "worst, ms"), rows)
    return is_met


def measure_driver_ends(trials: int, end: Callable[[Client], object]) -> Iterator[float]:
    """Yield the delay in seconds from the end of each driver until the tick that stops the wheels."""
    live: Any = LiveRun(app="teleop", timeout_s=36000)
    for trial in range(trials):
        client = Client(live)
        client.send(type="take")
        driven = time.time() + 0.2 + trial % 10 * 0.013
        while time.time() < driven or live.context.stopped.is_set():
            client.send(type="drive", linear=0.0, angular=0.5)
            time.sleep(0.05)
        ended = time.time()
        end(client)
        if live.context.stopped.wait(10):
            yield live.context.stop_time - ended
        client.close()
    live.stop()


def measure_viewers(backends: list[str], rounds: int, seconds: float) -> bool:
    rows, is_met = [], True
    for backend in backends:
        ways = {"no page": None, "0": 0, "1": 1, "4": 4}
        results = {way: list[tuple[float, int]]() for way in ways}
        for _ in range(rounds):
            for way, number in ways.items():
                results[way].append(measure_ticks(backend, number, seconds))
        medians = {way: statistics.median(each for each, _ in found) for way, found in results.items()}
        is_met &= all(medians[way] <= VIEWER_SHARE * medians["0"] for way in ("1", "4"))
        for way, found in results.items():
            overruns = sum(each for _, each in found)
            rows.append((backend, way, f"{medians[way]:.0f}", f"{medians[way] / medians['0']:.2f}", str(overruns)))
    print_table(("backend", "viewers", "p50 of a tick, µs", "of that with 0", "overruns"), rows)
    return is_met


def measure_ticks(backend: str, viewers: int | None, seconds: float) -> tuple[float, int]:
    """Return the median time of a tick without its sleep in microseconds, and the overruns."""
    live = LiveRun(has_page=viewers is not None, backend=backend, timeout_s=seconds)
    if not viewers:
        result = live.join()
    else:
        command = [sys.executable, "-m", "benchmarks.live_viewers", live.link, str(viewers)]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL):  # noqa: S603  the viewers of this benchmark
            result = live.join()
    return sum(each["p50"] for phase, each in result.tick_times_us.items() if phase != "sleep"), result.overruns


def measure_pictures(seconds: float) -> bool:
    with open_browser() as browser:
        live, page = LiveRun(), browser.new_page()
        page.goto(live.link)
        page.locator("#camera[data-count]").wait_for()
        page.wait_for_timeout(1000)
        delays = [each / 1000 for each in page.evaluate(READ_DELAYS, seconds * 1000)]
        live.stop()
    median, rate = statistics.median(delays), len(delays) / seconds
    row = (str(len(delays)), f"{rate:.1f}", *format_ms(median, percentile(delays, 0.99), max(delays)))
    print_table(("pictures", "in a second", "median, ms", "p99, ms", "worst, ms"), [row])
    return bool(median <= PICTURE_S)


def measure_size() -> bool:
    sizes = {file.name: file.stat().st_size for file in PAGE.iterdir()}
    print_table(("files of the page", "bytes"), [(str(len(sizes)), str(sum(sizes.values())))])
    return sum(sizes.values()) <= PAGE_BYTES


def percentile(values: list[float], share: float) -> float:
    """Return the least value that is not below this share of the values."""
    return sorted(values)[math.ceil(share * len(values)) - 1]


def format_ms(*seconds: float) -> list[str]:
    return [f"{np.round(each * 1000, 1):g}" for each in seconds]


def main() -> int:
    assert __doc__
    options = parse_options(
        __doc__, backends="kinematic,mujoco,virtualpi", presses=100, trials=100, rounds=5, seconds=10.0
    )
    backends = options.backends.split(",")
    met = [
        measure_size(),
        measure_presses(backends, options.presses),
        measure_ends(options.trials),
        measure_pictures(options.seconds),
        measure_viewers(backends, options.rounds, options.seconds),
    ]
    return int(not all(met))


if __name__ == "__main__":
    sys.exit(main())
