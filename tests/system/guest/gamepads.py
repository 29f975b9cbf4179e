"""The driver of gamepads on a gamepad that uinput creates: axes, buttons, unplugging, and a stop of the wheels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from evdev import AbsInfo, UInput, ecodes

import robotcore
from drivers.raspberrypi.gamepads import EventGamepadDriver
from robotcore import Behaviour, Outcome, Robot, RunRequest, Status
from robotcore.description import load_robot
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceContext
from robotcore.kinds import Gamepad
from robotcore.kinds.gamepad import GamepadDescription
from tests.system.guest.bench import wait_until

PAD = GamepadDescription(kind="gamepad", name="pad")
STICK, BYTE = AbsInfo(0, -32768, 32767, 16, 128, 0), AbsInfo(0, 0, 255, 0, 0, 0)
EVENTS = {
    ecodes.EV_KEY: [ecodes.BTN_SOUTH, ecodes.BTN_NORTH, ecodes.BTN_TL],
    ecodes.EV_ABS: [
        *((axis, STICK) for axis in (ecodes.ABS_X, ecodes.ABS_Y, ecodes.ABS_RX, ecodes.ABS_RY)),
        *((axis, BYTE) for axis in (ecodes.ABS_Z, ecodes.ABS_RZ)),
    ],
}

Open = Callable[..., Gamepad]


def plug_in(name: str = "ACME Pad") -> UInput:
    return UInput(EVENTS, name=name, vendor=0x1234)  # type: ignore[arg-type]  # pairs of an axis and its limits


@pytest.fixture
def open_pad() -> Iterator[Open]:
    opened: list[Gamepad] = []

    def open_it(**settings: Any) -> Gamepad:
        opened.append(EventGamepadDriver(**settings).open(PAD, DeviceContext(load_robot("rover"), MonotonicClock())))
        return opened[-1]

    yield open_it
    for gamepad in opened:
        gamepad.close()


def move(pad: UInput, kind: int, code: int, value: int) -> None:
    pad.write(kind, code, value)
    pad.syn()


def test_axes_and_buttons_of_the_kernel_are_in_the_sample(open_pad: Open) -> None:
    with plug_in() as pad:
        gamepad = open_pad(device="acme")
        assert gamepad.format_sample(gamepad.read()) == "at rest"
        move(pad, ecodes.EV_ABS, ecodes.ABS_Y, -32768)
        move(pad, ecodes.EV_ABS, ecodes.ABS_RZ, 255)
        move(pad, ecodes.EV_KEY, ecodes.BTN_TL, 1)
        wait_until(lambda: gamepad.read().left_shoulder, expected=True)
        assert gamepad.format_sample(gamepad.read()) == "left_y 1.00, right_trigger 1.00, left_shoulder"


def test_unplugged_gamepad_is_lost_and_works_again(open_pad: Open) -> None:
    with plug_in() as pad:
        gamepad = open_pad()
        move(pad, ecodes.EV_ABS, ecodes.ABS_Y, -32768)
        assert wait_until(lambda: gamepad.read().left_y, 1.0) == 1.0
    with pytest.raises(DeviceLostError):
        gamepad.read()

    def read_left_y() -> float | None:
        try:
            return gamepad.read().left_y
        except DeviceLostError:
            return None

    with plug_in():
        assert wait_until(read_left_y, 0.0) == 0.0


def test_a_mouse_or_nothing_is_refused(open_pad: Open) -> None:
    with UInput({ecodes.EV_KEY: [ecodes.BTN_LEFT], ecodes.EV_REL: [ecodes.REL_X]}), pytest.raises(DeviceError):
        open_pad()


class Await(Behaviour):
    """Takes the gamepad away in the tenth tick, as the person would."""

    needs = frozenset({Gamepad})
    pad: UInput

    def step(self, robot: Robot) -> Status:
        (gamepad,) = robot.all(Gamepad)
        gamepad.read()
        if robot.clock.now() > 0.5:
            type(self).pad.close()
        return Status.RUNNING


def test_run_ends_with_an_error_if_its_gamepad_is_unplugged(tmp_path: Path) -> None:
    file = tmp_path / "driven.toml"
    rover = (Path(robotcore.__file__).parent / "description" / "robots" / "rover.toml").read_text()
    table = '\n[[devices]]\nkind = "gamepad"\nname = "pad"\n\n[serial.pad]\ndriver = "gamepad"\n'
    file.write_text(rover.replace('name = "rover"', 'name = "driven"') + table)
    Await.pad = plug_in()
    result = robotcore.run(RunRequest(Await, robot=str(file), backend="serial", timeout_s=30.0))
    assert result.outcome is Outcome.ERROR
    assert "is gone" in result.reason
