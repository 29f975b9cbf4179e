"""Every error that this framework raises on purpose, as one tree.

    RobotcoreError
    ├── UsageError (ValueError)              a request is invalid, nothing has moved: exit 2
    │   ├── UnknownNameError (LookupError)   no backend, app, robot, world or key has that name
    │   ├── DescriptionError                 a robot's or a world's file is wrong
    │   ├── RecordingError                   a recording cannot be written, read or replayed
    │   └── UnmetNeedError                   the robot lacks a device that the app needs
    ├── BackendError (RuntimeError)          a backend cannot work: exit 3
    │   ├── BackendMissingError (ImportError)  a backend's library is not installed
    │   ├── GuardianError                    the process that can stop the motors is gone
    │   ├── ResourceError                    the system refuses a thread or memory
    │   └── RecordingEndedError (EOFError)   a replay has reached the end of its recording
    ├── DeviceError (OSError)                a device failed: exit 3
    │   ├── DeviceClosedError                a device was used after it was closed
    │   ├── DeviceLostError                  a device is disconnected, and its driver searches for it
    │   └── DeviceGroupError                 several devices failed at once
    ├── DeviationError                       a replay differs from its recording: exit 1
    ├── DeployError                          a robot cannot be reached, or refuses a release: exit 3
    ├── FirmwareError                        a board's firmware cannot be built or flashed: exit 3
    ├── UnprovenError                        a release failed its tests, checks or simulation: exit 1
    ├── UnhealthyError                       a new release failed on the robot and was rolled back: exit 1
    ├── SafetyStop                           a safety rule ended the run: exit 4
    │   ├── InvalidCommandError (ValueError) a velocity is not a finite number
    │   ├── StaleSampleError (TimeoutError)  a needed sample is too old
    │   ├── WatchdogError (TimeoutError)     the app, a device or a simulator hangs
    │   ├── EmergencyStopError               the emergency stop was pressed
    │   ├── WheelFaultError                  a wheel does not follow its command
    │   └── RangeFaultError                  a range sensor repeats one distance while the robot moves
    └── BehaviourError                       the app raised an exception: exit 5
    Interrupted (BaseException)              a signal ended the run: exit 128 + its number

A builtin error in parentheses is a further base class, so that ``except ValueError`` catches a UsageError.
"""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from traceback import format_exception
from types import MappingProxyType, TracebackType
from typing import Any, ClassVar

_CALLERS = {"robotcore", "importlib", "_frozen_importlib", "_frozen_importlib_external"}
"""The packages that import or call an app. Their frames are left out of a traceback of the app."""

_PLAIN = (str, int, float, bool, type(None))
"""The types whose values another process can always unpickle."""

MAX_EXCEPTION_TEXT = 2000
"""The most characters of an app's exception in an error. A longer text would flood the tables and files of sweeps."""


class _Portable(BaseException):
    """An exception that can be pickled, whatever arguments its constructor takes.

    Another process may not be able to import a subclass that an app defines. Such an error is unpickled as its nearest
    base class in this module, with the same text, kind and fields.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        own = type(self)
        if own.__module__ == __name__:
            return _restore, (own, self.args, self.__dict__)
        ours = next(base for base in own.__mro__ if base.__module__ == __name__)
        return _restore, (ours, (str(self),), _portable_state(self))


class RobotcoreError(_Portable, Exception):
    """The root of the tree. Its message is shown to the user unchanged.

    kind: a stable identifier of the event, in kebab-case. Each class has a default. A ``raise`` may pass a more exact
    one.
    fields: the values in the message, by name.

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


MistakeParts = tuple[str, str, str] | tuple[str, str, str, str]
"""A mistake in a file: the key, the problem, the remedy, and optionally the error's kind."""


class UsageError(RobotcoreError, ValueError):
    """A request is invalid. No motor has moved."""

    kind = "usage"
    exit_status = 2


class UnknownNameError(UsageError, LookupError):
    """A name is unknown. The message suggests another name.

    kind: the kind of thing that is named, such as ``app``. The error's own kind is then ``unknown-app``.
    name: the unknown name.
    known: all known names. The message suggests the nearest one.
    meant: a suggestion in place of the nearest known name.

    >>> str(UnknownNameError("app", "gren-search", ["green-search", "mark-green"]))
    "unknown app 'gren-search'. Did you mean 'green-search'?"
    """

    kind = "unknown-name"

    def __init__(self, kind: str, name: str, known: Sequence[str], meant: str = "") -> None:
        super().__init__(
            f"unknown {kind} {name!r}. {f'Did you mean {meant}?' if meant else suggestion(name, known)}",
            kind=f"unknown-{kind.replace(' ', '-')}",
        )
        self.name = name


class DescriptionError(UsageError):
    """A robot's or a world's file is wrong.

    file: the file's name, for the message.
    key: the dotted key of the wrong value, or ``""``.
    problem: what is wrong with the value, without a subject, such as ``is missing``.
    remedy: an instruction for the user, as a sentence without its full stop.
    others: further errors of the same file. The message has a line for each.

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
    def of_all(cls, file: str, mistakes: Sequence[MistakeParts]) -> DescriptionError:
        """Return one error for all mistakes of a file. Requires at least one mistake."""
        first, *others = (cls(file, *parts[:3], kind="".join(parts[3:])) for parts in mistakes)
        return cls(file, first.key, first.problem, first.remedy, others, kind=first.kind)


class RecordingError(UsageError):
    """A recording cannot be written, read or replayed.

    file: the recording's file.
    problem: the fault of the file.
    remedy: an instruction for the user.
    """

    kind = "recording"

    def __init__(self, file: object, problem: str, remedy: str, *, kind: str = "", **fields: object) -> None:
        super().__init__(f"{file}: {problem}. {remedy}", kind=kind, file=str(file), **fields)


class UnmetNeedError(UsageError):
    """The app needs a role that no device of the robot fills."""

    kind = "unmet-need"


class BackendError(RobotcoreError, RuntimeError):
    """A backend cannot work."""

    kind = "backend"
    exit_status = 3


class BackendMissingError(BackendError, ImportError):
    """A backend's library is not installed. The message says how to install it."""

    kind = "backend-missing"


class GuardianError(BackendError):
    """The guardian process is gone or cannot work. No motor may move without a guardian."""

    kind = "guardian"


class ResourceError(BackendError):
    """The system refuses the program a thread or memory.

    refusal: a sentence that names the refused resource, without its full stop.
    """

    kind = "resource"

    def __init__(self, refusal: str) -> None:
        super().__init__(
            f"{refusal}. End other programs, or raise the limit: ulimit -u and ulimit -v in a shell, TasksMax= and "
            "MemoryMax= in a systemd unit. If the app itself uses up threads or memory, correct the app"
        )
        self.refusal = refusal


class RecordingEndedError(BackendError, EOFError):
    """A replay has reached the end of its recording before the app ended.

    ticks: the number of ticks in the recording.
    time: the recording's length in seconds.
    """

    kind = "recording-ended"

    def __init__(self, ticks: int, time: float) -> None:
        text = f"the recording ends here, after {ticks} ticks, at {time:g} s. The app did not end by then"
        super().__init__(text, ticks=ticks, time_s=time)


class DeviationError(RobotcoreError):
    """A replay differs from its recording."""

    kind = "deviation"


class DeployError(RobotcoreError):
    """A robot cannot be reached, or refuses a release. The robot keeps its present release."""

    kind = "deploy"
    exit_status = 3


class FirmwareError(RobotcoreError):
    """A board's firmware cannot be built or flashed. The message holds the tool's output."""

    kind = "firmware"
    exit_status = 3


class UnprovenError(RobotcoreError):
    """A release failed its tests, its checks or its simulation. The release was not sent to the robot."""

    kind = "unproven"


class UnhealthyError(RobotcoreError):
    """A new release was not healthy in time. The robot runs its previous release again, if it has one."""

    kind = "unhealthy"


class DeviceError(RobotcoreError, OSError):
    """A device failed.

    device: the device's name.
    problem: what failed, such as ``is closed``. The message is ``device: problem``.
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
    """A device is disconnected, for example unplugged. Its driver keeps searching for it, and it may return."""

    kind = "device-lost"


class DeviceGroupError(DeviceError):
    """Several devices failed at once.

    action: the action that failed, such as ``opening rover``.
    failures: the error of each device. The message has a line for each.
    """

    kind = "device-group"

    def __init__(self, action: str, failures: Sequence[Exception]) -> None:
        lines = "".join(f"\n  - {failure}" for failure in failures)
        super().__init__(action, f"{len(failures)} device(s) failed{lines}")
        self.failures = tuple(failures)


class SafetyStop(RobotcoreError):  # noqa: N818  robotics calls it a stop, because it is no bug
    """A safety rule ended the run, and every motor is stopped.

    cause: the name of the rule. Interventions in the trace have the same name.
    """

    kind = "safety-stop"
    exit_status = 4
    cause: ClassVar[str] = "safety stop"


class InvalidCommandError(SafetyStop, ValueError):
    """The app commanded a velocity that is NaN or infinite."""

    kind = "invalid-command"
    cause = "invalid command"


class StaleSampleError(SafetyStop, TimeoutError):
    """A needed sample is too old.

    device: the sensor's name.
    age: the sample's age in seconds.
    limit: the greatest age in seconds that is allowed.
    """

    kind = "stale-sample"
    cause = "stale sample"

    def __init__(self, device: str, age: float, limit: float) -> None:
        super().__init__(
            f"{device}: the newest sample is {age:.3f} s old, the limit is {limit:.3f} s. "
            "Check that the device is connected"
        )
        self.device, self.age, self.limit = device, age, limit


class WatchdogError(SafetyStop, TimeoutError):
    """A call into the app, an observer, a device or a simulator has not returned in time."""

    kind = "watchdog"
    cause = "watchdog"


class EmergencyStopError(SafetyStop):
    """The emergency stop was pressed.

    how: the cause as a clause, such as ``the button on the bench was pressed``.
    """

    kind = "emergency-stop"
    cause = "e-stop"

    def __init__(self, how: str) -> None:
        super().__init__(f"e-stop: {how}")


class WheelFaultError(SafetyStop):
    """The encoders show that wheels do not follow their commands.

    faults: for each such wheel a clause that describes its fault.
    """

    kind = "wheel-fault"
    cause = "wheel fault"

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__(
            f"{', '.join(faults)}. Check if the wheel is blocked, if the motor has power, if its wires are swapped, "
            "and if the encoder works. The time limit is safety.follow_s in the robot's description"
        )


class RangeFaultError(SafetyStop):
    """Range sensors keep returning the same distance while the robot moves.

    faults: for each such sensor a clause that describes its fault.
    """

    kind = "range-fault"
    cause = "range fault"

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__(
            f"{', '.join(faults)}. The sensor may be frozen or measure the robot itself, or the wheels may slip. "
            "The distance limit is safety.stuck_m in the robot's description"
        )


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

        It is empty if there was no exception. It is still available after pickling.
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
            text = f"its text cannot be read, __str__ raised {type(failure).__name__}"
        if len(text) > MAX_EXCEPTION_TEXT:
            text = f"{text[:MAX_EXCEPTION_TEXT]}… ({len(text) - MAX_EXCEPTION_TEXT} more characters)"
        error = cls(f"{app.__name__} raised {type(cause).__name__}{f': {text}' if text else ''}")
        error.__cause__ = cause
        return error


class Interrupted(_Portable):
    """A signal asked the program to end. ``except Exception`` in an app does not catch it."""

    kind = "interrupted"

    def __init__(self, signal_number: int) -> None:
        super().__init__(f"interrupted by {signal.Signals(signal_number).name}")
        self.exit_status = 128 + signal_number


def _trim_traceback(traceback: TracebackType | None) -> TracebackType | None:
    """Return a traceback without its first frames, in which this framework imports or calls the app."""
    while traceback and str(traceback.tb_frame.f_globals.get("__name__")).partition(".")[0] in _CALLERS:
        traceback = traceback.tb_next
    return traceback


def _portable_state(error: _Portable) -> dict[str, Any]:
    """Return an error's kind and fields. A value of another type than `_PLAIN` becomes a text."""
    if not isinstance(error, RobotcoreError):
        return {}
    fields = {name: value if type(value) in _PLAIN else str(value) for name, value in error.fields.items()}
    return {"kind": error.kind, "fields": fields}


def _restore(kind: type[_Portable], args: tuple[Any, ...], state: dict[str, Any]) -> _Portable:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


def suggestion(name: str, known: Sequence[str]) -> str:
    """Return a sentence that suggests the nearest known name, or lists all known names.

    >>> suggestion("gren", ["green", "blue"]), suggestion("xyz", ["green", "blue"])
    ("Did you mean 'green'?", 'There are: blue, green.')
    """
    if close := find_nearest(name, known):
        return f"Did you mean {close!r}?"
    return f"There are: {', '.join(sorted(known)) or 'none'}."


def find_nearest(name: str, known: Sequence[str]) -> str | None:
    """Return the known name that is most similar to a name; None if none is similar."""
    return next(iter(get_close_matches(name, known, n=1, cutoff=0.5)), None)
