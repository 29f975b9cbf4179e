"""A motor outside the drive, as a replay has it: each command is held to the recorded one, and answered as that was."""

from __future__ import annotations

from robotcore.hal.devices import Motor
from robotcore.recording import MotorAsk
from robotcore.recording.replay.deviation import motor_told
from robotcore.recording.replay.likeness import Likeness
from robotcore.recording.replay.script import Script
from robotcore.recording.replay.stage import again
from robotcore.runtime.layers.over import MotorOver
from robotcore.safety import Latch

_NONE = "no command"


class ReplayedMotor(MotorOver):
    """Turns nothing. Once the run is ended for good a stop is no command: robots are closed so."""

    def __init__(self, inner: Motor, script: Script, likeness: Likeness, latch: Latch) -> None:
        super().__init__(inner)
        self._script, self._is_alike, self._latch = script, likeness, latch

    def set_velocity(self, rad_s: float) -> float:
        self._require_open()
        given = self._answered(MotorAsk(self.name, rad_s)).given
        return 0.0 if given is None else given

    def stop(self) -> None:
        if not (self._is_closed or self._latch.error):
            self._answered(MotorAsk(self.name))

    def _answered(self, ask: MotorAsk) -> MotorAsk:
        """Return the recorded command that this one is like; raise what that raised."""
        self._script.check()
        asks = self._script.cues.motor_asks
        if not asks:
            self._script.lack("the command", _NONE, motor_told(ask))
        recorded = asks.popleft()
        if recorded.device != ask.device or not self._is_alike(_velocity(recorded), _velocity(ask)):
            self._script.deviate("the command", motor_told(recorded), motor_told(ask))
        if recorded.error:
            again(recorded.error, self._latch)
        return recorded

    def _apply(self, rad_s: float) -> None:
        self.set_velocity(rad_s)


def require_all(script: Script) -> None:
    """Deviate where the recorded run gave a motor a command more in this tick, unless it ended in it."""
    if (left := script.cues.motor_asks) and not script.cues.tick.error:
        script.deviate("the command", motor_told(left[0]), _NONE)


def _velocity(ask: MotorAsk) -> tuple[float] | None:
    return None if ask.asked is None else (ask.asked,)
