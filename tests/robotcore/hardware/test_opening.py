"""All devices of a robot are opened, or none."""

from __future__ import annotations

import pytest

from robotcore.description import DeviceDescription, load_robot
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceContext, encoder_of, motor_of, open_devices, open_robot
from robotcore.kinds.battery import BatteryDescription
from tests.robotcore.hardware.device_drivers import RecordedDevice, RecordingDriver, bind, context
from tests.texts import CheckText, Raises

ROVER = load_robot("rover")
ORDER = ["left_encoder", "right_encoder", "nose", "eye", "screen", "left_motor", "right_motor"]


def opened_by(driver: RecordingDriver) -> dict[str, Device]:
    opened: dict[str, Device] = {}
    open_devices(bind(driver, ROVER), context(opened), opened)
    return opened


def test_motors_are_opened_last_and_see_the_open_devices() -> None:
    driver = RecordingDriver()
    assert list(opened_by(driver)) == ORDER
    assert driver.calls[0] == "open left_encoder beside nothing"
    assert driver.calls[-1] == "open right_motor beside left_encoder, right_encoder, nose, eye, screen, left_motor"


def test_if_a_device_fails_the_others_are_opened_and_closed_in_reverse_order(raises: Raises) -> None:
    driver = RecordingDriver(dead=("nose",))
    with raises(DeviceError, device="nose"):
        opened_by(driver)
    assert [line for line in driver.calls if line.startswith("close")] == [
        f"close {name}" for name in reversed(ORDER) if name != "nose"
    ]


def test_failed_battery_gives_a_note_and_the_other_devices_open(check_text: CheckText) -> None:
    cells = BatteryDescription(kind="battery", name="cells")
    powered = ROVER.model_copy(update={"devices": (*ROVER.devices, cells)})
    opened: dict[str, Device] = {}
    notes = open_devices(bind(RecordingDriver(dead=("cells",)), powered), context(opened), opened)
    (note,) = notes
    check_text(note)
    assert list(opened) == ORDER


def test_an_interruption_closes_the_open_devices() -> None:
    class Interrupting(RecordingDriver):
        def open(self, description: DeviceDescription, context: DeviceContext) -> Device:
            if description.name == "eye":
                raise KeyboardInterrupt
            return super().open(description, context)

    driver = Interrupting()
    with pytest.raises(KeyboardInterrupt):
        opened_by(driver)
    assert driver.calls[-3:] == ["close nose", "close right_encoder", "close left_encoder"]


@pytest.mark.parametrize(
    "raised, kind",
    [
        pytest.param(ConnectionError("no such port"), "driver-failed", id="failure"),
        pytest.param(ImportError("No module named 'serial'"), "library-missing", id="library"),
    ],
)
def test_another_error_of_a_driver_becomes_a_device_error(raised: Exception, kind: str, raises: Raises) -> None:
    class FailingDriver(RecordingDriver):
        remedy = "pip install noting"

        def open(self, description: DeviceDescription, context: DeviceContext) -> Device:
            if description.name == "eye":
                raise raised
            return super().open(description, context)

    driver = FailingDriver()
    with raises(DeviceError, kind, device="eye") as caught:
        opened_by(driver)
    assert caught.value.__cause__ is raised
    assert len([line for line in driver.calls if line.startswith("close")]) == len(ORDER) - 1


def test_a_device_that_cannot_be_closed_is_reported_with_the_first_failure(raises: Raises) -> None:
    class Stuck(RecordedDevice):
        def _release(self) -> None:
            raise DeviceError(self.name, "cannot be let go")

    class StuckDriver(RecordingDriver):
        def open(self, description: DeviceDescription, context: DeviceContext) -> Device:
            device = super().open(description, context)
            return Stuck(description.name, self.calls) if description.name == "eye" else device

    driver = StuckDriver(dead=("left_motor",))
    with raises(DeviceGroupError):
        opened_by(driver)
    assert driver.calls[-1] == "close left_encoder"


class Board:
    """A port that all devices share."""

    def __init__(self, calls: list[str]) -> None:
        self.calls = calls
        calls.append("open the board")

    def close(self) -> None:
        self.calls.append("close the board")


class OnBoardDriver(RecordingDriver):
    """Opens devices on one board."""

    def open(self, description: DeviceDescription, context: DeviceContext) -> Device:
        context.shared.take(Board, "/dev/ttyUSB0", lambda: Board(self.calls))
        return super().open(description, context)


def on_board(driver: OnBoardDriver) -> Robot:
    setup = Setup(ROVER, None, frozenset(ORDER))
    clock = SteppedClock(20, lambda _steps: None)
    return open_robot(setup, bind(driver, ROVER), clock, release=lambda: driver.calls.append("release"))


def test_a_shared_board_is_opened_once_and_closed_after_its_last_device() -> None:
    driver = OnBoardDriver()
    on_board(driver).close()
    assert driver.calls[0] == "open the board"
    assert driver.calls.count("open the board") == 1
    assert driver.calls[-2:] == ["close the board", "release"]
    assert len([line for line in driver.calls if line.startswith("close")]) == len(ORDER) + 1


def test_a_robot_that_cannot_be_opened_leaves_no_board_open(raises: Raises) -> None:
    driver = OnBoardDriver(dead=("left_motor",))
    with raises(DeviceError, device="left_motor"):
        on_board(driver)
    assert driver.calls[-3:] == ["close left_encoder", "close the board", "release"]


def test_motor_and_encoder_of_a_wheel_are_matched() -> None:
    assert encoder_of("left_motor", ROVER) == "left_encoder"
    assert motor_of("right_encoder", ROVER) == "right_motor"
    bare = ROVER.model_copy(update={"drive": None})
    assert encoder_of("arm", ROVER) is motor_of("knob", ROVER) is None
    assert encoder_of("left_motor", bare) is motor_of("left_encoder", bare) is None
