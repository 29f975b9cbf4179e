"""Checks of the library that drives the pins."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from drivers.raspberrypi.doctor import pins as module
from drivers.raspberrypi.doctor.pins import check_library, find_version
from robotcore.errors import BackendMissingError
from robotcore.hal.check_finding import Level
from tests.drivers.raspberrypi.doctor.conftest import CheckFindings

Versions = Callable[..., None]


class Pins:
    """A pin factory that counts how often it is closed."""

    closed = 0

    def close(self) -> None:
        Pins.closed += 1


@pytest.fixture
def versions(monkeypatch: pytest.MonkeyPatch) -> Versions:
    """Set the versions of installed packages, and let the pin factory open."""
    monkeypatch.delenv("GPIOZERO_PIN_FACTORY", raising=False)
    monkeypatch.setattr(module, "open_pins", Pins)

    def install(**versions: str) -> None:
        monkeypatch.setattr(module, "find_version", versions.get)

    return install


def test_the_library_is_reported_with_its_version_and_closed(versions: Versions, check_findings: CheckFindings) -> None:
    versions(lgpio="0.2.2.0", gpiozero="2.0.1.post3")
    before = Pins.closed
    check_findings(check_library(), "pin-factory-ok")
    assert Pins.closed == before + 1


def test_the_empty_lgpio_of_pip_is_an_error(versions: Versions, check_findings: CheckFindings) -> None:
    versions(lgpio="0.0.0.2", gpiozero="2.0.1")
    check_findings(check_library(), "lgpio-stub")


def test_a_library_that_is_missing_is_an_error_with_its_remedy(
    versions: Versions, monkeypatch: pytest.MonkeyPatch, check_findings: CheckFindings
) -> None:
    def raise_missing() -> Pins:
        raise BackendMissingError("lgpio cannot be used: No module named 'lgpio'. sudo apt install it")

    versions(gpiozero="2.0.1")
    monkeypatch.setattr(module, "open_pins", raise_missing)
    check_findings(check_library(), "pin-factory-fails")


@pytest.mark.parametrize("version, is_old", [("2.0.0", True), ("1.6.2", True), ("2.0.1", False), ("2.1", False)])
def test_a_gpiozero_that_takes_the_wrong_chip_is_an_error(versions: Versions, version: str, is_old: bool) -> None:
    versions(lgpio="0.2.2.0", gpiozero=version)
    assert [each.level for each in check_library()] == ([Level.ERROR] if is_old else []) + [Level.OK]


def test_versions_are_those_of_the_installed_packages() -> None:
    assert find_version("gpiozero")
    assert find_version("no-such-package") is None
