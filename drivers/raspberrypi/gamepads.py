"""The driver of gamepads on USB or Bluetooth, which reads the kernel's event devices.

Source: the kernel's gamepad specification, https://docs.kernel.org/input/gamepad.html.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import Clock
from robotcore.hal.sampling import SampleCache
from robotcore.hardware import Connection, DeviceContext, DeviceDriver
from robotcore.kinds.gamepad import TRIGGERS, Gamepad, GamepadDescription, GamepadSample

NODES = Path("/dev/input")
"""The folder of the event devices."""

BUTTONS = {
    "south": "BTN_SOUTH",
    "east": "BTN_EAST",
    "north": "BTN_NORTH",
    "west": "BTN_WEST",
    "left_shoulder": "BTN_TL",
    "right_shoulder": "BTN_TR",
    "left_stick": "BTN_THUMBL",
    "right_stick": "BTN_THUMBR",
    "select": "BTN_SELECT",
    "start": "BTN_START",
    "mode": "BTN_MODE",
    "dpad_up": "BTN_DPAD_UP",
    "dpad_down": "BTN_DPAD_DOWN",
    "dpad_left": "BTN_DPAD_LEFT",
    "dpad_right": "BTN_DPAD_RIGHT",
}
"""The kernel's name of each button."""

MICROSOFT = 0x045E
"""The vendor of Xbox pads. The kernel reports their upper button as BTN_WEST and their left one as BTN_NORTH, by the
letters on them. Source: the kernel's xpad driver, and BTN_X and BTN_Y in input-event-codes.h."""

AXES: Mapping[str, tuple[str, ...]] = {
    "left_x": ("ABS_X",),
    "left_y": ("ABS_Y",),
    "right_x": ("ABS_RX", "ABS_Z"),
    "right_y": ("ABS_RY", "ABS_RZ"),
    "left_trigger": ("ABS_HAT2Y", "ABS_BRAKE", "ABS_Z"),
    "right_trigger": ("ABS_HAT2X", "ABS_GAS", "ABS_RZ"),
    "dpad_x": ("ABS_HAT0X",),
    "dpad_y": ("ABS_HAT0Y",),
}
"""The kernel's names of each axis. The first one that the pad has, and that no axis before has, counts.

Most drivers have the triggers on ABS_Z and ABS_RZ. Pads without ABS_RX have the right stick there.
"""

TRIGGER_BUTTONS = {"left_trigger": "BTN_TL2", "right_trigger": "BTN_TR2"}
"""The kernel's names of triggers that are only buttons."""

SEARCH_S = 0.5
"""The time between two searches for a lost gamepad, in seconds."""


class EventGamepadDriver(DeviceDriver):
    """Opens gamepads by the kernel's event devices."""

    name = "gamepad"
    summary = "a gamepad on USB or Bluetooth"
    described = GamepadDescription
    aliases = ("joystick", "controller", "evdev")
    modules = ("evdev",)
    remedy = "pip install 'robotcore[gamepad]'"

    device: Annotated[str, Field(min_length=1, max_length=256)] | None = None
    """The event device, such as ``/dev/input/by-id/…-event-joystick``, or a part of the gamepad's name.

    With None, the only gamepad is opened.
    """

    dead_zone: Annotated[float, Field(ge=0, le=0.9)] = 0.1
    """An axis that is nearer than this to its rest position is 0. Outside it, the value rises from 0 to 1."""

    max_silence_s: Annotated[float, Field(ge=0, le=3600)] = 2.0
    """The gamepad counts as lost if nothing changes for this time while a stick or a button is held, in seconds.

    The kernel reports a wireless gamepad out of range only after up to 30 s. With 0, such a gamepad is not lost before.
    """

    @property
    def place(self) -> str:
        return self.device or "the only gamepad"

    def connections(self) -> Sequence[Connection]:
        return (Connection("gamepad", "input", self.place),)

    def notes(self, description: GamepadDescription) -> Sequence[str]:
        return ("Plug the gamepad in, or pair it by bluetoothctl. It needs no wires.",)

    def open(self, description: GamepadDescription, context: DeviceContext) -> Gamepad:
        pad = EventGamepad(description.name, self, context.clock)
        pad.open()
        return pad

    def find(self, device: str) -> Any:
        """Open and return evdev's object of the gamepad. Raises DeviceError if there is none, or more than one.

        device: the name of the device, for errors.
        """
        pads, is_refused = list_pads()
        wanted = self.device
        if wanted and wanted.startswith("/"):
            chosen = [pad for pad in pads if Path(pad.path).resolve() == Path(wanted).resolve()]
        else:
            chosen = [pad for pad in pads if not wanted or wanted.casefold() in pad.name.casefold()]
        names = ", ".join(f"{pad.path} ({pad.name})" for pad in pads)
        for pad in pads:
            if len(chosen) != 1 or pad is not chosen[0]:
                pad.close()
        if len(chosen) == 1:
            return chosen[0]
        if chosen:
            message = f"there are several gamepads: {names}. Set device to the name or the file of one of them"
            raise DeviceError(device, message, kind="several-gamepads")
        if is_refused:
            message = f"no permission for {NODES}. Run sudo usermod -aG input $USER, then log out and in again"
            raise DeviceError(device, message, kind="gamepad-no-permission")
        what = f"{wanted!r} was not found" if wanted else "no gamepad was found"
        there = f"There are: {names}" if names else "Plug it in, or switch it on and pair it: bluetoothctl"
        raise DeviceError(device, f"{what}. {there}", kind="gamepad-missing")


def list_pads() -> tuple[list[Any], bool]:
    """Return evdev's open objects of all gamepads, and whether the permission for another event device is missing."""
    from evdev import InputDevice, ecodes

    pads, is_refused = [], False
    for node in sorted(NODES.glob("event*"), key=lambda node: int(re.sub(r"\D", "", node.name) or 0)):
        try:
            pad = InputDevice(str(node))
        except PermissionError:
            is_refused = True
            continue
        except OSError:  # it is gone, or no input device
            continue
        if ecodes.BTN_GAMEPAD in pad.capabilities().get(ecodes.EV_KEY, ()):
            pads.append(pad)
        else:
            pad.close()
    return pads, is_refused


class State(NamedTuple):
    """The raw values of a gamepad's axes by their codes, and the codes of its pressed buttons."""

    axes: dict[int, int]
    keys: frozenset[int]


class Layout:
    """The axes and the buttons of one gamepad."""

    def __init__(self, pad: Any) -> None:
        from evdev import ecodes

        capabilities = pad.capabilities(absinfo=True)
        self.limits = {code: (info.min, info.max) for code, info in capabilities.get(ecodes.EV_ABS, ())}
        self._keys = {name: getattr(ecodes, code) for name, code in (BUTTONS | TRIGGER_BUTTONS).items()}
        if pad.info.vendor == MICROSOFT:
            self._keys |= {"north": ecodes.BTN_WEST, "west": ecodes.BTN_NORTH}
        self.axes: dict[str, int] = {}
        for name, codes in AXES.items():
            present = [code for code in (getattr(ecodes, each) for each in codes) if code in self.limits]
            if free := [code for code in present if code not in self.axes.values()]:
                self.axes[name] = free[0]

    def read(self, pad: Any) -> State:
        """Return the present state of the gamepad. Raises OSError if it is gone."""
        return State({code: pad.absinfo(code).value for code in self.axes.values()}, frozenset(pad.active_keys()))

    def to_values(self, state: State, rest: Mapping[int, int], dead_zone: float) -> dict[str, Any]:
        """Return the fields of a sample.

        rest: the raw values at the opening of the axes that have not moved since then. Their values are 0.
        """
        values = dict.fromkeys(AXES, 0.0)
        for name, code in self.axes.items():
            if code not in rest:
                values[name] = self._scale(code, state.axes[code], dead_zone, is_trigger=name in TRIGGERS)
        pressed = {name: code in state.keys for name, code in self._keys.items()}
        across, down = values.pop("dpad_x"), values.pop("dpad_y")
        for side, value in (("left", -across), ("right", across), ("up", -down), ("down", down)):
            pressed[f"dpad_{side}"] |= value > 0.5
        for name in TRIGGERS:
            if pressed.pop(name) and name not in self.axes:
                values[name] = 1.0
        return {**values, "left_y": -values["left_y"], "right_y": -values["right_y"], **pressed}

    def _scale(self, code: int, raw: int, dead_zone: float, *, is_trigger: bool) -> float:
        least, greatest = self.limits[code]
        if least >= greatest:
            return 0.0
        share = min(max((raw - least) / (greatest - least), 0.0), 1.0)
        value = share if is_trigger else 2 * share - 1
        size = (abs(value) - dead_zone) / (1 - dead_zone)
        return 0.0 if size <= 0 else size if value > 0 else -size


class EventGamepad(Gamepad):
    """A gamepad that the kernel reports. Each new sample reads its present state.

    An axis is 0 until it has moved, because some drivers report no rest position before the first motion. If the
    gamepad is lost, each read raises DeviceLostError, and searches for the gamepad once in a while.
    """

    def __init__(self, name: str, settings: EventGamepadDriver, clock: Clock) -> None:
        super().__init__(name)
        self._settings, self._clock, self._lock = settings, clock, Lock()
        self._pad: Any = None
        self._searched_at = self._changed_at = 0.0
        self._newest_at = SampleCache(clock, self._take)

    def open(self) -> None:
        """Find the gamepad and open it; raises DeviceError if it is not found."""
        self._connect(self._settings.find(self.name))

    def _connect(self, pad: Any) -> None:
        try:
            self._layout = Layout(pad)
            self._state = self._layout.read(pad)
        except BaseException:
            pad.close()
            raise
        self._pad, self._changed_at = pad, self._clock.now()
        self._rest = dict(self._state.axes)

    def _newest(self) -> GamepadSample:
        with self._lock:
            return self._newest_at()

    def _take(self, time: float, sequence: int) -> GamepadSample:
        if self._pad is None:
            self._search(time)
        try:
            state = self._layout.read(self._pad)
        except OSError as error:
            self._disconnect()
            self._searched_at = time
            raise self._build_loss() from error
        if state != self._state:
            self._state, self._changed_at = state, time
            self._rest = {code: raw for code, raw in self._rest.items() if state.axes[code] == raw}
        values = self._layout.to_values(state, self._rest, self._settings.dead_zone)
        silence, limit = time - self._changed_at, self._settings.max_silence_s
        if limit and silence > limit and any(values.values()):
            message = (
                f"nothing has changed for {silence:.1f} s while a stick or a button was held. Release it. If the "
                "gamepad is on a cable, max_silence_s = 0 switches this check off"
            )
            raise DeviceLostError(self.name, message, kind="gamepad-silent")
        return GamepadSample(**values, time=time, sequence=sequence)

    def _search(self, time: float) -> None:
        if time - self._searched_at < SEARCH_S:
            raise self._build_loss()
        self._searched_at = time
        try:
            self._connect(self._settings.find(self.name))
        except (DeviceError, OSError) as error:
            raise self._build_loss() from error

    def _build_loss(self) -> DeviceLostError:
        return DeviceLostError(self.name, f"{self._settings.place} is gone. Plug it in again, or switch it on")

    def _disconnect(self) -> None:
        pad, self._pad = self._pad, None
        if pad is not None:
            with suppress(OSError):
                pad.close()

    def _release(self) -> None:
        with self._lock:
            self._disconnect()
