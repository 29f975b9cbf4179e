"""test_battery_diagnosis."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import DescriptionError
from robotcore.hal.backend import Setup
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot
from robotcore.hardware.diagnosis import CHARGE, UNREAD_REMEDY, diagnose_batteries
from robotcore.testing.mock.backend import MockBackend
from tests.doubles.powered import powered_rover


class Asked(MockBackend):
    """Keeps what it was asked to open, and what it notes of it."""

    notes_of_it: tuple[str, ...] = ()
    error: Exception | None = None

    def open(self, setup: Setup) -> Robot:
        self.asked = setup.devices
        if self.error:
            raise self.error
        devices = [] if self.notes_of_it else super().open(setup).devices.values()
        return Robot("rover", super().open(setup).clock, devices, notes=self.notes_of_it)


@pytest.mark.parametrize(
    "volts, finding",
    [
        (7.412, Finding.ok("cells", "7.41 V, to be charged below 6.6 V")),
        (6.6, Finding.ok("cells", "6.60 V, to be charged below 6.6 V")),
        (6.2, Finding.warning("cells", "6.20 V, and it is to be charged below 6.6 V", CHARGE)),
    ],
)
def test_a_battery_is_read_and_judged_and_nothing_else_is_opened(
    tmp_path: Path, volts: float, finding: Finding
) -> None:
    backend = Asked({"cells": volts})
    assert list(diagnose_batteries(backend, powered_rover(tmp_path))) == [finding]
    assert backend.asked == {"cells"}


@pytest.mark.parametrize(
    "note, remedy",
    [("cells: no answer", UNREAD_REMEDY), ("cells: no divider; name its pin", ""), ("No divider. Add it", "")],
)
def test_one_that_cannot_be_opened_is_not_taken_for_ok(tmp_path: Path, note: str, remedy: str) -> None:
    backend = Asked({"cells": 7.4})
    backend.notes_of_it = (note,)
    (finding,) = diagnose_batteries(backend, powered_rover(tmp_path))
    assert finding == Finding.unchecked("battery", note, remedy)


def test_where_the_backend_tells_of_none_nothing_is_opened(tmp_path: Path) -> None:
    backend = Asked()
    assert list(diagnose_batteries(backend, powered_rover(tmp_path))) == []
    assert not hasattr(backend, "asked")


def test_what_is_wrong_with_the_file_is_reported_by_others(tmp_path: Path) -> None:
    backend = Asked({"cells": 7.4})
    backend.error = DescriptionError("a.toml", "serial", "is missing", "Add it")
    assert list(diagnose_batteries(backend, powered_rover(tmp_path))) == []
