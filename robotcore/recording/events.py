"""The events of a run: everything that the app read, and everything that the app decided.

Times are in seconds on the robot's clock, velocities in rad/s, angles in rad. Every number has exactly the bits that
it had in the run. The names of the fields are the JSON keys in the file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, TypeVar

from pydantic import Field

from robotcore import errors
from robotcore.errors import Interrupted, RobotcoreError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.devices import Angle, Frame, Range, Voltage
from robotcore.safety import Intervention

RecordedSample = Range | Angle | Voltage | Frame
"""A recorded sample."""

GUARD, ODOMETRY = "guard", "odometry"
"""The values of ``Read.by``: the parts other than the app that read sensors."""

Value = float | int | str | bool | None

_T = TypeVar("_T")

Events = Annotated[tuple[_T, ...], Field(max_length=10_000)]
"""The events of one kind in a tick. There may be thousands if an app polls a sensor in a loop."""


class SampleKey(NamedTuple):
    """Identifies a sample in a recording."""

    device: str
    number: int
    """The number of the sample of this device. The first one is 0. Pictures on a display count as samples."""


@dataclass(frozen=True, slots=True)
class RecordedError:
    """A recorded error.

    >>> from robotcore.errors import DeviceError
    >>> RecordedError.of(DeviceError("nose", "no echo")).rebuild().device
    'nose'
    """

    kind: str
    """The name of the error's class in `robotcore.errors`."""
    message: str
    attributes: dict[str, Value] = field(default_factory=dict)

    @classmethod
    def of(cls, error: RobotcoreError | Interrupted) -> RecordedError:
        """Return the record of an error. If an app defined its class, the record names the base class in robotcore."""
        kind, _, state = error.__reduce__()[1]
        attributes = {name: value for name, value in state.items() if isinstance(value, Value) and name != "kind"}
        return cls(kind.__name__, str(error), attributes)

    def rebuild(self) -> RobotcoreError | Interrupted:
        """Build the error from its record. If this version lacks the class, build a RobotcoreError.

        The record cannot change attributes of the class, because a file must not decide on exit statuses.
        """
        kind: type[RobotcoreError | Interrupted] = RobotcoreError
        named = getattr(errors, self.kind, None)
        if isinstance(named, type) and issubclass(named, (RobotcoreError, Interrupted)):
            kind = named
        error = kind.__new__(kind)
        error.args = (self.message,)
        kept = {name: value for name, value in self.attributes.items() if not hasattr(kind, name)}
        error.__dict__.update({"device": "", **kept, "failures": (), "others": ()})
        return error


@dataclass(frozen=True, slots=True)
class Read:
    """A read of a sensor, which returned a sample or raised an error."""

    device: str
    sequence: int | None = None
    """The sequence number of the sample."""
    time: float | None = None
    """The capture time of the sample."""
    number: int | None = None
    """The number of the sample in the recording; None if its picture was dropped."""
    error: RecordedError | None = None
    by: str | None = None
    """The part that read the sensor, `GUARD` or `ODOMETRY`; None for the app."""

    @property
    def key(self) -> SampleKey | None:
        """The key of the sample in the recording."""
        return None if self.number is None else SampleKey(self.device, self.number)


@dataclass(frozen=True, slots=True)
class ShownPicture:
    """A picture that the app sent to a display, or the error of the display."""

    device: str
    number: int | None = None
    """The number of the picture in the recording; None if it was dropped, or if the display failed."""
    error: RecordedError | None = None

    @property
    def key(self) -> SampleKey | None:
        """The key of the picture in the recording."""
        return None if self.number is None else SampleKey(self.device, self.number)


@dataclass(frozen=True, slots=True)
class DriveCommand:
    """A command of the app to the drive, with the velocities that were allowed, or the error."""

    asked: Wheels | None = None
    """The velocities that the app asked for; None is a stop."""
    given: Wheels | None = None
    """The velocities that the safety stage allowed."""
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class MotorCommand:
    """A command of the app to a motor outside the drive, with the velocity that was accepted, or the error."""

    device: str
    asked: float | None = None
    """The velocity that the app asked for; None is a stop."""
    given: float | None = None
    """The velocity that the motor accepted."""
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class WheelAngles:
    """The wheel angles that the odometry read, or the error of that read."""

    angles: Wheels | None = None
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class Tick:
    """One tick: the inputs of the app and its decisions. The events of each kind are in their order."""

    number: int
    time: float
    state: str
    reads: Events[Read] = ()
    asks: Events[DriveCommand] = ()
    motor_asks: Events[MotorCommand] = ()
    turned: Events[WheelAngles] = ()
    standing: Events[Wheels] = ()
    """The current command of the drive each time the app read it. An app that commands a single wheel reads it."""
    pose: Pose | None = None
    """The pose of the odometry; None without a drive."""
    asked: Wheels | None = None
    """The command of the app that was in force at the end of the tick."""
    sent: Wheels | None = None
    """The command that the safety stage sent to the wheels."""
    interventions: Events[Intervention] = ()
    """The changes that the safety stage made to the command."""
    commit_error: RecordedError | None = None
    """The error that prevented the command from being sent; None if it was sent."""
    shown: Events[ShownPicture] = ()
    error: RecordedError | None = None
    """The error that aborted the tick. It ended the run, unless the run waited for a lost device."""
    warnings: Events[str] = ()


@dataclass(frozen=True, slots=True)
class GroundTruthSample:
    """The ground truth of the simulator after a tick. A replay does not use it."""

    tick: int
    time: float
    pose: Pose
    """The true pose in the world."""
    contacts: int | None = None
    """The number of contacts so far; None if the simulator does not count them."""
