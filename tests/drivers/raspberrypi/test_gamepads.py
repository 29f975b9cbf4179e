"""Gamepads on a double of evdev's devices. On a kernel's own input device: tests/system/guest/gamepads.py."""

from __future__ import annotations

import errno
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import robotcore
from drivers.raspberrypi.doctor.devices import check_gamepads
from drivers.raspberrypi.gamepads import MICROSOFT, EventGamepadDriver
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceClosedError, DeviceError, DeviceLostError
from robotcore.hal.backend import load_backend
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceBinding, DeviceContext
from robotcore.kinds import Gamepad
from robotcore.kinds.gamepad import GamepadDescription
from tests.robotcore.description.files import ROVER
from tests.texts import CheckText, Raises

evdev = pytest.importorskip("evdev", reason="needs pip install 'robotcore[gamepad]'")
e = evdev.ecodes

PAD = GamepadDescription(kind="gamepad", name="pad")
STICK, BYTE, BIT = (-32768, 32767), (0, 255), (-1, 1)
XBOX = {e.ABS_X: STICK, e.ABS_Y: STICK, e.ABS_RX: STICK, e.ABS_RY: STICK, e.ABS_Z: BYTE, e.ABS_RZ: BYTE}
HATS = {e.ABS_HAT0X: BIT, e.ABS_HAT0Y: BIT}


class Info(NamedTuple):
    vendor: int


class FakePad:
    """An event device. ``axes`` has the present value of each axis, and ``keys`` the pressed buttons."""

    def __init__(self, limits: dict[int, tuple[int, int]], name: str = "Pad", vendor: int = 1) -> None:
        self.limits, self.name, self.info = limits, name, Info(vendor)
        self.axes = dict.fromkeys(limits, 0)
        self.keys: set[int] = set()
        self.buttons = [e.BTN_SOUTH]
        self.path, self.is_plugged_in, self.is_open = "", True, False

    def capabilities(self, *, absinfo: bool = True) -> dict[int, Any]:
        return {
            e.EV_KEY: self.buttons,
            e.EV_ABS: [(code, evdev.AbsInfo(0, *limits, 0, 0, 0)) for code, limits in self.limits.items()],
        }

    def absinfo(self, code: int) -> Any:
        self._require()
        return evdev.AbsInfo(self.axes[code], *self.limits[code], 0, 0, 0)

    def active_keys(self) -> list[int]:
        self._require()
        return sorted(self.keys)

    def close(self) -> None:
        self.is_open = False

    def _require(self) -> None:
        if not self.is_plugged_in:
            raise OSError(errno.ENODEV, "No such device")


class Bench:
    """The event devices of a computer, and a clock with steps of 10 ms."""

    def __init__(self, patch: pytest.MonkeyPatch, folder: Path) -> None:
        self.pads: dict[str, FakePad] = {}
        self.refused: set[str] = set()
        self.folder = folder
        self.clock = SteppedClock(100, lambda _steps: None)
        patch.setattr("drivers.raspberrypi.gamepads.NODES", folder)
        patch.setattr("evdev.InputDevice", self._open)

    def plug_in(self, pad: FakePad, node: str = "event3") -> FakePad:
        (self.folder / node).touch()
        pad.path, pad.is_plugged_in = str(self.folder / node), True
        self.pads[pad.path] = pad
        return pad

    def unplug(self, pad: FakePad) -> None:
        pad.is_plugged_in = False
        del self.pads[pad.path]
        Path(pad.path).unlink()

    def _open(self, path: str) -> FakePad:
        if path in self.refused:
            raise PermissionError(errno.EACCES, "Permission denied", path)
        if path not in self.pads:
            raise OSError(errno.EINVAL, "Invalid argument")
        self.pads[path].is_open = True
        return self.pads[path]

    def open(self, **settings: Any) -> Gamepad:
        gamepad = EventGamepadDriver(**settings).open(PAD, DeviceContext(load_robot("rover"), self.clock))
        assert isinstance(gamepad, Gamepad)
        return gamepad

    def wait(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Bench:
    return Bench(monkeypatch, tmp_path)


def test_sample_has_the_sticks_the_triggers_and_the_buttons(bench: Bench) -> None:
    pad = bench.plug_in(FakePad(XBOX | HATS))
    gamepad = bench.open(dead_zone=0.0)
    assert gamepad.format_sample(gamepad.read()) == "at rest"
    pad.axes |= {e.ABS_X: 32767, e.ABS_Y: -32768, e.ABS_RX: -16384, e.ABS_RY: 16384, e.ABS_Z: 51, e.ABS_RZ: 255}
    pad.axes |= {e.ABS_HAT0X: -1, e.ABS_HAT0Y: 1}
    pad.keys = {e.BTN_SOUTH, e.BTN_TR, e.BTN_THUMBL, e.BTN_MODE}
    bench.wait(0.01)
    sample = gamepad.read()
    sticks = sample.left_x, sample.left_y, sample.right_x, sample.right_y
    assert sticks == pytest.approx((1.0, 1.0, -0.5, -0.5), abs=1e-4)
    assert (sample.left_trigger, sample.right_trigger) == (0.2, 1.0)
    assert (sample.time, sample.sequence) == (0.01, 1)
    pressed = {"south", "right_shoulder", "left_stick", "mode", "dpad_left", "dpad_down"}
    assert {name for name in dir(sample) if getattr(sample, name) is True} == pressed


def test_axis_is_0_in_the_dead_zone_and_rises_from_0_outside_it(bench: Bench) -> None:
    pad = bench.plug_in(FakePad({e.ABS_X: (-100, 100)}))
    gamepad = bench.open(dead_zone=0.2)
    found = []
    for raw in (19, -19, 60, -60, 100, 120):
        pad.axes[e.ABS_X] = raw
        bench.wait(0.01)
        found.append(gamepad.read().left_x)
    assert found == pytest.approx([0.0, 0.0, 0.5, -0.5, 1.0, 1.0])


def test_axis_without_a_rest_position_is_0_until_it_moves(bench: Bench) -> None:
    """A pad from 0 to 255 whose driver reports nothing before the first motion would be at its left and far end."""
    pad = bench.plug_in(FakePad({e.ABS_X: BYTE, e.ABS_Y: BYTE}))
    gamepad = bench.open()
    assert (gamepad.read().left_x, gamepad.read().left_y) == (0.0, 0.0)
    pad.axes[e.ABS_X] = 255
    bench.wait(0.01)
    assert (gamepad.read().left_x, gamepad.read().left_y) == (1.0, 0.0)
    pad.axes[e.ABS_X] = 0
    bench.wait(0.01)
    assert gamepad.read().left_x == -1.0


@pytest.mark.parametrize(
    "limits, buttons, field",
    [
        ({e.ABS_RX: BYTE, e.ABS_Z: BYTE}, [], "left_trigger"),
        ({e.ABS_Z: BYTE, e.ABS_BRAKE: BYTE}, [], "right_x"),
        ({e.ABS_RX: BYTE, e.ABS_HAT2Y: BYTE, e.ABS_Z: BYTE}, [], "none"),
    ],
    ids=["trigger", "stick", "no meaning beside HAT2Y"],
)
def test_abs_z_is_a_trigger_or_the_right_stick(
    bench: Bench, limits: dict[int, tuple[int, int]], buttons: list[int], field: str
) -> None:
    pad = bench.plug_in(FakePad(limits))
    gamepad = bench.open()
    pad.axes[e.ABS_Z] = 255
    bench.wait(0.01)
    assert gamepad.format_sample(gamepad.read()) == (f"{field} 1.00" if field != "none" else "at rest")


def test_digital_triggers_and_pads_are_1_or_0_in_the_sample(bench: Bench) -> None:
    pad = bench.plug_in(FakePad({e.ABS_X: BYTE}))
    gamepad = bench.open()
    pad.keys = {e.BTN_TL2, e.BTN_DPAD_UP}
    bench.wait(0.01)
    assert gamepad.format_sample(gamepad.read()) == "left_trigger 1.00, dpad_up"


@pytest.mark.parametrize("vendor, button", [(MICROSOFT, "west"), (0x054C, "north")])
def test_buttons_are_named_by_their_place_on_xbox_pads_too(bench: Bench, vendor: int, button: str) -> None:
    pad = bench.plug_in(FakePad(XBOX, vendor=vendor))
    gamepad = bench.open()
    pad.keys = {e.BTN_NORTH}
    bench.wait(0.01)
    assert gamepad.format_sample(gamepad.read()) == button


@pytest.mark.parametrize("device", ["event7", "wireless", None])
def test_gamepad_is_found_by_its_path_its_name_or_as_the_only_one(bench: Bench, device: str | None) -> None:
    wanted, other = FakePad(XBOX, "ACME Wireless Pad"), FakePad({}, "Keyboard")
    other.buttons = [e.KEY_A]
    bench.plug_in(wanted, "event7")
    bench.plug_in(other, "event0")
    if device:
        bench.plug_in(FakePad(XBOX, "Other Pad"), "event12")
    bench.open(device=str(bench.folder / device) if device == "event7" else device)
    assert [pad.name for pad in bench.pads.values() if pad.is_open] == ["ACME Wireless Pad"]


def unplug_all(bench: Bench) -> None:
    pass


def plug_in_two(bench: Bench) -> None:
    bench.plug_in(FakePad(XBOX, "One"), "event1")
    bench.plug_in(FakePad(XBOX, "Two"), "event2")


def refuse(bench: Bench) -> None:
    bench.refused.add(bench.plug_in(FakePad(XBOX)).path)


@pytest.mark.parametrize(
    "arrange, settings, kind",
    [
        (unplug_all, {}, "gamepad-missing"),
        (plug_in_two, {}, "several-gamepads"),
        (plug_in_two, {"device": "three"}, "gamepad-missing"),
        (refuse, {}, "gamepad-no-permission"),
    ],
)
def test_gamepad_that_is_not_found_is_reported_with_a_remedy(
    bench: Bench, raises: Raises, arrange: Callable[[Bench], None], settings: dict[str, str], kind: str
) -> None:
    arrange(bench)
    with raises(DeviceError, kind, hide=[bench.folder]):
        bench.open(**settings)
    assert not any(pad.is_open for pad in bench.pads.values())


def test_unplugged_gamepad_is_lost_and_works_again_with_its_sticks_at_rest(bench: Bench, raises: Raises) -> None:
    pad = bench.plug_in(FakePad(XBOX))
    gamepad = bench.open()
    pad.axes[e.ABS_Y] = -32768
    bench.wait(0.01)
    assert gamepad.read().left_y == 1.0
    bench.unplug(pad)
    for _ in range(3):
        bench.wait(0.3)
        with pytest.raises(DeviceLostError):
            gamepad.read()
    with raises(DeviceLostError, "device-lost"):
        gamepad.read()
    bench.plug_in(pad, "event9")
    bench.wait(1.0)
    assert gamepad.read().left_y == 0.0
    pad.axes[e.ABS_Y] = -30000
    bench.wait(0.01)
    assert gamepad.read().left_y > 0.8


def test_held_stick_that_never_changes_is_a_lost_gamepad(bench: Bench, raises: Raises) -> None:
    """The kernel reports a wireless pad out of range late, and meanwhile its last values."""
    pad = bench.plug_in(FakePad(XBOX))
    gamepad = bench.open()
    bench.wait(10.0)
    assert gamepad.read().left_y == 0.0
    pad.axes[e.ABS_Y] = -32768
    bench.wait(0.01)
    gamepad.read()
    bench.wait(1.99)
    assert gamepad.read().left_y == 1.0
    bench.wait(0.02)
    with raises(DeviceLostError, "gamepad-silent"):
        gamepad.read()
    pad.axes[e.ABS_Y] = -32000
    bench.wait(0.01)
    assert gamepad.read().left_y > 0.9


def test_held_stick_is_no_loss_without_a_limit(bench: Bench) -> None:
    pad = bench.plug_in(FakePad(XBOX))
    gamepad = bench.open(max_silence_s=0)
    pad.keys = {e.BTN_SOUTH}
    bench.wait(0.01)
    gamepad.read()
    bench.wait(3600.0)
    assert gamepad.read().south


def test_closing_closes_the_event_device(bench: Bench) -> None:
    pad = bench.plug_in(FakePad(XBOX))
    gamepad = bench.open()
    gamepad.close()
    assert not pad.is_open
    with pytest.raises(DeviceClosedError):
        gamepad.read()


def test_missing_library_is_reported_with_its_remedy(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setitem(sys.modules, "evdev", None)
    with raises(DeviceError, "library-missing"):
        DeviceBinding(PAD, EventGamepadDriver()).open(DeviceContext(load_robot("rover"), bench.clock))


def test_wiring_names_the_gamepad(check_text: CheckText) -> None:
    check_text(
        "\n".join(map(str, [*EventGamepadDriver(device="Xbox").connections(), *EventGamepadDriver().notes(PAD)]))
    )


def test_doctor_reports_a_missing_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "evdev", None)
    (found,) = check_gamepads([DeviceBinding(PAD, EventGamepadDriver())])
    assert found.kind == "library-missing"


def test_doctor_reports_the_gamepad(bench: Bench) -> None:
    bindings = [DeviceBinding(PAD, EventGamepadDriver())]
    (missing,) = check_gamepads(bindings)
    assert missing.kind == "gamepad-missing"
    pad = bench.plug_in(FakePad(XBOX, "ACME Pad"))
    (found,) = check_gamepads(bindings)
    assert (found.kind, pad.is_open) == ("gamepad-found", False)


class Steer(Behaviour):
    """Drives as the gamepad says."""

    needs = frozenset({Role.DRIVE, Gamepad})

    def step(self, robot: Robot) -> Status:
        (gamepad,) = robot.all(Gamepad)
        sample = gamepad.read()
        robot.drive.set_velocity(0.2 * sample.left_y, -sample.right_x)
        return Status.SUCCESS if sample.south else Status.RUNNING


def test_on_virtual_pins_the_script_of_the_robots_file_replaces_the_gamepad(tmp_path: Path) -> None:
    file = tmp_path / "pad.toml"
    script = "script = [{ at_s = 0, left_y = 1.0 }, { at_s = 1, south = true }]"
    file.write_text(
        f'{ROVER}\n[[devices]]\nkind = "gamepad"\nname = "pad"\n{script}\n\n[raspberrypi.pad]\ndriver = "gamepad"\n'
    )
    result = robotcore.run(RunRequest(Steer, robot=str(file), backend="virtualpi", world="open"))
    assert (result.outcome, result.sim_time_s) == (Outcome.SUCCESS, 1.0)


def write_robot(folder: Path, *tables: str) -> str:
    file = folder / "driven.toml"
    file.write_text("\n\n".join((ROVER, '[[devices]]\nkind = "gamepad"\nname = "pad"', *tables)))
    return str(file)


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet"])
def test_real_gamepad_drives_a_simulated_robot(bench: Bench, tmp_path: Path, backend: str) -> None:
    pad = bench.plug_in(FakePad(XBOX))

    class Push(Steer):
        """Moves the sticks as the person does, and presses the lowest button after a second."""

        def step(self, robot: Robot) -> Status:
            pad.axes[e.ABS_Y] = -32768
            pad.keys = {e.BTN_SOUTH} if robot.clock.now() >= 1.0 else set()
            status = super().step(robot)
            self.reason = f"{robot.drive.pose.x:.2f}"
            return status

    robot = write_robot(tmp_path, f'[{backend}.pad]\ndriver = "gamepad"')
    result = robotcore.run(RunRequest(Push, robot=robot, backend=backend, world="open"))
    assert (result.outcome, result.sim_time_s) == (Outcome.SUCCESS, 1.0)
    assert float(result.reason) == pytest.approx(0.17, abs=0.03)
    assert not pad.is_open


def test_gamepad_that_is_not_there_ends_a_simulation_that_needs_it(bench: Bench, tmp_path: Path) -> None:
    robot = write_robot(tmp_path, '[kinematic.pad]\ndriver = "gamepad"')
    result = robotcore.run(RunRequest(Steer, robot=robot, world="open"))
    assert result.outcome is Outcome.ERROR
    assert "no gamepad was found" in result.reason
    without = tmp_path / "nowhere.toml"
    without.write_text(Path(robot).read_text().replace("[kinematic.pad]", "[mujoco.pad]"))
    assert robotcore.run(RunRequest(Steer, robot=str(without), world="open", timeout_s=0.2)).outcome is Outcome.TIMEOUT


@pytest.mark.parametrize(
    "table, kind",
    [
        ('[kinematic.nose]\ndriver = "hc-sr04"\ntrigger = 16\necho = 26', "unknown-pin"),
        ('[kinematic.left_motor]\ndriver = "waveshare-motor"\nside = "left"\nport = "/dev/ttyUSB0"', "unknown-pin"),
        ('[kinematic.pad]\ndriver = "gamepad"\ndead_zone = 2', "out-of-bounds"),
    ],
)
def test_simulator_opens_no_other_real_device(tmp_path: Path, raises: Raises, table: str, kind: str) -> None:
    robot = write_robot(tmp_path, table)
    with raises(DescriptionError, kind):
        load_backend("kinematic").check(load_robot(robot))
    assert robotcore.run(RunRequest(Steer, robot=robot, world="open")).outcome is Outcome.ERROR
