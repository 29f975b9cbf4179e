"""All devices are opened, or none."""

from __future__ import annotations

import pytest

from robotcore.description import AnyDevice, BatteryDescription, load_robot
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device
from robotcore.hal.robot import Robot
from robotcore.hardware import Host, encoder_of, motor_of, open_devices, open_robot
from tests.robotcore.hardware.device_drivers import NoSettings, Noted, NotingDriver, fitted, host
from tests.texts import Raises

ROVER = load_robot("rover")
ORDER = ["left_encoder", "right_encoder", "nose", "eye", "screen", "left_motor", "right_motor"]


def opened_by(driver: NotingDriver) -> dict[str, Device]:
    opened: dict[str, Device] = {}
    open_devices(fitted(driver, ROVER), host(opened), opened)
    return opened


def test_motors_are_opened_last_and_see_what_is_open_by_then() -> None:
    driver = NotingDriver()
    assert list(opened_by(driver)) == ORDER
    assert driver.diary[0] == "open left_encoder beside nothing"
    assert driver.diary[-1] == "open right_motor beside left_encoder, right_encoder, nose, eye, screen, left_motor"


def test_where_one_fails_the_others_are_tried_and_closed_again_the_last_one_first(raises: Raises) -> None:
    driver = NotingDriver("nose")
    with raises(DeviceError, device="nose"):
        opened_by(driver)
    assert [line for line in driver.diary if line.startswith("close")] == [
        f"close {name}" for name in reversed(ORDER) if name != "nose"
    ]


def test_a_battery_that_fails_keeps_no_motor_from_being_opened_and_is_noted() -> None:
    cells = BatteryDescription(kind="battery", name="cells")
    powered = ROVER.model_copy(update={"devices": (*ROVER.devices, cells)})
    opened: dict[str, Device] = {}
    notes = open_devices(fitted(NotingDriver("cells"), powered), host(opened), opened)
    assert notes == ["cells: does not answer. Its voltage will not be reported"]
    assert list(opened) == ORDER


def test_every_device_that_fails_is_reported(raises: Raises) -> None:
    with raises(DeviceGroupError):
        opened_by(NotingDriver("left_motor", "nose"))


def test_an_interruption_closes_what_is_open() -> None:
    class Interrupting(NotingDriver):
        def open(self, description: AnyDevice, settings: NoSettings, host: Host) -> Device:
            if description.name == "eye":
                raise KeyboardInterrupt
            return super().open(description, settings, host)

    driver = Interrupting()
    with pytest.raises(KeyboardInterrupt):
        opened_by(driver)
    assert driver.diary[-3:] == ["close nose", "close right_encoder", "close left_encoder"]


@pytest.mark.parametrize(
    "raised, text",
    [
        (ConnectionError("no such port"), "eye: ConnectionError: no such port"),
        (
            ImportError("No module named 'serial'"),
            r"eye: a library is not installed \(No module .*\)\. pip install noting",
        ),
    ],
)
def test_what_a_driver_has_not_translated_is_reported_by_the_device_s_name(raised: Exception, text: str) -> None:
    class Untranslated(NotingDriver):
        remedy = "pip install noting"

        def open(self, description: AnyDevice, settings: NoSettings, host: Host) -> Device:
            if description.name == "eye":
                raise raised
            return super().open(description, settings, host)

    driver = Untranslated()
    with pytest.raises(DeviceError, match=text) as caught:
        opened_by(driver)
    assert caught.value.__cause__ is raised
    assert len([line for line in driver.diary if line.startswith("close")]) == len(ORDER) - 1


def test_a_device_that_fails_in_closing_hides_neither_why_nor_keeps_the_others_open(raises: Raises) -> None:
    class Stuck(Noted):
        def _release(self) -> None:
            raise DeviceError(self.name, "cannot be let go")

    class StuckDriver(NotingDriver):
        def open(self, description: AnyDevice, settings: NoSettings, host: Host) -> Device:
            device = super().open(description, settings, host)
            return Stuck(description.name, self.diary) if description.name == "eye" else device

    driver = StuckDriver("left_motor")
    with raises(DeviceGroupError):
        opened_by(driver)
    assert driver.diary[-1] == "close left_encoder"


class Board:
    """One port with all devices on it."""

    def __init__(self, diary: list[str]) -> None:
        self.diary = diary
        diary.append("open the board")

    def close(self) -> None:
        self.diary.append("close the board")


class OnBoardDriver(NotingDriver):
    """Opens devices that are all on one board."""

    def open(self, description: AnyDevice, settings: NoSettings, host: Host) -> Device:
        host.shared.take(Board, "/dev/ttyUSB0", lambda: Board(self.diary))
        return super().open(description, settings, host)


def on_board(monkeypatch: pytest.MonkeyPatch, driver: OnBoardDriver) -> Robot:
    monkeypatch.setattr("robotcore.hardware.opening.bind_devices", lambda *_: fitted(driver, ROVER))
    setup = Setup(ROVER, None, frozenset(ORDER))
    clock = SteppedClock(20, lambda _steps: None)
    return open_robot(setup, "board", clock, release=lambda: driver.diary.append("release"))


def test_a_board_that_devices_share_is_opened_once_and_closed_after_the_last_of_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    driver = OnBoardDriver()
    on_board(monkeypatch, driver).close()
    assert driver.diary[0] == "open the board"
    assert driver.diary.count("open the board") == 1
    assert driver.diary[-2:] == ["close the board", "release"]
    assert len([line for line in driver.diary if line.startswith("close")]) == len(ORDER) + 1


def test_a_robot_that_cannot_be_opened_leaves_no_board_open(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    driver = OnBoardDriver("left_motor")
    with raises(DeviceError, device="left_motor"):
        on_board(monkeypatch, driver)
    assert driver.diary[-3:] == ["close left_encoder", "close the board", "release"]


def test_the_two_on_a_wheel_find_each_other() -> None:
    assert encoder_of("left_motor", ROVER) == "left_encoder"
    assert motor_of("right_encoder", ROVER) == "right_motor"


def test_what_is_on_no_wheel_of_the_drive_has_no_other() -> None:
    bare = ROVER.model_copy(update={"drive": None})
    assert encoder_of("arm", ROVER) is motor_of("knob", ROVER) is None
    assert encoder_of("left_motor", bare) is motor_of("left_encoder", bare) is None


def test_a_wheel_may_have_no_encoder() -> None:
    assert ROVER.drive is not None
    drive = ROVER.drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    assert encoder_of("left_motor", ROVER.model_copy(update={"drive": drive})) is None
