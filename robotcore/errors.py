"""Every error this framework raises on purpose, as one tree.

    RobotcoreError
    ├── UsageError (ValueError)              what was asked for cannot be: exit 2
    │   ├── UnknownNameError (LookupError)   no backend, app, robot, world, key of that name
    │   ├── DescriptionError                 a robot or world file is wrong
    │   ├── RecordingError                   a recording cannot be written, read or replayed
    │   └── UnmetNeedError                   the robot lacks what the app needs
    ├── BackendError (RuntimeError)          a backend cannot work: exit 3
    │   ├── BackendMissingError (ImportError)  it is not installed
    │   ├── GuardianError                    nobody would stop the motors if this process could not
    │   ├── ResourceError                    the system refuses the program a thread or memory
    │   └── RecordingEndedError (EOFError)   a replay came to the end of its recording
    ├── DeviceError (OSError)                a device failed: exit 3
    │   ├── DeviceClosedError                it was used after it was closed
    │   ├── DeviceLostError                  its line or plug is gone, and it is being looked for
    │   └── DeviceGroupError                 several failed at once
    ├── DeviationError                       a replay does otherwise than its recording: exit 1
    ├── DeployError                          a robot cannot be reached, or does not take a release: exit 3
    ├── FirmwareError                        a board's firmware cannot be built, or not be put on it: exit 3
    ├── UnprovenError                        what was to be sent did not pass its tests, checks or simulation: exit 1
    ├── UnhealthyError                       the new release did not live, and was rolled back: exit 1
    ├── SafetyStop                           the safety stage ended the run: exit 4
    │   ├── InvalidCommandError (ValueError) a velocity that is no number
    │   ├── StaleSampleError (TimeoutError)  a needed sample is too old
    │   ├── WatchdogError (TimeoutError)     the app has not come back
    │   ├── EmergencyStopError               somebody pressed the e-stop
    │   ├── WheelFaultError                  a wheel does not follow its command
    │   └── RangeFaultError                  a range sensor returns the same distance wherever the robot goes
    └── BehaviourError                       the app raised: exit 5
    Interrupted (BaseException)              a signal ended the run: exit 128 + its number

Each also inherits the builtin that fits, so that ``except ValueError`` works.
"""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from traceback import format_exception
from types import MappingProxyType, TracebackType
from typing import Any, ClassVar

_CALLERS = {"robotcore", "importlib", "_frozen_importlib", "_frozen_importlib_external"}
"""The packages by which an app comes to be called."""


MAX_EXCEPTION_TEXT = 2000
"""As much of an exception's text is kept, in characters: it goes into a line, a table, and each file of a sweep."""


class _Portable(BaseException):
    """An exception that pickles, whatever arguments its constructor takes.

    An app's own subclass arrives as its robotcore class, with the text: other processes do not know the subclass.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        kind = type(self)
        if kind.__module__ == __name__:
            return _restored, (kind, self.args, self.__dict__)
        ours = next(base for base in kind.__mro__ if base.__module__ == __name__)
        return _restored, (ours, (str(self),), {})


class RobotcoreError(_Portable, Exception):
    """The root of the tree; the message is meant for the user as it stands.

    kind: a stable identifier of what happened, in kebab-case. Each class has one; a raise may give a narrower one.
    fields: the values that the message holds, by name.

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


class UsageError(RobotcoreError, ValueError):
    """What was asked for cannot be done; nothing has moved."""

    kind = "usage"
    exit_status = 2


class UnknownNameError(UsageError, LookupError):
    """There is nothing of that name; what was ``meant`` is offered, or the nearest one that is known."""

    kind = "unknown-name"

    def __init__(self, kind: str, name: str, known: Sequence[str], meant: str = "") -> None:
        super().__init__(
            f"unknown {kind} {name!r}. {f'Did you mean {meant}?' if meant else suggestion(name, known)}",
            kind=f"unknown-{kind.replace(' ', '-')}",
        )
        self.name = name


class DescriptionError(UsageError):
    """A description is wrong: the file, the key, the fault and the remedy, in one line.

    What else is wrong with it, ``others``, has a line each.
    """

    kind = "description"

    def __init__(self, file: str, key: str, fault: str, remedy: str, others: Sequence[DescriptionError] = ()) -> None:
        where = f"{file}: {key}" if key else file
        super().__init__("\n".join((f"{where}: {fault}. {remedy}", *map(str, others))))
        self.file, self.key, self.fault, self.remedy = file, key, fault, remedy
        self.others = tuple(others)

    @classmethod
    def of_all(cls, file: str, faults: Sequence[tuple[str, str, str]]) -> DescriptionError:
        """Return the error for all that is wrong with a file, at least one: key, fault and remedy of each."""
        first, *others = faults
        return cls(file, *first, others=[cls(file, *other) for other in others])


class RecordingError(UsageError):
    """A recording cannot be written, read or replayed: the file, what is wrong with it, the remedy."""

    kind = "recording"

    def __init__(self, file: object, fault: str, remedy: str, *, kind: str = "", **fields: object) -> None:
        super().__init__(f"{file}: {fault}. {remedy}", kind=kind, file=str(file), **fields)


class UnmetNeedError(UsageError):
    """The app needs a role that the robot's description does not fill."""

    kind = "unmet-need"


class BackendError(RobotcoreError, RuntimeError):
    """A backend cannot do its work."""

    kind = "backend"
    exit_status = 3


class BackendMissingError(BackendError, ImportError):
    """A backend's own library is not installed; the message says how to get it."""

    kind = "backend-missing"


class GuardianError(BackendError):
    """The guardian process is gone, or cannot do its work; nothing moves without it."""

    kind = "guardian"


class ResourceError(BackendError):
    """The system refuses the program a thread or memory; ``refusal`` says which one."""

    kind = "resource"

    def __init__(self, refusal: str) -> None:
        super().__init__(
            f"{refusal}. End other programs, or raise the limit: ulimit -u and ulimit -v in a shell, TasksMax= and "
            "MemoryMax= in a systemd unit. If the app itself uses up threads or memory, correct the app"
        )
        self.refusal = refusal


class RecordingEndedError(BackendError, EOFError):
    """A replay came to the end of its recording, and the app would have gone on."""

    kind = "recording-ended"

    def __init__(self, ticks: int, time: float) -> None:
        text = f"the recording ends here, after {ticks} ticks, at {time:g} s; the app would have gone on"
        super().__init__(text, ticks=ticks, time_s=time)


class DeviationError(RobotcoreError):
    """A replay does otherwise than its recording."""

    kind = "deviation"


class DeployError(RobotcoreError):
    """A robot cannot be reached, or does not take what is sent; the release that runs there is as it was."""

    kind = "deploy"
    exit_status = 3


class FirmwareError(RobotcoreError):
    """A board's firmware cannot be built, or cannot be put on the board; with what the tool said."""

    kind = "firmware"
    exit_status = 3


class UnprovenError(RobotcoreError):
    """What was to be sent did not pass its tests, its checks or its simulation; nothing was sent."""

    kind = "unproven"


class UnhealthyError(RobotcoreError):
    """A release was not healthy within its time; the one before it runs again, where there was one."""

    kind = "unhealthy"


class DeviceError(RobotcoreError, OSError):
    """A device failed; says which one and why."""

    kind = "device"
    exit_status = 3

    def __init__(self, device: str, fault: str, *, kind: str = "", **fields: object) -> None:
        super().__init__(f"{device}: {fault}", kind=kind, **fields)
        self.device = device


class DeviceClosedError(DeviceError):
    """A device was used after it was closed."""

    kind = "device-closed"

    def __init__(self, device: str) -> None:
        super().__init__(device, "is closed; open the robot again to use it")


class DeviceLostError(DeviceError):
    """A device is gone, such as one that was unplugged; its driver goes on looking for it, and it may come back."""

    kind = "device-lost"


class DeviceGroupError(DeviceError):
    """Several devices failed at once; each is a branch of the message."""

    kind = "device-group"

    def __init__(self, doing: str, failures: Sequence[Exception]) -> None:
        branches = "".join(f"\n  - {failure}" for failure in failures)
        super().__init__(doing, f"{len(failures)} device(s) failed{branches}")
        self.failures = tuple(failures)


class SafetyStop(RobotcoreError):  # noqa: N818  the field's word: it ends a run, it is no bug
    """The safety stage ended the run; every motor is stopped. ``cause`` names the rule, as interventions do."""

    kind = "safety-stop"
    exit_status = 4
    cause: ClassVar[str] = "safety stop"


class InvalidCommandError(SafetyStop, ValueError):
    """A velocity that is NaN or infinite was asked for."""

    kind = "invalid-command"
    cause = "invalid command"


class StaleSampleError(SafetyStop, TimeoutError):
    """A sample that was needed is older than its limit."""

    kind = "stale-sample"
    cause = "stale sample"

    def __init__(self, device: str, age: float, limit: float) -> None:
        super().__init__(
            f"{device}: the newest sample is {age:.3f} s old, the limit is {limit:.3f} s; "
            "is the device still connected?"
        )
        self.device, self.age, self.limit = device, age, limit


class WatchdogError(SafetyStop, TimeoutError):
    """The app, or what watches its run, has not come back."""

    kind = "watchdog"
    cause = "watchdog"


class EmergencyStopError(SafetyStop):
    """Somebody pressed the e-stop."""

    kind = "emergency-stop"
    cause = "e-stop"

    def __init__(self, how: str) -> None:
        super().__init__(f"e-stop: {how}")


class WheelFaultError(SafetyStop):
    """By their encoders, wheels do not follow their commands; ``faults`` describes each."""

    kind = "wheel-fault"
    cause = "wheel fault"

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__(
            f"{', '.join(faults)}. Look whether the wheel is blocked, the motor has no power or its wires are swapped, "
            "or the encoder is broken; how long it may take is safety.follow_s in the robot's description"
        )


class RangeFaultError(SafetyStop):
    """Range sensors return the same distance wherever the robot goes; ``faults`` describes each."""

    kind = "range-fault"
    cause = "range fault"

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__(
            f"{', '.join(faults)}. Look whether the sensor hangs or hears a part of the robot, or the wheels spin and "
            "it stands; how far it may go meanwhile is safety.stuck_m in the robot's description"
        )


class BehaviourError(RobotcoreError):
    """The app's own code raised; the cause carries its traceback."""

    kind = "behaviour"
    exit_status = 5
    _traceback_text = ""

    def __reduce__(self) -> tuple[Any, ...]:
        restored, (kind, args, state) = super().__reduce__()
        return restored, (kind, args, {**state, "_traceback_text": self.traceback})

    @property
    def traceback(self) -> str:
        """The cause's traceback in words, from the app's own code on; empty where there is no cause.

        It survives pickling.
        """
        if (cause := self.__cause__) is None:
            return self._traceback_text
        return "".join(format_exception(type(cause), cause, _from_the_app_on(cause.__traceback__)))

    @classmethod
    def raised_by(cls, app: type, cause: BaseException) -> BehaviourError:
        """Return the error for an exception of an app's code; a very long text of it is cut."""
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
    """A signal asked the program to end. No ``except Exception`` of an app holds it up."""

    kind = "interrupted"

    def __init__(self, signal_number: int) -> None:
        super().__init__(f"interrupted by {signal.Signals(signal_number).name}")
        self.exit_status = 128 + signal_number


def _from_the_app_on(traceback: TracebackType | None) -> TracebackType | None:
    """Return a traceback without its beginning, in which this framework imports or calls an app."""
    while traceback and str(traceback.tb_frame.f_globals.get("__name__")).partition(".")[0] in _CALLERS:
        traceback = traceback.tb_next
    return traceback


def _restored(kind: type[_Portable], args: tuple[Any, ...], state: dict[str, Any]) -> _Portable:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


def suggestion(name: str, known: Sequence[str]) -> str:
    """Say which known name was probably meant, or list them all."""
    if close := nearest(name, known):
        return f"Did you mean {close!r}?"
    return f"There are: {', '.join(sorted(known)) or 'none'}."


def nearest(name: str, known: Sequence[str]) -> str | None:
    """Return which known name was probably meant, if one was."""
    return next(iter(get_close_matches(name, known, n=1, cutoff=0.5)), None)
