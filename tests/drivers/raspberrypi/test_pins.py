"""The pin factory, and errors of pins as errors of a device."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import Mock

import pytest
from gpiozero import LED, PWMLED, OutputDevice
from gpiozero.exc import PinUnknownPi
from gpiozero.pins.mock import MockFactory, MockPWMPin

from drivers.raspberrypi.chip import Chip, HeldLineError
from drivers.raspberrypi.pins import build_pin_error, open_output, open_pins, stop_edge_detection, translate_pin_errors
from robotcore.errors import (
    BackendError,
    BackendMissingError,
    DeviceClosedError,
    DeviceError,
)
from robotcore.plugins import DEVICES, device_driver_names, load_registered
from tests.drivers.raspberrypi.lines import Lines, lgpio
from tests.texts import CheckText, Raises

pytestmark = pytest.mark.usefixtures("fake_lgpio")


@pytest.fixture
def other() -> Iterator[Chip]:
    """Return a chip that holds lines like another program."""
    made = Chip()
    yield made
    made.close()


def test_pins_are_those_of_lgpio_in_spite_of_the_variable_of_gpiozero_and_closing_frees_every_line(
    lines: Lines, pins: Any, other: Chip
) -> None:
    lamp = PWMLED(17, pin_factory=pins)
    lamp.value = 0.6
    assert lines.level(17) == 60
    with pytest.raises(HeldLineError):
        other.claim_low([17])
    pins.close()
    other.claim_low([17])


def test_a_line_that_another_process_holds_is_reported_with_its_holder(
    pins: Any, other: Chip, raises: Raises, monkeypatch: pytest.MonkeyPatch
) -> None:
    other.claim_low([17])
    monkeypatch.setattr("drivers.raspberrypi.pins.find_holder", lambda _gpio: "process 12 (python3)")
    for _ in range(2):  # the failed device of the first attempt does not keep the GPIO reserved
        with raises(DeviceError, "gpio-held", device="lamp", gpios=(17,)), translate_pin_errors("lamp", [17]):
            LED(17, pin_factory=pins)


def test_a_line_that_two_devices_of_a_program_use_is_reported(pins: Any, raises: Raises) -> None:
    with (
        LED(22, pin_factory=pins),
        raises(DeviceError, "gpio-in-use", device="lamp", gpios=(22,)),
        translate_pin_errors("lamp", [22]),
    ):
        LED(22, pin_factory=pins)


def test_the_pins_are_on_the_same_chip_as_the_guardians_lines(lines: Lines, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the number, gpiozero may choose another chip."""
    for module in ("pins", "chip"):
        monkeypatch.setattr(f"drivers.raspberrypi.{module}.find_chip_number", lambda *_: 15)
    Path(os.environ["FAKE_DEV"], "gpiochip15").mkdir()
    pins, guardian = open_pins(), Chip()
    pins.pin(17)
    with pytest.raises(HeldLineError):
        guardian.claim_low([17])
    guardian.close()
    pins.close()


def test_an_edge_after_the_stop_of_its_detection_is_ignored(pins: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception would end lgpio's thread, and with it the edges of all devices."""
    registered = Mock()
    monkeypatch.setattr("lgpio.callback", registered)
    edges = []

    def on_edge(ticks: float, level: int) -> None:
        edges.append((ticks, level))

    pin = pins.pin(17)
    pin.when_changed = on_edge
    report_edge = registered.call_args.args[-1]
    report_edge(0, 17, 1, 2_500_000_000)
    stop_edge_detection(pin)
    report_edge(0, 17, 0, 2_600_000_000)
    assert edges == [(2.5, 1)]


@pytest.mark.parametrize("is_missing", [True, False])
def test_a_missing_or_empty_lgpio_is_reported_with_the_command_that_installs_it(
    *, is_missing: bool, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    if is_missing:
        monkeypatch.delitem(sys.modules, "lgpio")
        monkeypatch.setattr(sys, "path", [])
    else:
        monkeypatch.setitem(sys.modules, "lgpio", ModuleType("lgpio"))
    with raises(BackendMissingError, "lgpio-missing"):
        open_pins()


@pytest.mark.parametrize("has_lgpio", [True, False])
def test_a_machine_that_is_no_pi_is_reported(
    *, has_lgpio: bool, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def unknown() -> int:
        raise PinUnknownPi("unable to locate Pi revision")

    if not has_lgpio:
        monkeypatch.setitem(sys.modules, "lgpio", None)
    monkeypatch.setattr("gpiozero.pins.local.get_pi_revision", unknown)
    with raises(BackendError, "no-raspberry-pi"):
        open_pins()


@pytest.mark.parametrize("exists, is_allowed", [(False, False), (True, False), (True, True)])
def test_a_chip_that_cannot_be_opened_is_reported_with_a_remedy(
    exists: bool, is_allowed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setenv("FAKE_DEV", str(tmp_path / "empty"))
    monkeypatch.setattr("pathlib.Path.exists", lambda _: exists)
    monkeypatch.setattr("os.access", lambda *_: is_allowed)
    with raises(BackendError, "gpio-chip-closed"):
        open_pins()


def test_any_other_failure_is_reported_with_the_gpios_the_cause_and_a_remedy(check_text: CheckText) -> None:
    failure = build_pin_error("nose", (16, 26), lgpio.error("bad handle"))
    assert (failure.kind, failure.fields["gpios"]) == ("gpio-failed", (16, 26))
    check_text(failure)


def test_an_error_of_robotcore_is_not_translated() -> None:
    with pytest.raises(DeviceClosedError), translate_pin_errors("nose", (16,)):
        raise DeviceClosedError("nose")


class BusyPin:
    """A pin that raises an error a number of times when edge detection is switched off."""

    def __init__(self, message: str, failures: int) -> None:
        self._message, self._failures = message, failures
        self.is_detecting = True

    def __setattr__(self, name: str, value: object) -> None:
        if name == "when_changed":
            if self._failures:
                self._failures -= 1
                raise OSError(self._message)
            self.is_detecting = False
        else:
            super().__setattr__(name, value)


@pytest.mark.parametrize(
    "message, failures, is_detecting",
    [
        ("GPIO busy", 2, False),
        pytest.param("GPIO busy", 200, True, marks=pytest.mark.slow),
        ("unknown handle", 1, True),
    ],
    ids=["busy", "long-busy", "other"],
)
def test_a_line_that_lgpios_thread_still_waits_for_is_tried_again_up_to_a_time_limit(
    message: str, failures: int, is_detecting: bool
) -> None:
    pin = BusyPin(message, failures)
    with pytest.raises(OSError) if is_detecting else nullcontext():  # noqa: PT011  the library's own
        stop_edge_detection(pin)
    assert pin.is_detecting is is_detecting


def test_a_line_with_a_fixed_pull_up_can_be_closed() -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    with ExitStack() as opened:
        open_output("left_motor", 2, pins, opened)
    OutputDevice(2, pin_factory=pins).close()


def test_every_driver_on_gpios_names_its_connector() -> None:
    drivers = [load_registered("device driver", DEVICES, name) for name in device_driver_names()]
    wrong = [each.name for each in drivers if ("gpiozero" in each.modules) is not (each.connector == "GPIO")]
    assert wrong == []
