"""The keys of a terminal with which a person drives a robot."""

from __future__ import annotations

import re

from robotcore.hal.clock import Clock
from robotcore.hal.drive import DifferentialDrive
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.operator_input import OperatorInput

HELP = (
    "Drive: arrow keys or WASD, Q and E for arcs. A tap is a slow step; hold a key to go on. X: stand. "
    "+ and -: speed limit. R: return the robot to the app. Space: e-stop. Ctrl-C: end"
)

DIRECTIONS = {
    "w": (1.0, 0.0),
    "s": (-1.0, 0.0),
    "a": (0.0, 1.0),
    "d": (0.0, -1.0),
    "q": (1.0, 0.5),
    "e": (1.0, -0.5),
}
"""The direction of each key: forward, and to the left. Each is a ratio to the velocities of the speed limit."""

FIRST_S = 0.65
"""The time in seconds for which the first press of a key drives. Most keyboards repeat a held key after 0.25 to 0.6 s.

A terminal does not report the release of a key, so the robot drives on for the rest of this time.
"""

REPEAT_S = 0.25
"""The time in seconds for which each repetition of a key drives. A terminal repeats a key at least ten times a second.

So the robot stops after this time at the latest when the person releases a key that was held.
"""

TAP_SCALE = 0.5
"""The ratio of the velocity of a first press to that of a held key."""

TURN_SCALE = 0.5
"""The ratio of the turn rate at a speed limit of 100 % to the greatest turn rate of the drive, which is too fast."""

SPEEDS = [step / 10 for step in range(1, 11)]
"""The speed limits, as ratios to the greatest velocities of the drive."""

UPDATE_S = 0.05
"""The interval at which `DrivingKeys.update` must be called, in seconds: a quarter of the lease."""

_ARROW = re.compile(rb"\x1b[\[O][0-9;]*([ABCD])")
_ARROWS = {b"A": b"w", b"B": b"s", b"C": b"d", b"D": b"a"}
_OTHER_SEQUENCE = re.compile(rb"\x1b[\[O][0-9;]*[A-Za-z~]")
_WITH_ALT = re.compile(rb"\x1b[^\[O\x1b]")
_BEGUN_SEQUENCE = re.compile(rb"\x1b([\[O][0-9;]{0,8})?$")


class DrivingKeys:
    """Turns the keys of a terminal into the commands of a person.

    A terminal reports no release of a key. So the first press of a key drives for `FIRST_S`, at a reduced velocity. The
    keyboard repeats a key that is held, and each repetition drives for `REPEAT_S`. Then the robot stands.

    operator: the input of the run.
    drive: the robot's drive, with its greatest velocities.
    clock: the machine's clock.
    """

    def __init__(self, operator: OperatorInput, drive: DifferentialDrive, clock: Clock | None = None) -> None:
        self._operator, self._drive = operator, drive
        self._clock = clock or MonotonicClock()
        self._speed = SPEEDS.index(0.5)
        self._key, self._until, self._is_held = "", 0.0, False
        self._has_taken = False
        self._calls = 0
        self._begun = b""

    @property
    def hint(self) -> str:
        """The speed limit, and whether the person drives, for the progress line."""
        return f"{'driving' if self._has_taken else 'WASD: drive'}, speed {SPEEDS[self._speed]:.0%}"

    def press(self, keys: bytes) -> None:
        """Carry out keys as a terminal reports them."""
        for key in self._split(keys).decode("latin-1").lower():
            if key in DIRECTIONS:
                self._press_direction(key)
            elif key in "+=":
                self._speed = min(self._speed + 1, len(SPEEDS) - 1)
            elif key in "-_":
                self._speed = max(self._speed - 1, 0)
            elif key == "x":
                self._key, self._has_taken = "", True
            elif key == "r":
                self._key, self._has_taken = "", False
                self._operator.release()
        self._renew()

    def update(self) -> None:
        """Renew the velocity, also that of a robot that stands. Call this every `UPDATE_S`.

        After a command or a release by another sender, such as a web page, the keys do nothing until the next key.
        """
        if self._operator.calls != self._calls:
            self._key, self._has_taken = "", False
        self._renew()

    def _renew(self) -> None:
        if self._key and self._clock.now() >= self._until:
            self._key = ""
        if self._has_taken:
            self._operator.drive(*self._choose_velocity())
        self._calls = self._operator.calls

    def stand(self) -> None:
        """Let the robot stand until the next key, such as during a suspension of the program."""
        self._key = ""
        self.update()

    def _press_direction(self, key: str) -> None:
        now = self._clock.now()
        self._is_held = key == self._key and now < self._until
        self._until = now + (REPEAT_S if self._is_held else FIRST_S)
        self._key, self._has_taken = key, True

    def _choose_velocity(self) -> tuple[float, float]:
        if not self._key:
            return 0.0, 0.0
        forward, left = DIRECTIONS[self._key]
        scale = SPEEDS[self._speed] * (1.0 if self._is_held else TAP_SCALE)
        linear = scale * self._drive.max_linear
        if radius := self._drive.min_turn_radius:  # it turns only while it drives
            return (forward or 1.0) * linear, left * linear / radius
        return forward * linear, left * scale * TURN_SCALE * self._drive.max_angular

    def _split(self, keys: bytes) -> bytes:
        """Return the keys with a letter for each arrow key. The begin of an escape sequence waits for its end."""
        keys = self._begun + _WITH_ALT.sub(b"", keys)
        keys = _ARROW.sub(lambda found: _ARROWS[found[1]], keys)
        keys = _OTHER_SEQUENCE.sub(b"", keys)
        begun = _BEGUN_SEQUENCE.search(keys)
        self._begun = begun[0] if begun else b""
        return keys[: len(keys) - len(self._begun)]
