"""The Chromium of this machine."""

from __future__ import annotations

import shutil

import pytest
from playwright.sync_api import FloatRect, Locator

NAMES = ("chromium", "chromium-browser", "google-chrome")


def require_chromium() -> str:
    """Return the path of Chromium. Skip the test on a machine without it."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip("needs Chromium. On Debian: apt install chromium")
    return found


def measure(part: Locator) -> FloatRect:
    """Return the place and the size of a visible part of a page, in pixels."""
    box = part.bounding_box()
    assert box
    return box


def find_bottom(part: Locator) -> float:
    """Return the lower edge of a visible part of a page, in pixels."""
    box = measure(part)
    return box["y"] + box["height"]
