"""The tick: read (lazily, once), decide, guard, commit once, let time pass."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial

from robotcore.errors import BehaviourError, DeviceError, DeviceLostError, Interrupted, RobotcoreError, UsageError
from robotcore.hal.devices import Motor, Sensor
from robotcore.hal.drive import DifferentialDrive
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import Assembled
from robotcore.runtime.monitors import BatteryMonitor, DeviceLossTracker
from robotcore.runtime.result import Outcome
from robotcore.runtime.signals import WatchdogInterrupt
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.safety import LOST, Commit, Intervention, TimeLimit

TickObserver = Callable[[TickRecord], None]

COPY_STATUS = 1
"""The exit status of a copy of the process."""

_COPY_ENDED = (
    "error: {}.step returned in process {}, which os.fork made as a copy of the run's process. The copy ends, the run "
    "goes on. Start other programs with subprocess, and Python functions with multiprocessing\n"
)
_IDLE = Commit(None, None, ())


class Loop:
    """Runs a behaviour on a robot until it ends, or until ``timeout`` seconds of the robot's time.

    ``stepping`` and ``watching`` are what a watchdog is told of the app's step and of the observers. A device that is
    lost may be away for ``outage`` seconds: the robot stands meanwhile, and the app is not asked.
    """

    def __init__(
        self,
        assembled: Assembled,
        behaviour: Behaviour,
        rate_hz: float,
        timeout: float,
        observers: Sequence[TickObserver] = (),
        stepping: TimeLimit | None = None,
        watching: TimeLimit | None = None,
        outage: float = 0.0,
    ) -> None:
        self.robot, self._clock = assembled.robot, assembled.clock
        self._latch, self._stage, self._where = assembled.latch, assembled.stage, assembled.where
        self._reserve = assembled.brakes.reserve
        self._stepping, self._watching = stepping, watching
        self._stop_and_wait = partial(assembled.halt, LOST)
        self.outages = DeviceLossTracker(outage)
        self._drive = assembled.robot.drive if assembled.stage else None
        self.behaviour = behaviour
        self.trace = Trace(behaviour.milestones)
        self.overruns = 0
        self._period = 1 / rate_hz
        self._timeout = timeout
        self._observers = tuple(observers)
        self._next = self._clock.now()
        self._process = os.getpid()
        self._gauges = BatteryMonitor(assembled.robot)
        self._warnings: tuple[str, ...] = ()
        self._is_latch_noted = False
        self._noted = -1

    @property
    def time(self) -> float:
        """The robot's time at the last tick, in seconds."""
        return self._clock.now()

    @property
    def unreported_interventions(self) -> Sequence[Intervention]:
        """What stopped the robot for good in a tick that has not come back to tell it."""
        is_reported = self._latch.error is None or self._is_latch_noted
        return () if is_reported else self._latch.interventions(self._clock.now())

    def run(self) -> Outcome:
        """Tick until the end; return how it ended. The wheels then stand.

        Raises what the latch has, whatever else is raised: the one is why the other came.
        """
        try:
            return self._run()
        except BaseException:
            if self._latch.error and not self._is_latch_noted:
                self._note(_IDLE)
            self._latch.check()
            raise

    def _run(self) -> Outcome:
        while True:
            status = self._tick_or_stand()
            if status is not Status.RUNNING:
                self.halt()
                return Outcome(status.value)
            if self._clock.now() >= self._timeout:
                self.halt()
                return Outcome.TIMEOUT
            self._let_time_pass()

    def _tick_or_stand(self) -> Status:
        """Tick; stand where a device is lost that may come back."""
        try:
            status = self.tick()
        except DeviceLostError as lost:
            self._tolerate(lost)
            return Status.RUNNING
        self.outages.end(self._clock.now())
        return status

    def _tolerate(self, lost: DeviceLostError) -> None:
        """Stand without a device that is lost; raise that it is, where it has been away for too long."""
        if not self.outages.tolerates(lost, self._clock.now()):
            raise lost
        self._stop_and_wait()

    def tick(self) -> Status:
        """Decide once, guard and commit what was decided, and note it; a tick that fails is noted too."""
        self._latch.check()
        self._where.ticks += 1
        if self._drive:
            self._track(self._drive)
        self._warnings += self._gauges.read(self._clock.now())
        commit, lost = _IDLE, None
        try:
            self._probe_lost_devices()
            status = self._decide()
            self._latch.check()
            if self._stage:
                commit = self._stage.commit()
        except DeviceLostError as error:
            lost = error.device
            raise
        finally:
            self._note(commit, lost)
        return status

    def halt(self) -> None:
        """Stop the wheels."""
        if self._stage:
            self._stage.stop()

    def _probe_lost_devices(self) -> None:
        """Ask all that was lost whether it is back; raises DeviceLostError where it is not.

        A display is not asked: whoever shows something on it hears.
        """
        for name in self.outages.lost:
            match self.robot.devices.get(name):
                case Sensor() as sensor:
                    sensor.read()
                case Motor() as motor:
                    motor.stop()

    @staticmethod
    def _track(drive: DifferentialDrive) -> None:
        """Let the drive take in what the wheels turned; of what fails, whoever drives or asks for the pose is told."""
        try:  # noqa: SIM105  `suppress` takes ten times as long, at each tick
            drive.track()
        except DeviceError:
            pass

    def _note(self, commit: Commit, lost: str | None = None) -> None:
        """Tell what a tick came to. A latch that trips between two ticks is told as the one that did not come."""
        self._where.begin(self._watching)
        if self._latch.error and not self._is_latch_noted:
            commit = self._with_latch(commit)
        tick = self._clock.tick + (self._clock.tick == self._noted)
        self._noted = tick
        warnings, self._warnings = self._warnings, ()
        battery_data = self._gauges.voltages, warnings
        record = TickRecord(tick, self._clock.now(), self._state(), *commit, lost, *battery_data)
        self.trace.add(record)
        for observe in self._observers:
            observe(record)

    def _state(self) -> str:
        try:
            return self.behaviour.state
        except Exception as error:  # a property of the app's own
            raise BehaviourError.raised_by(type(self.behaviour), error) from error

    def _with_latch(self, commit: Commit) -> Commit:
        self._is_latch_noted = True
        return commit._replace(interventions=(*commit.interventions, *self._latch.interventions(self._clock.now())))

    def _decide(self) -> Status:
        app = type(self.behaviour)
        self._where.begin(self._stepping)
        try:
            status = self._step()
        except UsageError as error:
            raise BehaviourError.raised_by(app, error) from error
        except (RobotcoreError, Interrupted, WatchdogInterrupt):
            raise
        except BaseException as error:
            self._reserve.release_memory()
            self._latch.check()
            raise BehaviourError.raised_by(app, error) from error
        if not isinstance(status, Status):
            raise BehaviourError(
                f"{app.__name__}.step returned {status!r}; it must return a Status, such as Status.RUNNING"
            )
        return status

    def _step(self) -> object:
        """Call the app's step. End this process if the app forked and this is the copy: only the original drives."""
        try:
            return self.behaviour.step(self.robot)
        finally:
            if (process := os.getpid()) != self._process:
                try:
                    os.write(2, _COPY_ENDED.format(type(self.behaviour).__name__, process).encode())
                finally:
                    os._exit(COPY_STATUS)

    def _let_time_pass(self) -> None:
        self._next += self._period
        if not self._sleep():
            self.overruns += 1
            self._next = self._clock.now()

    def _sleep(self) -> bool:
        """Let time pass until the next tick; return whether that was still ahead.

        Where the deadman could not reach a motor that may be lost for a while, whoever commands it next is told.
        """
        while True:
            try:
                return self._clock.sleep_until(self._next)
            except DeviceLostError:  # noqa: PERF203  the next one may be another motor's
                if not self.outages.is_enabled:
                    raise
                self._stop_and_wait()
