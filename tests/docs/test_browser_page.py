"""The page that runs an app in the browser. A real Chromium opens it."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from importlib.metadata import distribution
from pathlib import Path
from threading import Thread
from zipfile import ZipFile

import pytest
from playwright.sync_api import Page, sync_playwright

from docs.generator import browser_files
from robotcore import RunRequest, run
from tests.robotcore.live.chromium import require_chromium

ROOT = Path(__file__).parents[2]
PACKAGES = ("robotcore", "drivers", "apps")
PYODIDE = "ROBOTCORE_PYODIDE"
RUN_LIMIT_MS = 240_000
"""A busy machine needs a minute for the import and the run."""


class QuietHandler(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:  # noqa: A002  the name is that of the base class
        pass


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the files of the page."""
    return Path(shutil.copytree(ROOT / "docs" / "browser", tmp_path / "browser"))


@pytest.fixture
def page(folder: Path) -> Iterator[Page]:
    """Open the page in Chromium, from a server on this machine."""
    program = require_chromium()
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=str(folder))) as server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        with sync_playwright() as started:
            chromium = started.chromium.launch(executable_path=program, args=["--no-sandbox"])
            page = chromium.new_page()
            page.goto(f"http://127.0.0.1:{server.server_port}/run.html?seed=7")
            yield page
            chromium.close()
        server.shutdown()
        thread.join()


def write_wheel(file: Path) -> None:
    """Write the installed version of robotcore as a wheel, with its entry points."""
    metadata = distribution("robotcore")
    info = f"robotcore-{metadata.version}.dist-info"
    with ZipFile(file, "w") as wheel:
        for package in PACKAGES:
            for part in (ROOT / package).rglob("*"):
                if part.is_file() and part.suffix != ".pyc":
                    wheel.write(part, part.relative_to(ROOT))
        for name in ("METADATA", "entry_points.txt"):
            wheel.writestr(f"{info}/{name}", metadata.read_text(name) or "")


def wait_for_end(page: Page, state: str) -> str:
    page.locator("#start").click()
    status = page.locator(f"#status[data-state={state}]")
    status.wait_for(timeout=RUN_LIMIT_MS)
    return status.inner_text()


@pytest.mark.slow
def test_page_without_pyodide_names_the_address_that_it_needs(page: Page) -> None:
    page.locator("#pyodide").fill("nowhere")
    assert "nowhere/pyodide.mjs" in wait_for_end(page, "error")


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_page_runs_green_search_as_the_desk(page: Page, folder: Path) -> None:
    source = os.environ.get(PYODIDE)
    if not source:
        pytest.skip(f"needs a folder with Pyodide 314, numpy, opencv-python, pydantic and rich: {PYODIDE}=FOLDER")
    (folder / "pyodide").symlink_to(source, target_is_directory=True)
    write_wheel(folder / "robotcore.whl")
    desk = run(RunRequest("green-search", seed=7))
    described = browser_files.describe_run(7) | {"digest": "0" * 64}
    (folder / "desk.json").write_text(json.dumps({7: described}))
    page.reload()
    wait_for_end(page, "ended")
    assert page.locator("#outcome").inner_text() == desk.outcome.value
    assert page.locator("#time").inner_text() == f"{desk.sim_time_s:.1f} s in {desk.ticks} ticks"
    assert page.locator("#picture").is_visible()
    assert page.locator("#desk").inner_text() == "0" * 64
    assert page.locator("#comparison").inner_text() == (
        "The digests differ. The outcome and the number of ticks are equal."
    )
    assert "no watchdog" in page.locator("#notes").inner_text()


@pytest.mark.slow
def test_page_compares_with_runs_of_the_desk(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(browser_files, "SEEDS", [7])
    monkeypatch.setattr(browser_files, "DIST", tmp_path)
    (tmp_path / "robotcore-9-py3-none-any.whl").write_bytes(b"wheel")
    files = dict(browser_files.list_browser_files())
    result = run(RunRequest("green-search", seed=7))
    described = {"outcome": "success", "ticks": result.ticks, "digest": result.trace_sha256}
    assert json.loads(files["desk.json"]) == {"7": described}
    assert files["robotcore.whl"] == b"wheel"
