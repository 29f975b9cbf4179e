"""Verify a recording: run its app on the recorded samples, and compare each decision with the recorded one."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from robotcore.errors import (
    BehaviourError,
    DeviationError,
    Interrupted,
    RecordingEndedError,
    RecordingError,
    RobotcoreError,
)
from robotcore.recording import RecordedError, Recording
from robotcore.recording.logged_summary import LoggedSeries
from robotcore.recording.recorder import Recorder
from robotcore.recording.recording import read_platform
from robotcore.recording.replay.app_permission import has_app_changed, require_recorded_app
from robotcore.recording.replay.app_run import BACKEND, TickReader, require_ticks, run_app
from robotcore.recording.replay.differences import PLATFORM_TOLERANCE, CommandComparator, Deviation
from robotcore.recording.replay.verifier import Verifier
from robotcore.recording.summary import explain_missing_end
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.versions import libraries

DIFFERS = 1


@dataclass(frozen=True)
class ReplayResult:
    """The result of verifying a recording.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> from robotcore.recording.replay import replay
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> result = replay(recording)
    >>> result.is_equal, result.is_exact, result.exit_status
    (True, True, 0)
    """

    recording: Recording
    result: RunResult
    ticks: int
    """The number of ticks before the first difference."""
    deviation: Deviation | None
    """The first difference from the recording; None if there is none."""
    is_exact: bool
    """Whether all commands have the recorded bits."""
    largest_difference: float
    """The largest difference of a command within the tolerance, in rad/s; 0 on the recorded platform."""
    trace_sha256: str
    platform: tuple[str, ...] = ()
    """The differences between this platform and the recorded one, as texts."""
    has_app_changed: bool | None = None
    """Whether the app's file differs from the recorded source; None if no source was recorded."""
    logged: Sequence[LoggedSeries] = ()
    """A summary of the values that the app logged in the replay, by name. They are not compared."""

    def __repr__(self) -> str:
        verdict = (
            f"{self.deviation.subject} differs in tick {self.deviation.tick}" if self.deviation else "no difference"
        )
        return f"<ReplayResult of {self.result.app}: {self.ticks} equal ticks, {verdict}>"

    @property
    def ended_by(self) -> str:
        """The external cause of the recording's end, such as a signal or a cut file; empty if there is none."""
        return explain_external_end(self.recording)

    @property
    def states(self) -> list[str]:
        """The app's states in the ticks before the first difference."""
        return [tick.state for tick in self.recording.ticks[: self.ticks]]

    @property
    def recorded_sha256(self) -> str | None:
        """The recorded digest of the trace; None if the recording has none, or if not all its ticks were replayed."""
        recorded = self.recording.result
        return recorded.trace_sha256 if recorded and self.ticks == recorded.ticks else None

    @property
    def is_equal(self) -> bool:
        """Whether all decisions are equal, and the digests too if all commands have the recorded bits."""
        is_comparable = self.is_exact and self.recorded_sha256 is not None
        return self.deviation is None and not (is_comparable and self.recorded_sha256 != self.trace_sha256)

    @property
    def exit_status(self) -> int:
        """The exit status: 0 if all decisions are equal, else 1; that of the signal if a signal ended the replay."""
        if isinstance(self.result.error, Interrupted):
            return self.result.exit_status
        return 0 if self.is_equal else DIFFERS

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields.

        The JSON keys:

        app: text; the name of the app.
        equal: true or false; whether all decisions are equal.
        bit_equal: true or false; whether all commands also have the recorded bits.
        ticks: whole number; the number of ticks before the first difference.
        recorded_ticks: whole number; the number of ticks of the recording.
        largest_difference_rad_s: number, rad/s; the largest difference of a command within the tolerance.
        trace_sha256: text; the digest of the trace of the replay.
        recorded_sha256: text or null; the recorded digest. Null if the recording has none, or after a difference.
        ended_by: text or null; the external cause of the recording's end, such as a signal or a cut file.
        platform: list of text; the differences between this machine and the recorded one.
        app_changed: true, false or null; whether the app's file differs from the recorded one. Null if it is unknown.
        logged: list of objects; the values that the app logged in the replay.
        logged[].*: robotcore.recording.logged_summary.LoggedSeries.to_dict
        deviation: object or null; the first decision that differs. Null if there is none.
        deviation.*: robotcore.recording.replay.differences.Deviation without time
        deviation.time_s: number, s; the time of the tick on the robot's clock.
        exit_status: whole number; the exit status.
        """
        deviation = asdict(self.deviation) if self.deviation else None
        if deviation:
            deviation["time_s"] = deviation.pop("time")
        return {
            "app": self.result.app,
            "equal": self.is_equal,
            "bit_equal": self.is_equal and self.is_exact,
            "ticks": self.ticks,
            "recorded_ticks": len(self.recording.ticks),
            "largest_difference_rad_s": self.largest_difference,
            "trace_sha256": self.trace_sha256,
            "recorded_sha256": self.recorded_sha256,
            "ended_by": self.ended_by or None,
            "platform": list(self.platform),
            "app_changed": self.has_app_changed,
            "logged": [series.to_dict() for series in self.logged],
            "deviation": deviation,
            "exit_status": self.exit_status,
        }


def replay(
    recording: Recording, file: Path | str = "", *, app: str | None = None, recorder: Recorder | None = None
) -> ReplayResult:
    """Run the recorded app on the recorded samples, and compare each decision with the recorded one.

    Raises RecordingError if an input of the app is missing in the recording, or if the recorded app must not run, see
    `require_recorded_app`.

    file: the name of the recording in error messages.
    app: the file of another app to run; None for the recorded app.
    recorder: records the replay; None for no recording.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> replay(recording)
    <ReplayResult of avoid-obstacles: 11 equal ticks, no difference>
    """
    require_ticks(recording, file)
    if not recording.is_replayable:
        raise RecordingError(
            file or "the recording",
            f"a replay is not possible: {recording.missing_inputs}",
            "To run an app on the recorded samples: robotcore replay FILE --app APP",
            kind="recording-not-replayable",
            why_not=recording.missing_inputs,
        )
    if app is None:
        require_recorded_app(recording, file)
    recorded = recording.metadata.request
    platform = compare_platforms(recording.metadata.platform)
    comparator = CommandComparator(PLATFORM_TOLERANCE if platform else 0.0)
    verifier = Verifier(recording, comparator)
    result = run_app(verifier, app, recorded.settings, recorder, keeps_safety_rules=True)
    if not isinstance(result.error, Interrupted):
        with suppress(DeviationError):
            _compare_end(verifier, result)
    return ReplayResult(
        recording=recording,
        result=replace(result, backend=recorded.backend),
        ticks=verifier.trace.ticks,
        deviation=verifier.deviation,
        is_exact=comparator.is_exact,
        largest_difference=comparator.largest,
        trace_sha256=verifier.trace.sha256,
        platform=tuple(platform),
        has_app_changed=has_app_changed(recording, app or recorded.app_reference),
        logged=verifier.logged.series,
    )


_GOES_ON = "the app goes on"


def explain_external_end(recording: Recording) -> str:
    """Return the external cause of the recording's end; empty if the app or its time limit ended the run.

    Examples are a signal, a simulator that died, and a file that was cut.
    """
    result, last = recording.result, recording.ticks[-1]
    if result is None:
        return explain_missing_end(recording)
    is_of_the_last_tick = last.error is not None and not TickReader(last).is_cut_short
    is_of_the_app = result.outcome in (Outcome.SUCCESS, Outcome.FAILURE, Outcome.TIMEOUT)
    return "" if is_of_the_last_tick or is_of_the_app else result.reason


def _compare_end(verifier: Verifier, result: RunResult) -> None:
    """Report a difference if the end of the replay differs from that of the recorded run."""
    if verifier.deviation or verifier.is_at_end:
        return
    recording = verifier.recording
    left = len(recording.ticks) - verifier.trace.ticks
    if isinstance(result.error, RecordingEndedError):
        if not explain_external_end(recording):
            verifier.report_difference("the end", _format_recorded_end(recording), _GOES_ON)
    elif left and not verifier.current.is_cut_short:
        verifier.report_difference("the end", _GOES_ON, _format_end(result.outcome, result.reason))
    elif not explain_external_end(recording) and not _is_same_end(recording, result):
        verifier.report_difference("the end", _format_recorded_end(recording), _format_replayed_end(result))


def _is_same_end(recording: Recording, result: RunResult) -> bool:
    """Return whether the outcomes are equal, and the classes and the attributes of the errors.

    The messages are compared only for exceptions of the app. Another version of robotcore may change its own messages.
    """
    recorded, replayed = recording.ticks[-1].error, result.error
    if not recording.result or recording.result.outcome != result.outcome:
        return False
    if recorded is None or not isinstance(replayed, (RobotcoreError, Interrupted)):
        return recorded is None and replayed is None
    here = RecordedError.from_error(replayed)
    shared = {name for name in recorded.attributes.keys() & here.attributes.keys() if not name.startswith("_")}
    is_same = recorded.kind == here.kind and all(
        repr(recorded.attributes[name]) == repr(here.attributes[name]) for name in shared
    )
    is_same_text = _format_replayed_end(result) == _format_recorded_end(recording)
    return is_same_text if isinstance(replayed, BehaviourError) else is_same


def _format_replayed_end(result: RunResult) -> str:
    return _format_end(result.outcome, str(result.error) if result.error else result.reason)


def _format_recorded_end(recording: Recording) -> str:
    result, last = recording.result, recording.ticks[-1]
    assert result, "a run that ended by an external cause has no recorded end"
    return _format_end(result.outcome, last.error.message if last.error else result.reason)


def _format_end(outcome: Outcome, reason: str) -> str:
    """Return the outcome and its reason, without object addresses and line numbers, which change."""
    same = re.sub(r", at \S+\.py:\d+", "", re.sub(r"\b0x[0-9a-fA-F]+\b", "0x…", reason))
    return f"{outcome.value}: {same}" if same else outcome.value


def compare_platforms(recorded: Mapping[str, str]) -> list[str]:
    """Return a text for each difference between the recorded platform and this one.

    A platform is the machine, the system and the versions of libraries, without the simulator.
    """
    here = read_platform(BACKEND)
    return [
        f"{name} {recorded.get(name, 'unknown')} recorded, {here[name]} here"
        for name in ("machine", "system", "libc", *libraries([]))
        if recorded.get(name) != here[name]
    ]
