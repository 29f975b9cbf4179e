"""Fixtures of the live page: a run in a thread, and a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from robotcore.live.address import Address
from tests.robotcore.live.chromium import require_chromium
from tests.robotcore.live.live_run import LiveRun, StartRun


@pytest.fixture
def start_run() -> Iterator[StartRun]:
    """Start runs with a live page. The end of the test ends them."""
    runs: list[LiveRun] = []

    def start(address: Address | None = None, **request: Any) -> LiveRun:
        runs.append(LiveRun(address or Address(), **request))
        return runs[-1]

    yield start
    for each in runs:
        each.stop()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Return a headless Chromium."""
    chromium = require_chromium()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """Return a page of a desktop browser. The test fails if a script of the page fails."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page, failures = context.new_page(), []
    page.on("pageerror", lambda error: failures.append(str(error)))
    yield page
    context.close()
    assert not failures
