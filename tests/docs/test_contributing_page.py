"""The device driver in CONTRIBUTING.md passes its test."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.listings import list_listings

PAGE = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
DRIVER, TEST = "bumper.py", "test_bumper.py"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    for listing in list_listings(PAGE):
        if listing.file in {DRIVER, TEST}:
            (tmp_path / listing.file).write_text(listing.text, encoding="utf-8")
    return tmp_path


def run_test(package: Path) -> str:
    """Return the output of the page's test on the page's driver."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", TEST]
    return subprocess.run(command, cwd=package, capture_output=True, text=True, check=False, timeout=60).stdout


@pytest.mark.slow
def test_the_device_driver_passes_its_own_test(package: Path) -> None:
    assert "1 passed" in run_test(package)


@pytest.mark.slow
def test_the_page_test_fails_if_the_driver_is_wrong(package: Path) -> None:
    driver = package / DRIVER
    driver.write_text(driver.read_text().replace("self.min_range if", "self.max_range if"), encoding="utf-8")
    assert "1 failed" in run_test(package)
