"""Measure ``robotcore view`` over recordings of different lengths: ``python -m benchmarks.recorded_page``.

Each recording has one picture of 320 x 240 pixels a tick, at 20 Hz. The table has the time until the command prints its
link, its greatest memory beside that of ``robotcore info``, and the delay from a move of the slider to the tick in
Chromium, for 50 moves. The exit status is 1 if a median delay is above its bound.
"""

from __future__ import annotations

import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from playwright.sync_api import Page, expect, sync_playwright

from benchmarks.report import print_table
from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.recording.recorder import Recorder

MINUTES = (1, 10, 30)
MOVES = 50

SEEK_S = 0.2
"""The greatest median delay from a move of the slider to the tick on the page, in seconds."""


class TurnAndLook(Behaviour):
    """Drives in a circle, and reads the camera in each tick."""

    needs = frozenset({Role.DRIVE, Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        robot.camera.read()
        robot.drive.set_velocity(0.1, 0.5)
        return Status.RUNNING


def find_memory(status: str) -> float:
    """Return the greatest memory that a process has used, in MB.

    status: the text of its file ``/proc/PID/status``.
    """
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    assert found
    return int(found[1]) / 1000


def measure_info(file: Path) -> float:
    """Return the greatest memory of ``robotcore info``, in MB."""
    script = (
        "import sys; from robotcore.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: sys.stderr.write(open('/proc/self/status').read())"
    )
    command = [sys.executable, "-c", script, "info", str(file)]
    return find_memory(subprocess.run(command, check=True, capture_output=True, text=True).stderr)  # noqa: S603


def measure_seek(page: Page, seconds: float) -> float:
    """Return the delay from a move of the slider to the tick on the page, in seconds."""
    begin = time.perf_counter()
    page.locator("#slider").evaluate(
        "(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input')); }", seconds
    )
    expect(page.frame_locator("iframe").locator("#time")).to_have_text(f"{seconds:.1f} s")
    return time.perf_counter() - begin


def measure(page: Page, file: Path, minutes: int) -> tuple[list[str], float]:
    """Return the row of a recording, and the median delay in seconds."""
    recorder = Recorder(file)
    run(RunRequest(TurnAndLook, world="arena", timeout_s=60.0 * minutes), [recorder], [recorder.layer])
    begin = time.perf_counter()
    command = [sys.executable, "-m", "robotcore", "view", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        assert process.stdout
        link = process.stdout.readline().split()[-1]
        opened = time.perf_counter() - begin
        page.goto(link)
        random = Random(minutes)
        delays = sorted(measure_seek(page, float(random.randrange(60 * minutes))) for _ in range(MOVES))
        memory = find_memory(Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8"))
        process.terminate()
    median = statistics.median(delays)
    size = file.stat().st_size / 1e6
    numbers = [f"{size:.1f}", f"{opened:.1f}", f"{memory:.0f}", f"{measure_info(file):.0f}"]
    return [f"{minutes} min", *numbers, f"{1000 * median:.0f}", f"{1000 * delays[-1]:.0f}"], median


def main() -> int:
    rows, medians = [], []
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for minutes in MINUTES:
            row, median = measure(browser.new_page(), Path(folder, f"{minutes}.mcap"), minutes)
            rows.append(row)
            medians.append(median)
        browser.close()
    titles = ["recording", "MB", "opened after, s", "memory, MB", "of info, MB", "seek, median, ms", "worst, ms"]
    print_table(titles, rows)
    return int(max(medians) > SEEK_S)


if __name__ == "__main__":
    sys.exit(main())
