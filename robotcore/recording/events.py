"""What a recording tells of a run, in memory: all that steered its decisions, and what was decided.

Times are seconds on the robot's clock, velocities rad/s, angles rad. Every number is the very double of the run.
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
"""A sample as it is in a recording."""

GUARD, ODOMETRY = "guard", "odometry"
"""Who reads sensors besides the app."""

Value = float | int | str | bool | None

_T = TypeVar("_T")

Events = Annotated[tuple[_T, ...], Field(max_length=10_000)]
"""The events of one kind in a tick. An app that polls a sensor in a loop has thousands."""


class SampleKey(NamedTuple):
    """Which sample of a recording: the ``number``-th, from zero, that a device gave. What was shown counts as given."""

    device: str
    number: int


@dataclass(frozen=True, slots=True)
class RecordedError:
    """An error of ours in words: the name of its class in `robotcore.errors`, its message, what it says of itself.

    >>> from robotcore.errors import DeviceError
    >>> Raised.of(DeviceError("nose", "no echo")).rebuild().device
    'nose'
    """

    kind: str
    message: str
    attributes: dict[str, Value] = field(default_factory=dict)

    @classmethod
    def of(cls, error: RobotcoreError | Interrupted) -> RecordedError:
        """Return the record of an error. A subclass that an app has defined is recorded as its robotcore class."""
        kind, _, state = error.__reduce__()[1]
        attributes = {name: value for name, value in state.items() if isinstance(value, Value) and name != "kind"}
        return cls(kind.__name__, str(error), attributes)

    def rebuild(self) -> RobotcoreError | Interrupted:
        """Return the error, to be raised once more; a kind that this version does not know is a RobotcoreError.

        No attribute replaces what the class defines: a file does not decide on exit statuses.
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
    """A device was read: it gave a sample, or it raised.

    ``number`` says which sample of the device it was; None where its picture was dropped. ``by`` is who read it, where
    that was not the app: `GUARD` or `ODOMETRY`.
    """

    device: str
    sequence: int | None = None
    time: float | None = None
    number: int | None = None
    error: RecordedError | None = None
    by: str | None = None

    @property
    def key(self) -> SampleKey | None:
        """Under which the recording has the sample."""
        return None if self.number is None else SampleKey(self.device, self.number)


@dataclass(frozen=True, slots=True)
class ShownPicture:
    """The app showed a picture, or could not; ``number`` is None then, and where the picture was dropped."""

    device: str
    number: int | None = None
    error: RecordedError | None = None

    @property
    def key(self) -> SampleKey | None:
        """Under which the recording has the picture."""
        return None if self.number is None else SampleKey(self.device, self.number)


@dataclass(frozen=True, slots=True)
class DriveCommand:
    """A command of the app and what it was answered, or what it raised; ``asked`` is None where it was a stop."""

    asked: Wheels | None = None
    given: Wheels | None = None
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class MotorCommand:
    """A command to a motor outside the drive and what it answered, or what it raised; ``asked`` is None for a stop."""

    device: str
    asked: float | None = None
    given: float | None = None
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class WheelAngles:
    """The angles of the wheels were read for odometry, or reading them raised."""

    angles: Wheels | None = None
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class Tick:
    """One tick: what the app was given, in the order of each kind, and what it decided.

    ``standing`` is what the stage said was being asked of the wheels, each time that an app which commands one wheel
    alone needed it. ``pose`` is the odometry's, None without a drive. ``asked``, ``sent`` and ``interventions`` are
    those of the tick's commit; ``commit_error`` is why it failed. ``error`` broke the tick off, wherever in
    it: the run ended with it, but for a device that was lost and waited for. ``warnings`` are those of its record.
    """

    number: int
    time: float
    state: str
    reads: Events[Read] = ()
    asks: Events[DriveCommand] = ()
    motor_asks: Events[MotorCommand] = ()
    turned: Events[WheelAngles] = ()
    standing: Events[Wheels] = ()
    pose: Pose | None = None
    asked: Wheels | None = None
    sent: Wheels | None = None
    interventions: Events[Intervention] = ()
    commit_error: RecordedError | None = None
    shown: Events[ShownPicture] = ()
    error: RecordedError | None = None
    warnings: Events[str] = ()


@dataclass(frozen=True, slots=True)
class GroundTruthSample:
    """What the simulator knew after a tick: the true pose, and how many touches there had been. Never replayed.

    ``contacts`` is None where it does not tell.
    """

    tick: int
    time: float
    pose: Pose
    contacts: int | None = None
