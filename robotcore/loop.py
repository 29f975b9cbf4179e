"""The tick: read (lazily, once), decide, guard, commit once, let time pass."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from robotcore.behaviour import Behaviour, Status
from robotcore.errors import BehaviourError, Interrupted, RobotcoreError, UsageError
from robotcore.layers import Assembled
from robotcore.outcome import Outcome
from robotcore.safety import Commit
from robotcore.trace import TickRecord, Trace

TickObserver = Callable[[TickRecord], None]

_IDLE = Commit(None, None, ())


class Loop:
    """Runs a behaviour on a robot until it ends, or until ``timeout`` seconds of the robot's time."""

    def __init__(
        self,
        assembled: Assembled,
        behaviour: Behaviour,
        rate_hz: float,
        timeout: float,
        observers: Sequence[TickObserver] = (),
    ) -> None:
        self.robot, self._clock = assembled.robot, assembled.clock
        self._latch, self._stage = assembled.latch, assembled.stage
        self._drive = assembled.robot.drive if assembled.stage else None
        self.behaviour = behaviour
        self.trace = Trace(behaviour.milestones)
        self.overruns = 0
        self._period = 1 / rate_hz
        self._timeout = timeout
        self._observers = tuple(observers)
        self._next = self._clock.now()

    def run(self) -> Outcome:
        """Tick until the end; return how it ended. The wheels then stand."""
        while True:
            status = self.tick()
            if status is not Status.RUNNING:
                self.halt()
                return Outcome(status.value)
            if self._clock.now() >= self._timeout:
                self.halt()
                return Outcome.TIMEOUT
            self._let_time_pass()

    def tick(self) -> Status:
        """Decide once, guard and commit what was decided, and note it; a tick that fails is noted too."""
        if self._drive:
            self._drive.track()
        commit = _IDLE
        try:
            status = self._decide()
            self._latch.check()
            if self._stage:
                commit = self._stage.commit()
        finally:
            self._note(commit)
        return status

    def halt(self) -> None:
        """Stop the wheels."""
        if self._stage:
            self._stage.stop()

    def _note(self, commit: Commit) -> None:
        record = TickRecord(self._clock.tick, self._clock.now(), self.behaviour.state, *commit)
        self.trace.add(record)
        for observe in self._observers:
            observe(record)

    def _decide(self) -> Status:
        app = type(self.behaviour)
        try:
            status = self.behaviour.step(self.robot)
        except UsageError as error:
            raise BehaviourError.raised_by(app, error) from error
        except (RobotcoreError, Interrupted):
            raise
        except BaseException as error:
            self._latch.check()
            raise BehaviourError.raised_by(app, error) from error
        if not isinstance(status, Status):
            raise BehaviourError(
                f"{app.__name__}.step returned {status!r}; it must return a Status, such as Status.RUNNING"
            )
        return status

    def _let_time_pass(self) -> None:
        self._next += self._period
        if not self._clock.sleep_until(self._next):
            self.overruns += 1
            self._next = self._clock.now()
