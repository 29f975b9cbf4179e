"""The stage of a replay: each command is held to the recorded one, and answered as that was."""

from __future__ import annotations

from contextlib import suppress
from typing import NoReturn

from robotcore.errors import RobotcoreError, SafetyStop
from robotcore.geometry import Wheels
from robotcore.recording import Ask, Raised
from robotcore.recording.replay.deviation import wheels_told
from robotcore.recording.replay.likeness import Likeness
from robotcore.recording.replay.script import Script
from robotcore.safety import Commit, Latch
from robotcore.safety.intervention import REST

_NONE = "no command"


class ReplayedStage:
    """Stands where the safety stage stood; what that answered, lessened, cut or refused comes from the recording.

    Between ticks, where the loop and those who close a robot stop the wheels, it lets everything pass.
    """

    def __init__(self, script: Script, likeness: Likeness, latch: Latch) -> None:
        self._script, self._is_alike, self._latch = script, likeness, latch
        self._asked: Wheels | None = None
        self._is_in_tick = False
        self.is_committed = False

    def begin_tick(self) -> None:
        """Expect the commands of the next tick. May be called again in it."""
        if not self._is_in_tick:
            self._asked, self._is_in_tick, self.is_committed = None, True, False

    def end_tick(self) -> None:
        """Expect none any more."""
        self._is_in_tick = False

    @property
    def asked(self) -> Wheels:
        return self._script.cues.next_standing()

    def ask(self, wheels: Wheels) -> Wheels:
        answered = self._answered(wheels)
        if answered.error:
            again(answered.error, self._latch)
        self._asked = wheels
        return answered.given or wheels

    def stop(self) -> None:
        if not self._is_in_tick:
            return
        self._asked = REST
        if error := self._answered(None).error:
            again(error, self._latch)

    def commit(self) -> Commit:
        script, tick = self._script, self._script.cues.tick
        script.check()
        if script.cues.is_cut_short:
            script.end()
        self.require_all()
        if tick.error and not script.cues.was_committed:
            self._fail(tick.error)
        if not self._is_alike(tick.asked, self._asked):
            script.deviate("the command of the tick", wheels_told(tick.asked), wheels_told(self._asked))
        self.is_committed = True
        if tick.error:
            with suppress(RobotcoreError):
                again(tick.error, self._latch)
        return Commit(self._asked, tick.sent, tick.interventions)

    def require_all(self) -> None:
        """Deviate where the recorded run gave a command more in this tick."""
        if left := self._script.cues.asks:
            self._script.deviate("the command", wheels_told(left[0].asked), _NONE)

    def _answered(self, wheels: Wheels | None) -> Ask:
        """Return the recorded command that this one is like; None is a stop."""
        self._script.check()
        recorded = self._script.cues.next_ask()
        if recorded is None:
            self._script.lack("the command", _NONE, wheels_told(wheels))
        if not self._is_alike(recorded.asked, wheels):
            self._script.deviate("the command", wheels_told(recorded.asked), wheels_told(wheels))
        return recorded

    def _fail(self, recorded: Raised) -> NoReturn:
        """Raise what ended the recorded run at the end of this tick; a deviation where it had ended before."""
        if not (self._script.cues.tick.commit_error or isinstance(recorded.again(), SafetyStop)):
            self._script.deviate("the end", f"raised {recorded.kind}: {recorded.message}", "the app goes on")
        again(recorded, self._latch)


def again(recorded: Raised, latch: Latch) -> NoReturn:
    """Raise what was raised in the recording; a safety stop latches."""
    error = recorded.again()
    if isinstance(error, SafetyStop):
        latch.trip(error)
    raise error
