"""The recorded events of a run: the reads and the decisions of the app in each tick.

Times are in seconds on the robot's clock, velocities in rad/s, angles in rad. The names of the fields are the JSON keys
in the file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import Field

from robotcore import errors
from robotcore.errors import Interrupted, RobotcoreError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.drive import WheelPath
from robotcore.safety.velocity_limits import Intervention

GUARD, ODOMETRY = "guard", "odometry"
"""The values of ``Read.by``: the range guard and the odometry, which read sensors too."""

Value = float | int | str | bool | None

_T = TypeVar("_T")

Events = Annotated[tuple[_T, ...], Field(max_length=10_000)]
"""The events of one kind in a tick. The limit protects the reader against hostile files."""


class SampleKey(NamedTuple):
    """The key of a sample in a recording.

    >>> SampleKey(device="nose", number=24)
    SampleKey(device='nose', number=24)
    """

    device: str
    number: int
    """The number of the sample among those of the device, from 0. A picture on a display is a sample too."""


@dataclass(frozen=True, slots=True)
class RecordedError:
    """The class, the message and the attributes of an error in a recording.

    >>> from robotcore.errors import DeviceError
    >>> RecordedError.from_error(DeviceError("nose", "no echo")).rebuild().device
    'nose'
    """

    kind: str
    """The name of the error's class in `robotcore.errors`."""
    message: str
    attributes: dict[str, Value] = field(default_factory=dict)

    @classmethod
    def from_error(cls, error: RobotcoreError | Interrupted) -> RecordedError:
        """Return the record of an error. For a class of an app, ``kind`` is its base class in robotcore."""
        kind, _, state = error.__reduce__()[1]
        attributes = {name: value for name, value in state.items() if isinstance(value, Value) and name != "kind"}
        return cls(kind.__name__, str(error), attributes)

    def rebuild(self) -> RobotcoreError | Interrupted:
        """Return the error as an exception. An unknown class becomes RobotcoreError.

        A recorded attribute does not replace an attribute of the class, so a file cannot change an exit status.
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
    """A read of a sensor, which returned a sample or raised an error.

    >>> Read("nose", sequence=25, time=1.25, number=24).key
    SampleKey(device='nose', number=24)
    >>> Read("eye", sequence=25, time=1.25).key is None  # its picture was dropped
    True
    """

    device: str
    sequence: int | None = None
    """The sequence number of the sample."""
    time: float | None = None
    """The capture time of the sample, in seconds."""
    number: int | None = None
    """The number of the sample in its `SampleKey`; None if its picture was dropped."""
    error: RecordedError | None = None
    by: str | None = None
    """The reader of the sensor: `GUARD`, `ODOMETRY`, or None for the app."""

    @property
    def key(self) -> SampleKey | None:
        """The key of the sample in the recording; None if it was not recorded."""
        return None if self.number is None else SampleKey(self.device, self.number)


@dataclass(frozen=True, slots=True)
class ShownPicture:
    """A picture that the app sent to a display, or the error of the display.

    >>> ShownPicture("screen", number=3).key
    SampleKey(device='screen', number=3)
    """

    device: str
    number: int | None = None
    """The number of the picture in its `SampleKey`; None if it was dropped or the display failed."""
    error: RecordedError | None = None

    @property
    def key(self) -> SampleKey | None:
        """The key of the picture in the recording; None if it was not recorded."""
        return None if self.number is None else SampleKey(self.device, self.number)


@dataclass(frozen=True, slots=True)
class DriveCommand:
    """A command of the app to the drive, with the allowed velocities or the raised error.

    >>> from robotcore.geometry import Wheels
    >>> command = DriveCommand(asked=Wheels(9.0, 9.0), given=Wheels(3.0, 3.0))
    >>> command.given != command.asked  # the safety stage has changed it
    True
    """

    asked: Wheels | None = None
    """The velocities that the app commanded, in rad/s; None is a stop."""
    given: Wheels | None = None
    """The velocities that the safety stage allowed, in rad/s."""
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class MotorCommand:
    """A command of the app to a motor outside the drive, with the accepted velocity or the raised error.

    >>> MotorCommand("arm", asked=99.0, given=10.0).given
    10.0
    """

    device: str
    asked: float | None = None
    """The velocity that the app commanded, in rad/s; None is a stop."""
    given: float | None = None
    """The velocity that the motor accepted, in rad/s."""
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class ActuatorCommand:
    """A command of the app to an actuator, with the command that was sent or the raised error."""

    device: str
    asked: Any = None
    """The command of the app, as JSON."""
    given: Any = None
    """The command that was sent, as JSON."""
    error: RecordedError | None = None


@dataclass(frozen=True, slots=True)
class WheelAngles:
    """The wheel angles that the odometry read, or the raised error.

    >>> from robotcore.geometry import Wheels
    >>> from robotcore.hal.drive import WheelPath
    >>> WheelAngles.from_path(WheelPath(Wheels(1.0, 3.0)), error=None).path.angles
    Wheels(left=1, right=3)
    """

    angles: Wheels | None = None
    error: RecordedError | None = None
    between: Annotated[tuple[Wheels, ...], Field(max_length=10_000)] = ()
    """The angles between the last reading and this one. Older recordings have none."""

    @classmethod
    def from_path(cls, path: WheelPath | None, error: RecordedError | None) -> WheelAngles:
        """Return the event of a reading, which returned a path or raised an error."""
        return cls(path.angles, error, path.between) if path else cls(None, error)

    @property
    def path(self) -> WheelPath | None:
        """The path of the wheels. None if the reading raised an error."""
        return WheelPath(self.angles, self.between) if self.angles else None


@dataclass(frozen=True, slots=True)
class Tick:
    """One tick: the inputs and the decisions of the app. The events of each kind are in the order of time.

    >>> from robotcore.geometry import Wheels
    >>> from robotcore.recording import Read
    >>> tick = Tick(number=25, time=1.25, state="search", reads=(Read("nose", 25, 1.25, 24),), asked=Wheels(3.0, 3.0))
    >>> [read.device for read in tick.reads], tick.asked
    (['nose'], Wheels(left=3, right=3))
    """

    number: int
    time: float
    state: str
    reads: Events[Read] = ()
    asks: Events[DriveCommand] = ()
    motor_asks: Events[MotorCommand] = ()
    turned: Events[WheelAngles] = ()
    pose: Pose | None = None
    """The pose by odometry, relative to the start; None without a drive."""
    asked: Wheels | None = None
    """The last command of the app to the drive, in rad/s."""
    sent: Wheels | None = None
    """The velocities that the safety stage sent to the motors at the end of the tick, in rad/s."""
    interventions: Events[Intervention] = ()
    """The changes of the command by the safety stage."""
    commit_error: RecordedError | None = None
    """The error that occurred when the command was sent; None if there was none."""
    shown: Events[ShownPicture] = ()
    commands: Events[ActuatorCommand] = ()
    """The commands to actuators other than motors and displays."""
    error: RecordedError | None = None
    """The error that aborted the tick. It ended the run, unless the run waited for a lost device to return."""
    warnings: Events[str] = ()

    def list_commands(self) -> list[MotorCommand | ActuatorCommand]:
        """Return the commands to motors outside the drive, and then to actuators other than motors and displays."""
        return [*self.motor_asks, *self.commands]


@dataclass(frozen=True, slots=True)
class GroundTruthSample:
    """The ground truth of a simulator after a tick. A replay does not use it.

    >>> from robotcore import Pose
    >>> GroundTruthSample(tick=25, time=1.25, pose=Pose(0.5, 0.0, 0.1), contacts=0).pose
    Pose(x=0.5 m, y=0 m, heading=0.1 rad)
    """

    tick: int
    time: float
    pose: Pose
    """The true pose of the robot in the world."""
    contacts: int | None = None
    """The number of contacts since the start; None if the simulator does not count them."""
