"""Findings about the batteries of a robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import DescriptionError
from robotcore.hal.backend import Setup
from robotcore.hal.check_finding import Finding, Level
from robotcore.hal.robot import Robot
from robotcore.hardware.diagnosis import UNREAD_REMEDY, diagnose_monitored
from robotcore.testing.mock.backend import MockBackend
from tests.doubles.battery_backend import load_battery_rover
from tests.texts import CheckText


class BatteryBackend(MockBackend):
    """Records the names of the devices that it opens. It can raise an error, or return notes in place of a battery."""

    battery_notes: tuple[str, ...] = ()
    error: Exception | None = None

    def open(self, setup: Setup) -> Robot:
        self.opened = setup.devices
        if self.error:
            raise self.error
        devices = [] if self.battery_notes else super().open(setup).devices.values()
        return Robot("rover", super().open(setup).clock, devices, notes=self.battery_notes)


@pytest.mark.parametrize(
    "volts, level, kind",
    [(7.412, Level.OK, "sensor-ok"), (6.6, Level.OK, "sensor-ok"), (6.2, Level.WARNING, "sensor-problem")],
)
def test_only_the_battery_is_opened_and_its_voltage_is_reported(
    tmp_path: Path, volts: float, level: Level, kind: str, check_text: CheckText
) -> None:
    backend = BatteryBackend({"cells": volts})
    (finding,) = diagnose_monitored(backend, load_battery_rover(tmp_path))
    assert (finding.subject, finding.level, finding.kind) == ("cells", level, kind)
    assert backend.opened == {"cells"}
    check_text(finding)


@pytest.mark.parametrize(
    "note, remedy",
    [("cells: no answer", UNREAD_REMEDY), ("cells: no divider; name its pin", ""), ("No divider. Add it", "")],
)
def test_a_battery_that_cannot_be_opened_is_unchecked(tmp_path: Path, note: str, remedy: str) -> None:
    backend = BatteryBackend({"cells": 7.4})
    backend.battery_notes = (note,)
    (finding,) = diagnose_monitored(backend, load_battery_rover(tmp_path))
    assert finding == Finding.unchecked("sensor", note, remedy, kind="sensor-unread")


def test_nothing_is_opened_if_the_backend_has_no_battery(tmp_path: Path) -> None:
    backend = BatteryBackend()
    assert list(diagnose_monitored(backend, load_battery_rover(tmp_path))) == []
    assert not hasattr(backend, "opened")


def test_mistake_in_the_file_is_not_reported_as_a_battery_finding(tmp_path: Path) -> None:
    backend = BatteryBackend({"cells": 7.4})
    backend.error = DescriptionError("a.toml", "serial", "is missing", "Add it")
    assert list(diagnose_monitored(backend, load_battery_rover(tmp_path))) == []
