"""The base class of apps. An app is a class that inherits Behaviour, and defines ``step`` or ``run``."""

from __future__ import annotations

import atexit
import reprlib
import sys
from collections.abc import Generator
from collections.abc import Set as AbstractSet
from enum import Enum
from inspect import GEN_CLOSED, getgeneratorstate, isgeneratorfunction, signature
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

from robotcore.autonomy.pending_routine import warn_if_dropped
from robotcore.autonomy.routines import Routine, require_plain_yield
from robotcore.errors import BehaviourError
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.runtime.needs import Need

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["Behaviour", "Status", "Stopping"]


class Status(Enum):
    """The result of a behaviour's step.

    >>> [status.name for status in Status]
    ['RUNNING', 'SUCCESS', 'FAILURE']
    """

    RUNNING = "running"
    """The behaviour continues in the next tick."""
    SUCCESS = "success"
    """The behaviour has reached its goal, and ends."""
    FAILURE = "failure"
    """The behaviour cannot reach its goal, and ends."""


class Stopping(NamedTuple):
    """How an app stops in front of obstacles.

    >>> from robotcore import Behaviour
    >>> class Careful(Behaviour):
    ...     @property
    ...     def stopping(self):
    ...         return Stopping(distance=0.28, speed=0.2)
    >>> Careful().stopping
    Stopping(distance=0.28, speed=0.2)
    """

    distance: float
    """The distance to the obstacle at which the app stops, in metres."""
    speed: float
    """The speed at which the app approaches an obstacle, in m/s."""


class Behaviour:
    """The base class of apps. An app defines one of two methods, which command the robot.

    ``step`` runs once in each tick, and returns a status. ``run`` is a generator for a sequence of actions: one
    ``yield`` ends a tick, and the generator returns ``Status.SUCCESS`` or ``Status.FAILURE``. An app with ``step``
    inherits a ``run``, so that ``yield from Other().run(robot)`` contains an app of either form.

    An app must not sleep, read the wall clock, read files or use a network. Make it a dataclass. The fields are then
    the app's settings (``--set speed_m_s=0.2``), and robotcore checks their types.

    An app with ``step``, on scripted distances:

    >>> from dataclasses import dataclass
    >>> from robotcore import Role, Status
    >>> from robotcore.testing import MockRobot
    >>> @dataclass
    ... class Reflex(Behaviour):
    ...     near_m: float = 0.4
    ...     needs = frozenset({Role.DRIVE, Role.RANGE})
    ...
    ...     def step(self, robot):
    ...         is_near = robot.range.read().distance < self.near_m
    ...         robot.drive.set_velocity(0.0 if is_near else 0.2, 1.0 if is_near else 0.0)
    ...         return Status.RUNNING
    >>> robot = MockRobot(range=[1.0, 0.2])
    >>> robot.run(Reflex(), ticks=2)
    <Status.RUNNING: 'running'>
    >>> [wheels.left == wheels.right for wheels in robot.wheels]  # ahead, then a turn
    [True, False]

    An app with ``run``, in a simulator:

    >>> from robotcore import RunRequest, Role, run, straight, turn
    >>> class Corner(Behaviour):
    ...     needs = frozenset({Role.DRIVE})
    ...
    ...     def run(self, robot):
    ...         yield from straight(robot, 0.2)  # metres
    ...         yield from turn(robot, 0.5)  # radians
    ...         return Status.SUCCESS
    >>> run(RunRequest(Corner, world="open")).outcome.value
    'success'
    """

    needs: ClassVar[AbstractSet[Need]] = frozenset()
    """The devices that the app requires: roles, names of devices, and classes of kinds, such as ``Role.DRIVE``,
    ``"rear"`` and ``Camera``. A run opens only the devices of ``needs`` and ``wants``."""
    wants: ClassVar[AbstractSet[Need]] = frozenset()
    """The devices that the app uses if the robot has them."""
    turns_on_spot: ClassVar[bool] = False
    """Whether the app makes the robot turn on the spot. A run is refused for a robot that cannot."""
    milestones: ClassVar[tuple[str, ...]] = ()
    """The states whose first time is recorded. A milestone is reached when ``state`` first equals its name."""
    state: str = "start"
    """The app's present state, such as ``search``. The trace contains it."""
    reason: str = ""
    """Why the app ended, for the result."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name, method in list(vars(cls).items()):
            if isgeneratorfunction(method):
                setattr(cls, name, warn_if_dropped(method))
        if cls.__module__ == "__main__" and hasattr(sys.modules["__main__"], "__file__"):  # not an interactive session
            atexit.unregister(_advise_to_run)
            atexit.register(_advise_to_run, cls.__name__, sys.argv[0])

    def __new__(cls, *_arguments: Any, **_settings: Any) -> Self:
        atexit.unregister(_advise_to_run)
        return super().__new__(cls)

    __routine: Routine[Status] | None = None
    """The generator of ``run``. None before the first tick and after the last one."""

    def step(self, robot: Robot) -> Status:
        """Read sensors, command the drive, and return the status of the app. The loop calls this once in each tick.

        An app that defines ``run`` inherits this method, which runs the generator until its next ``yield``.
        """
        if self.__routine is None or self.has_failed_routine:
            require_callable(self, "run")
            self.__routine = _require_generator(self, self.run(robot))
        try:
            yielded: object = next(self.__routine)
        except StopIteration as end:
            self.__routine = None
            return _require_end(self, end.value)
        require_plain_yield(self.__routine, yielded)
        return Status.RUNNING

    @warn_if_dropped
    def run(self, robot: Robot) -> Routine[Status]:
        """Command the robot in a sequence of actions. One ``yield`` ends a tick. Return ``SUCCESS`` or ``FAILURE``.

        An app that defines ``step`` inherits this method, so that the ``run`` of another app can contain it.
        """
        require_callable(self, "step")
        while (status := require_status(self, self.step(robot))) is Status.RUNNING:
            yield
        return status

    @property
    def has_failed_routine(self) -> bool:
        """Whether the generator of ``run`` has ended with an exception, so that it cannot continue."""
        return self.__routine is not None and getgeneratorstate(self.__routine) == GEN_CLOSED

    @property
    def has_open_routine(self) -> bool:
        """Whether the generator of ``run`` has begun and not ended."""
        return self.__routine is not None and not self.has_failed_routine

    def close_routine(self) -> None:
        """Close the generator of ``run``, so that its clean-up runs. The loop calls this at the end of the run."""
        if routine := self.__routine:
            self.__routine = None
            routine.close()

    @property
    def stopping(self) -> Stopping | None:
        """How the app stops in front of obstacles. None if it does not stop by itself.

        A run is refused if the range guard would stop the robot earlier.
        """
        return None

    def verify(self, truth: Truth) -> bool | None:
        """Return whether a run was a success, by the true state of the simulator at its end.

        Return None if this app cannot decide it.
        """
        return None


def require_declarations(app: Behaviour) -> None:
    """Raise BehaviourError if a declaration of an app is wrong.

    It must define either ``step`` or ``run``. Its milestones must be texts, and its ``stopping`` a Stopping.
    """
    name = type(app).__name__
    has_step, has_run = type(app).step is not Behaviour.step, type(app).run is not Behaviour.run
    if has_step and has_run:
        text = f"{name} defines step and run. Define one of them: step for one tick, run for a sequence of actions"
        raise BehaviourError(text, kind="step-and-run")
    if not has_step and not has_run:
        text = f"{name} has no method step. Define step or run in the class, indented below the class line"
        raise BehaviourError(text, kind="method-missing", method="step")
    milestones: object = app.milestones
    if not isinstance(milestones, (tuple, list)) or not all(isinstance(each, str) for each in milestones):
        remedy = 'Write a tuple of texts, with a comma after each: milestones = ("go",)'
        raise BehaviourError(f"{name}.milestones is {milestones!r:.100}. {remedy}", kind="milestones-not-texts")
    try:
        stopping: object = app.stopping
    except Exception as error:
        raise BehaviourError.from_exception(type(app), error) from error
    if stopping is not None and not isinstance(stopping, Stopping):
        problem = f"{stopping!r:.100}. Return a Stopping: Stopping(0.28, 0.2)"
        problem = "a method. Put @property above def stopping" if callable(stopping) else problem
        raise BehaviourError(f"{name}.stopping is {problem}", kind="not-a-stopping")


def find_defined_method(app: Behaviour) -> Literal["step", "run"]:
    """Return which of the two methods an app defines."""
    return "step" if type(app).step is not Behaviour.step else "run"


def require_callable(app: Behaviour, name: Literal["step", "run", "verify"]) -> None:
    """Raise BehaviourError if an attribute hides a method of an app, or if the method does not take its argument."""
    method: object = getattr(app, name)
    label = f"{type(app).__name__}.{name}"
    if not callable(method):
        text = f"{label} is {method!r:.100}, which hides the method {name}. Choose another name for the attribute"
        raise BehaviourError(text, kind="method-hidden", method=name)
    try:
        signature(method).bind(None)
    except TypeError:
        argument = "truth" if name == "verify" else "robot"
        text = f"{label} does not take the argument {argument}. Write def {name}(self, {argument})"
        raise BehaviourError(text, kind="wrong-parameters", method=name) from None


def require_status(app: Behaviour, status: object) -> Status:
    """Return the result of an app's ``step``. Raises BehaviourError if it is no Status."""
    if isinstance(status, Status):
        return status
    text = f"{type(app).__name__}.step returned {reprlib.repr(status)}. Return a Status, such as Status.RUNNING"
    raise BehaviourError(text, kind="not-a-status")


def _require_generator(app: Behaviour, routine: object) -> Routine[Status]:
    if isinstance(routine, Generator):
        return iter(routine)  # the generator of a `PendingRoutine`
    text = f"{type(app).__name__}.run returned {reprlib.repr(routine)} and contains no yield. Write yield to end a tick"
    text += ", yield from in front of a routine, or define step in place of run"
    raise BehaviourError(text, kind="not-a-generator")


def _require_end(app: Behaviour, status: object) -> Status:
    if status is Status.SUCCESS or status is Status.FAILURE:
        return status
    text = f"{type(app).__name__}.run returned {reprlib.repr(status)}. Return Status.SUCCESS or Status.FAILURE"
    raise BehaviourError(text, kind="not-a-status")


def _advise_to_run(app: str, file: str) -> None:
    """Write a note at the end of ``python my_app.py`` if the script defines an app, but creates none."""
    if sys.stderr and not hasattr(sys, "last_value"):  # an exception has not ended the script
        defined = vars(sys.modules["__main__"]).values()
        apps = [each for each in defined if isinstance(each, type) and each.__module__ == "__main__"]
        has_several = sum(issubclass(each, Behaviour) for each in apps) > 1
        name = f"{file}:{app}" if has_several else file
        sys.stderr.write(f"note: {file} defines the app {app}, but does not run it. Run it: robotcore run {name}\n")
