"""The exceptions that this framework raises, as a tree.

    RobotcoreError
    ├── UsageError (ValueError)              a request is invalid, nothing has moved: exit 2
    │   ├── UnknownNameError (LookupError)   no backend, app, robot, world or key has that name
    │   ├── DescriptionError                 a robot's or a world's file is wrong
    │   ├── RecordingError                   a recording cannot be written, read or replayed
    │   ├── MapError                         a map's file cannot be written or read
    │   └── UnmetNeedError                   the robot lacks a device that the app needs
    ├── BackendError (RuntimeError)          a backend cannot work: exit 3
    │   ├── BackendMissingError (ImportError)  a backend's library is not installed
    │   ├── GuardianError                    the process that can stop the motors is gone
    │   ├── ResourceError                    the system refuses a thread or memory
    │   ├── UnsupportedSystemError           the operating system lacks what a feature needs
    │   └── RecordingEndedError (EOFError)   a replay has reached the end of its recording
    ├── DeviceError (OSError)                a device failed: exit 3
    │   ├── DeviceClosedError                a device was used after it was closed
    │   ├── DeviceLostError                  a device is disconnected, and its driver searches for it
    │   └── DeviceGroupError                 several devices failed at once
    ├── CalibrationError                     a measurement of the robot is too poor to be written: exit 1
    ├── DeviationError                       a replay differs from its recording: exit 1
    ├── DeployError                          a robot cannot be reached, or refuses a release: exit 3
    ├── FirmwareError                        a board's firmware cannot be built or flashed: exit 3
    ├── ReleaseCheckError                    a release failed its tests, checks or simulation: exit 1
    ├── UnhealthyError                       a new release failed on the robot and was rolled back: exit 1
    ├── SafetyStop                           a safety rule ended the run: exit 4
    │   ├── InvalidCommandError (ValueError) a velocity is not a finite number
    │   ├── StaleSampleError (TimeoutError)  a needed sample is too old
    │   ├── WatchdogError (TimeoutError)     the app, a device or a simulator hangs
    │   ├── EmergencyStopError               the emergency stop was pressed
    │   ├── WheelFaultError                  a wheel does not follow its command
    │   └── RangeFaultError                  a range sensor repeats one distance while the robot moves
    ├── RoutineError                         a routine of the app did not reach its end: exit 1
    │   ├── BlockedError                     something blocks the robot during a manoeuvre
    │   └── RoutineTimeoutError (TimeoutError)  a routine took longer than its time
    └── BehaviourError                       the app raised an exception: exit 5
    Interrupted (BaseException)              a signal ended the run: exit 128 + its number
    Mistake (ValueError)                     a value in a file is wrong: a DescriptionError reports it

The name in parentheses is a second base class, so that ``except ValueError`` also catches a UsageError.
"""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from math import degrees
from pathlib import PurePath
from traceback import extract_tb, format_exception
from types import MappingProxyType, TracebackType
from typing import Any, ClassVar

from robotcore.text import pluralize, suggest_attribute, suggestion

_CALLERS = {"robotcore", "importlib", "_frozen_importlib", "_frozen_importlib_external"}
"""The packages that import or call an app. Their stack frames are left out of a traceback of the app."""

_PLAIN = (str, int, float, bool, type(None))
"""The types of values that every process can unpickle."""

MAX_EXCEPTION_TEXT = 2000
"""The greatest number of characters of an app's exception in a BehaviourError.

A longer text would flood the tables and files of sweeps.
"""


_BLOCKAGES = {
    "range-guard": "the range guard stops the robot in front of an obstacle. Remove the obstacle, or drive another way",
    "contact": "a bumper is pressed. Remove the obstacle, or drive another way",
    "wheels": "the wheels do not turn as commanded. Look for an obstacle, and check the motors and encoders",
}
"""The sentences about each cause of a BlockedError."""


class _Portable(BaseException):
    """An exception that can be pickled, with any arguments of its constructor.

    An app may define a subclass, which another process cannot always import. Such an error is unpickled as its nearest
    base class in this module, with the same text, kind and fields.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        own = type(self)
        if own.__module__ == __name__:
            return _restore, (own, self.args, self.__dict__)
        ours = next(base for base in own.__mro__ if base.__module__ == __name__)
        return _restore, (ours, (str(self),), _portable_state(self))


class RobotcoreError(_Portable, Exception):
    """The base class of all errors of this framework. The user sees its message unchanged.

    kind: a stable identifier of the error, in kebab-case. Each class has a default.
    fields: the values in the message, by name.

    >>> from robotcore.errors import UsageError
    >>> error = UsageError("a run takes at least 1 s, not 0 s", kind="duration-too-short", duration_s=0.0)
    >>> error.kind, error.fields["duration_s"]
    ('duration-too-short', 0.0)
    """

    exit_status: ClassVar[int] = 1
    kind: str = "error"
    fields: Mapping[str, object] = MappingProxyType({})

    def __init__(self, *args: object, kind: str = "", **fields: object) -> None:
        super().__init__(*args)
        if kind:
            self.kind = kind
        if fields:
            self.fields = fields


class Mistake(ValueError):  # noqa: N818  several of them make one DescriptionError
    """A mistake in a file. The function that validates a value raises it, and a DescriptionError reports it.

    problem: the problem without a subject, such as ``is missing``.
    remedy: an instruction for the user, as a sentence without its full stop.
    kind: a stable identifier in kebab-case, such as ``missing-key``.
    key: the dotted key of the wrong value; ``""`` if the mistake concerns the whole table or file.

    >>> mistake = Mistake("the axle is not under the body", "Correct body.centre_x_m", kind="axle-not-under-body")
    >>> mistake.kind, str(mistake)
    ('axle-not-under-body', 'the axle is not under the body. Correct body.centre_x_m')
    """

    def __init__(self, problem: str, remedy: str = "Correct it", *, kind: str = "description", key: str = "") -> None:
        super().__init__(f"{problem}. {remedy}")
        self.problem, self.remedy, self.kind, self.key = problem, remedy, kind, key

    @classmethod
    def from_error(cls, error: ValueError, key: str = "", kind: str = "description") -> Mistake:
        """Return the mistake for an error that a validator raised for the value of a key.

        The text of a plain ValueError is the problem, a semicolon and a remedy. ``kind`` is the kind of its mistake.
        """
        if isinstance(error, Mistake):
            return cls(error.problem, error.remedy, kind=error.kind, key=key)
        problem, _, remedy = str(error).rpartition("; ")
        if not problem:
            return cls(remedy, kind=kind, key=key)
        return cls(problem, remedy[:1].upper() + remedy[1:], kind=kind, key=key)

    def below(self, key: str) -> Mistake:
        """Return the mistake with its key below another key, such as that of the table of the value."""
        return Mistake(self.problem, self.remedy, kind=self.kind, key=f"{key}.{self.key}".rstrip("."))


class UsageError(RobotcoreError, ValueError):
    """A command or a call is invalid. No motor has moved.

    >>> from robotcore import RunRequest, run
    >>> try:
    ...     run(RunRequest("green-search", timeout_s=-1.0))
    ... except UsageError as error:
    ...     print(error.kind, error.exit_status)
    not-positive 2
    """

    kind = "usage"
    exit_status = 2


class UnknownNameError(UsageError, LookupError):
    """A name is unknown. The message suggests another name.

    kind: the noun for the named object, such as ``app``. The kind of the error is then ``unknown-app``.
    name: the unknown name.
    known: all known names. The message suggests the most similar one.
    meant: a suggestion that replaces the most similar known name.
    hint: a sentence that follows if no known name is similar.

    >>> str(UnknownNameError("app", "gren-search", ["green-search", "mark-green"]))
    "unknown app 'gren-search'. Did you mean 'green-search'?"
    """

    kind = "unknown-name"

    def __init__(self, kind: str, name: str, known: Sequence[str], meant: str = "", hint: str = "") -> None:
        remedy = f"Did you mean {meant}?" if meant else suggestion(name, known)
        super().__init__(
            f"unknown {kind} {name!r}. {remedy}" + f" {hint}" * (bool(hint) and remedy.endswith(".")),
            kind=f"unknown-{kind.replace(' ', '-')}",
        )
        self.name = name


class DescriptionError(UsageError):
    """A robot's or a world's file has a mistake.

    file: the name of the file.
    key: the dotted key of the wrong value; ``""`` if the mistake concerns the whole file.
    problem: the value's mistake, without a subject, such as ``is missing``.
    remedy: an instruction for the user, as a sentence without its full stop.
    others: the errors for further mistakes in the file. The message has a line for each.

    >>> str(DescriptionError("r.toml", "body.mass_kg", "is missing", "Add the key"))
    'r.toml: body.mass_kg: is missing. Add the key'
    """

    kind = "description"

    def __init__(
        self,
        file: str,
        key: str,
        problem: str,
        remedy: str,
        others: Sequence[DescriptionError] = (),
        *,
        kind: str = "",
        **fields: object,
    ) -> None:
        place = f"{file}: {key}" if key else file
        super().__init__("\n".join((f"{place}: {problem}. {remedy}", *map(str, others))), kind=kind, **fields)
        self.file, self.key, self.problem, self.remedy = file, key, problem, remedy
        self.others = tuple(others)

    @classmethod
    def of_all(cls, file: str, mistakes: Sequence[Mistake]) -> DescriptionError:
        """Return one error for all mistakes in a file. ``mistakes`` must not be empty."""
        first, *others = (cls(file, each.key, each.problem, each.remedy, kind=each.kind) for each in mistakes)
        return cls(file, first.key, first.problem, first.remedy, others, kind=first.kind)


class RecordingError(UsageError):
    """A recording cannot be written, read or replayed.

    file: the recording's file.
    problem: the file's defect, without a subject, such as ``is empty``.
    remedy: an instruction for the user, as a sentence without its full stop.
    """

    kind = "recording"

    def __init__(self, file: object, problem: str, remedy: str, *, kind: str = "", **fields: object) -> None:
        super().__init__(f"{file}: {problem}. {remedy}", kind=kind, file=str(file), **fields)


class MapError(UsageError):
    """The file of a map cannot be written or read.

    file: the map's file.
    problem: the file's defect, without a subject, such as ``does not exist``.
    remedy: an instruction for the user, as a sentence without its full stop.
    """

    kind = "map"

    def __init__(self, file: object, problem: str, remedy: str, *, kind: str = "") -> None:
        super().__init__(f"{file}: {problem}. {remedy}", kind=kind, file=str(file))


class UnmetNeedError(UsageError):
    """The app requires a role, such as a camera, for which the robot has no device."""

    kind = "unmet-need"


class BackendError(RobotcoreError, RuntimeError):
    """A backend cannot run."""

    kind = "backend"
    exit_status = 3


class BackendMissingError(BackendError, ImportError):
    """A backend's library is not installed. The message says how to install it."""

    kind = "backend-missing"


class GuardianError(BackendError):
    """The guardian process has ended or failed. No motor may move without a guardian."""

    kind = "guardian"


class ResourceError(BackendError):
    """The operating system refuses to start a thread or to allocate memory.

    refusal: a sentence that names the refused resource, without its full stop.
    """

    kind = "resource"

    def __init__(self, refusal: str) -> None:
        super().__init__(
            f"{refusal}. End other programs, or raise the limit: ulimit -u and ulimit -v in a shell, TasksMax= and "
            "MemoryMax= in a systemd unit. If the app itself starts too many threads or uses too much memory, correct "
            "the app"
        )
        self.refusal = refusal


class UnsupportedSystemError(BackendError):
    """The operating system lacks what a feature needs, such as Windows a GPIO chip.

    feature: the command, the backend or the function, such as ``the backend 'raspberrypi'``.
    needed: a noun phrase for what the feature needs.
    remedy: an instruction for the user, as a sentence without its full stop.

    >>> str(UnsupportedSystemError("robotcore deploy", "POSIX pipes", "Run it in WSL"))
    'robotcore deploy needs POSIX pipes, which this operating system lacks. Run it in WSL'
    """

    kind = "unsupported-system"

    def __init__(self, feature: str, needed: str, remedy: str) -> None:
        text = f"{feature} needs {needed}, which this operating system lacks. {remedy}"
        super().__init__(text, feature=feature, needed=needed)


class RecordingEndedError(BackendError, EOFError):
    """A replay has reached the end of its recording before the app ended.

    ticks: the number of ticks in the recording.
    time: the recording's length in seconds.
    """

    kind = "recording-ended"

    def __init__(self, ticks: int, time: float) -> None:
        text = f"the recording ends here, after {ticks} ticks, at {time:g} s. The app did not end by then"
        super().__init__(text, ticks=ticks, time_s=time)


class CalibrationError(RobotcoreError):
    """A calibration has no result, or its result is too uncertain to be written to the robot's file."""

    kind = "calibration"


class DeviationError(RobotcoreError):
    """A replay differs from its recording."""

    kind = "deviation"


class DeployError(RobotcoreError):
    """A robot cannot be reached, or refuses a release. Its present release stays active."""

    kind = "deploy"
    exit_status = 3


class FirmwareError(RobotcoreError):
    """A board's firmware cannot be built or flashed."""

    kind = "firmware"
    exit_status = 3


class ReleaseCheckError(RobotcoreError):
    """A release failed its tests, its checks or its simulation, and was not sent to the robot."""

    kind = "release-check"


class UnhealthyError(RobotcoreError):
    """A new release failed its health check on the robot. The robot runs its previous release again, if it has one."""

    kind = "unhealthy"


class DeviceError(RobotcoreError, OSError):
    """A device failed.

    device: the device's name.
    problem: the problem without a subject, such as ``is closed``. The message is ``device: problem``.

    >>> error = DeviceError("nose", "no echo for 1.0 s. Check the wiring", kind="no-echo")
    >>> error.device, error.kind, isinstance(error, OSError)
    ('nose', 'no-echo', True)
    >>> str(error)
    'nose: no echo for 1.0 s. Check the wiring'
    """

    kind = "device"
    exit_status = 3

    def __init__(self, device: str, problem: str, *, kind: str = "", **fields: object) -> None:
        super().__init__(f"{device}: {problem}", kind=kind, **fields)
        self.device = device


class DeviceClosedError(DeviceError):
    """A device was used after it was closed."""

    kind = "device-closed"

    def __init__(self, device: str) -> None:
        super().__init__(device, "is closed. Open the robot again to use it")


class DeviceLostError(DeviceError):
    """A device is disconnected, for example unplugged. Its driver tries to connect again."""

    kind = "device-lost"


class DeviceGroupError(DeviceError):
    """Several devices failed at once.

    action: the action that failed, such as ``opening rover``.
    failures: the errors of the devices. The message has a line for each error.
    """

    kind = "device-group"

    def __init__(self, action: str, failures: Sequence[Exception]) -> None:
        lines = "".join(f"\n  - {failure}" for failure in failures)
        super().__init__(action, f"{pluralize(len(failures), 'device')} failed{lines}")
        self.failures = tuple(failures)


class SafetyStop(RobotcoreError):  # noqa: N818  robotics calls it a stop, because it is no bug
    """A safety rule ended the run and stopped every motor.

    cause: the name of the rule, which the trace also uses for interventions.
    """

    kind = "safety-stop"
    exit_status = 4
    cause: ClassVar[str] = "safety stop"


class InvalidCommandError(SafetyStop, ValueError):
    """The app gave a command that is NaN or infinite, or a display a picture of another format."""

    kind = "invalid-command"
    cause = "invalid command"


class StaleSampleError(SafetyStop, TimeoutError):
    """A sample that the app or a safety rule reads is too old, or its time is not that of the robot's clock.

    device: the sensor's name.
    age: the sample's age in seconds; negative or NaN for the time of another clock.
    limit: the greatest allowed age in seconds.
    """

    kind = "stale-sample"
    cause = "stale sample"

    def __init__(self, device: str, age: float, limit: float) -> None:
        if age >= 0:
            text = (
                f"is {age:.3f} s old, the limit is {limit:.3f} s. Check that the device is connected. If its samples "
                "are always that old, raise safety.max_age_s in the robot's description"
            )
        else:
            text = f"has an age of {age:.3f} s. Let the driver take its time from the robot's clock"
        super().__init__(f"{device}: the newest sample {text}")
        self.device, self.age, self.limit = device, age, limit


class WatchdogError(SafetyStop, TimeoutError):
    """A call into the app, an observer, a device or a simulator has not returned in time."""

    kind = "watchdog"
    cause = "watchdog"


class EmergencyStopError(SafetyStop):
    """The emergency stop was pressed.

    how: a clause for the message, such as ``the button on the bench was pressed``.
    """

    kind = "emergency-stop"
    cause = "e-stop"

    def __init__(self, how: str) -> None:
        super().__init__(f"e-stop: {how}")


class WheelFaultError(SafetyStop):
    """The encoders show that wheels do not follow their commands.

    problems: a clause for each such wheel that describes its motion.
    """

    kind = "wheel-fault"
    cause = "wheel fault"

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__(
            f"{', '.join(problems)}. Check if the wheel is blocked and if the motor has power. "
            "robotcore test-devices finds swapped wires and dead encoders. The time limit is safety.follow_s in the "
            "robot's description"
        )


class RangeFaultError(SafetyStop):
    """Range sensors return the same distance for too long while the robot moves.

    problems: a clause for each such sensor that describes its measurements.
    """

    kind = "range-fault"
    cause = "range fault"

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__(
            f"{', '.join(problems)}. The sensor may be frozen or measure the robot itself, or the wheels may slip. "
            "The distance limit is safety.stuck_m in the robot's description"
        )


class RoutineError(RobotcoreError):
    """A routine of the app, such as a manoeuvre, did not reach its end. An app can catch it and try another way.

    A run that it ends is a failure, as if the app had returned `Status.FAILURE`.
    """

    kind = "routine"


class RoutineTimeoutError(RoutineError, TimeoutError):
    """A routine took longer than its `with_timeout`.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     try:
    ...         robot.wait_until(lambda: False, timeout_s=0.5)
    ...     except RoutineTimeoutError as error:
    ...         print(error.kind)
    routine-timeout
    """

    kind = "routine-timeout"


class BlockedError(RoutineError):
    """Something blocks the robot during a manoeuvre of an app. An app may catch it, and drive another way.

    manoeuvre: the call of the manoeuvre, such as ``straight(0.5)``.
    cause: ``range-guard``, ``contact`` or ``wheels``.
    remaining_m: the distance that remains, in metres; 0 for a turn on the spot.
    remaining_rad: the angle that remains in a turn on the spot, in radians; None for another manoeuvre.

    >>> import robotcore
    >>> with robotcore.open("rover", world="arena") as robot:
    ...     try:
    ...         robot.drive.straight(2.0)  # into an obstacle
    ...     except BlockedError as error:
    ...         print(error.manoeuvre, error.cause, error.remaining_m > 1.0)
    straight(2) range-guard True
    """

    kind = "blocked"

    def __init__(
        self, manoeuvre: str, cause: str, remaining_m: float = 0.0, remaining_rad: float | None = None
    ) -> None:
        way = f"{remaining_m:.2f} m" if remaining_rad is None else f"{degrees(remaining_rad):.0f}°"
        remaining: dict[str, Any]
        remaining = {"remaining_m": remaining_m} if remaining_rad is None else {"remaining_rad": remaining_rad}
        super().__init__(
            f"{manoeuvre} is blocked {way} before its end: {_BLOCKAGES[cause]}",
            manoeuvre=manoeuvre,
            cause=cause,
            **remaining,
        )
        self.manoeuvre, self.cause = manoeuvre, cause
        self.remaining_m, self.remaining_rad = remaining_m, remaining_rad


class BehaviourError(RobotcoreError):
    """The app's code raised an exception, which is the ``__cause__`` of this error."""

    kind = "behaviour"
    exit_status = 5
    _traceback_text = ""

    def __reduce__(self) -> tuple[Any, ...]:
        restored, (kind, args, state) = super().__reduce__()
        return restored, (kind, args, {**state, "_traceback_text": self.traceback})

    @property
    def traceback(self) -> str:
        """The traceback of the app's exception as text, without the frames of this framework.

        The text is empty without an exception. It is kept if the error is pickled.
        """
        if (cause := self.__cause__) is None:
            return self._traceback_text
        return "".join(format_exception(type(cause), cause, _trim_traceback(cause.__traceback__)))

    @classmethod
    def from_exception(cls, app: type, cause: BaseException) -> BehaviourError:
        """Return the error for an exception that the code of ``app`` raised.

        The exception's text is cut off after `MAX_EXCEPTION_TEXT` characters.
        """
        try:
            text = str(cause)
        except (Exception, SystemExit) as failure:  # noqa: BLE001  an app's own class of exceptions
            text = f"its text is unknown, because __str__ raised {type(failure).__name__}"
        if len(text) > MAX_EXCEPTION_TEXT:
            text = f"{text[:MAX_EXCEPTION_TEXT]}… ({len(text) - MAX_EXCEPTION_TEXT} more characters)"
        parts = (f"{app.__name__} raised {type(cause).__name__}{f': {text}' if text else ''}", suggest_attribute(cause))
        error = cls(". ".join(filter(None, parts)))
        error.__cause__ = cause
        return error


class Interrupted(_Portable):
    """A signal, such as SIGTERM, ended the program. ``except Exception`` in an app does not catch this exception.

    >>> import signal
    >>> error = Interrupted(signal.SIGTERM)
    >>> error.exit_status, isinstance(error, Exception)
    (143, False)
    """

    kind = "interrupted"

    def __init__(self, signal_number: int) -> None:
        super().__init__(f"interrupted by {signal.Signals(signal_number).name}")
        self.signal_number = signal_number
        self.exit_status = 128 + signal_number


def describe_exception(error: BaseException, caller: str) -> str:
    """Return the class, the text and the line of an exception, such as ``ValueError: no limit, at speed.py:39``.

    caller: the file of the code that caught it. The line is left out if the exception was raised there.

    >>> try:
    ...     float("fast")
    ... except ValueError as error:
    ...     text = describe_exception(error, caller="limits.py")
    >>> text.partition(", at ")[0]
    "ValueError: could not convert string to float: 'fast'"
    """
    last = extract_tb(error.__traceback__)[-1]
    file = PurePath(last.filename).name
    line = "" if last.filename == caller else f", at {file}:{last.lineno}"
    return f"{type(error).__name__}: {error}".removesuffix(": ") + line


def _trim_traceback(traceback: TracebackType | None) -> TracebackType | None:
    while traceback and str(traceback.tb_frame.f_globals.get("__name__")).partition(".")[0] in _CALLERS:
        traceback = traceback.tb_next
    return traceback


def _portable_state(error: _Portable) -> dict[str, Any]:
    if not isinstance(error, RobotcoreError):
        return {}
    fields = {name: value if type(value) in _PLAIN else str(value) for name, value in error.fields.items()}
    return {"kind": error.kind, "fields": fields}


def _restore(kind: type[_Portable], args: tuple[Any, ...], state: dict[str, Any]) -> _Portable:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error
