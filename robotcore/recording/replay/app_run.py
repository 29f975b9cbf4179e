"""Run an app on the samples of a recording, and read the events of each recorded tick one after the other."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict, deque
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from robotcore.errors import EmergencyStopError, Interrupted, RecordingError, RobotcoreError, WatchdogError
from robotcore.recording import Recording
from robotcore.recording.events import Read, Tick, WheelAngles
from robotcore.recording.logged_summary import LoggedSummary
from robotcore.recording.recorder import Recorder
from robotcore.runtime.layers.base import Tap
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext, run
from robotcore.runtime.trace import TickRecord

BACKEND = "replay"


class TickReader:
    """Returns the events of one recorded tick, one after the other."""

    def __init__(self, tick: Tick) -> None:
        self.tick = tick
        self.commands = deque(tick.asks)
        """The commands to the drive that the replay has not given yet."""
        self.motor_commands = deque(tick.motor_asks)
        """The commands to motors outside the drive that the replay has not given yet."""
        self.actuator_commands = deque(tick.commands)
        """The commands to other actuators that the replay has not given yet."""
        self._angles = deque(tick.turned)
        self._reads: dict[str, deque[Read]] = defaultdict(deque)
        for read in tick.reads:
            self._reads[read.device].append(read)
        self._devices = frozenset(self._reads)

    @property
    def is_cut_short(self) -> bool:
        """Whether a signal or the watchdog ended the run in this tick, so that its other events were not recorded."""
        is_signalled = self.tick.error is not None and self.tick.error.kind == Interrupted.__name__
        return is_signalled or any(each.cause == WatchdogError.cause for each in self.tick.interventions)

    @property
    def early_error(self) -> RobotcoreError | None:
        """The error of a latch that tripped before the first event of this tick, such as an e-stop; else None."""
        tick = self.tick
        has_begun = tick.reads or tick.asks or tick.motor_asks or tick.commands or tick.turned or not tick.interventions
        error = None if has_begun or tick.error is None else tick.error.rebuild()
        return error if isinstance(error, RobotcoreError) and not self.is_cut_short else None

    @property
    def emergency_stop(self) -> RobotcoreError | None:
        """The error of an e-stop that tripped before the command of this tick was sent; None if there is none."""
        error = self.tick.error.rebuild() if self.tick.error and not self.was_committed else None
        return error if isinstance(error, EmergencyStopError) else None

    @property
    def was_committed(self) -> bool:
        """Whether the run sent the command of this tick, so that an error of the tick occurred later."""
        return self.tick.asked is not None or self.tick.sent is not None

    def was_read(self, device: str) -> bool:
        """Return whether the recorded run read the device in this tick."""
        return device in self._devices

    def count_other_failures(self, device: str) -> int:
        """Take the app's next read of a device. Return how many reads by the guard or the odometry failed before it."""
        left, failed = self._reads[device], 0
        while left and left[0].by and left[0].error:
            left.popleft()
            failed += 1
        if left:
            left.popleft()
        return failed

    def next_angles(self) -> WheelAngles | None:
        """Return the next recorded wheel angles. None if none were recorded.

        After the last ones, it returns these again, but without the way to them, because the wheels are there already.
        """
        angles = self._angles.popleft() if self._angles else None
        if angles and not self._angles:
            self._angles.append(replace(angles, between=()))
        return angles


class ReplayTap(Tap, ABC):
    """A tap and an observer that compares each tick of a run on a recording with the recorded tick."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.current = TickReader(recording.ticks[0])
        """The recorded tick that is compared with the current tick of the run."""
        self.logged = LoggedSummary()
        """The values that the app logged in the replay."""

    def begin(self, run: RunContext) -> None:
        """Do nothing. The comparison begins with the first tick."""

    @abstractmethod
    def tick(self, record: TickRecord) -> None:
        """Compare a tick with the recorded one."""

    def end(self, result: RunResult) -> None:
        """Do nothing. The result is compared after the run."""

    def advance(self, ticks: int) -> None:
        """Continue with the next recorded tick, if there is one, after this number of ticks."""
        if ticks < len(self.recording.ticks):
            self.current = TickReader(self.recording.ticks[ticks])


def require_ticks(recording: Recording, file: Path | str) -> None:
    """Raise RecordingError if a recording has no tick."""
    if not recording.ticks:
        raise RecordingError(
            file or "the recording", "no tick was recorded", "Record another run", kind="recording-without-tick"
        )


def run_app(
    tap: ReplayTap,
    app: str | None,
    settings: Mapping[str, Any],
    recorder: Recorder | None = None,
    *,
    keeps_safety_rules: bool = False,
) -> RunResult:
    """Run an app on the recording of a tap, and return the result. Raises the error of a run without a tick.

    app: the name or the file of the app; None for the recorded app.
    recorder: records the replay; None for no recording.
    keeps_safety_rules: whether the replay backend keeps the safety rules of the recorded run, see `ReplayOptions`.
    """
    recorded = tap.recording.metadata.request
    request = RunRequest(
        app=app or recorded.app_reference,
        backend=BACKEND,
        seed=recorded.seed,
        rate_hz=recorded.rate_hz,
        timeout_s=recorded.timeout_s,
        settings=settings,
        options={"recording": tap.recording, "keeps_safety_rules": keeps_safety_rules},
        has_operator=recorded.has_operator,
    )
    recorders = [recorder] if recorder else []  # it gets a tick first, because the tap may end the replay in the tick
    result = run(request, [*recorders, tap], [tap, *(each.layer for each in recorders)])
    if result.error and not isinstance(result.error, Interrupted) and not result.ticks:
        raise result.error
    return result
