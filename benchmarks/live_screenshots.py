"""Take the screenshots of the live page for the documentation: ``python -m benchmarks.live_screenshots``.

It needs Chromium and Playwright. The pictures are in docs/images.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread

from playwright.sync_api import Browser, sync_playwright

from robotcore import RunRequest, run
from robotcore.live.address import Address
from robotcore.live.live_view import LiveView
from robotcore.recording.recorder import Recorder

FOLDER = Path(__file__).parents[1] / "docs" / "images"
SHOTS = (
    ("live-page.png", 1440, 900, "light"),
    ("live-page-dark.png", 1440, 900, "dark"),
    ("live-page-phone.png", 390, 844, "light"),
)
"""The file, the width and the height in pixels, and the colours of each screenshot."""

RUN_MS = 6_000
"""The time of the run in the first screenshot, in milliseconds."""

SHOWN_S = 16.0
"""The time that the screenshot of two recordings shows, in seconds."""


def take_screenshot(browser: Browser, link: str, file: str, width: int, height: int, colours: str) -> None:
    """Write a screenshot of the page at a link."""
    is_dark = colours == "dark"
    page = browser.new_page(
        viewport={"width": width, "height": height},
        color_scheme="dark" if is_dark else "light",
        device_scale_factor=1,
        has_touch=width < 500,
    )
    page.goto(link)
    page.wait_for_timeout(1500)
    page.screenshot(path=FOLDER / file)
    page.close()


def show_recordings(browser: Browser, folder: Path) -> None:
    """Write the screenshot of a recording beside another of the same app."""
    files = []
    for backend in ("kinematic", "mujoco"):
        files.append(str(folder / f"{backend}.mcap"))
        recorder = Recorder(Path(files[-1]))
        run(RunRequest("green-search", backend=backend, seed=7), [recorder], [recorder.layer])
    command = [sys.executable, "-m", "robotcore", "view", *files]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        assert process.stdout
        page = browser.new_page(viewport={"width": 1440, "height": 1000}, device_scale_factor=1)
        page.goto(process.stdout.readline().split()[-1])
        page.wait_for_timeout(1000)
        page.locator("#slider").evaluate(
            "(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input')); }", SHOWN_S
        )
        page.wait_for_timeout(1000)
        page.screenshot(path=FOLDER / "live-page-recordings.png")
        page.close()
        process.terminate()


def main() -> None:
    view = LiveView(Address())
    request = RunRequest("green-search", seed=7, realtime=True, has_operator=True, timeout_s=60)
    thread = Thread(target=lambda: run(request, [view]))
    thread.start()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        first = browser.new_page()
        first.goto(view.link)
        first.wait_for_timeout(RUN_MS)
        for shot in SHOTS:
            take_screenshot(browser, view.link, *shot)
        first.keyboard.press("Space")
        with TemporaryDirectory() as folder:
            show_recordings(browser, Path(folder))
        browser.close()
    thread.join()


if __name__ == "__main__":
    main()
