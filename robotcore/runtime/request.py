"""The request of a run: the app, the backend, the robot, the world and the options, as the user gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Integral, Real
from types import NoneType
from typing import Annotated, Any

from pydantic import GetPydanticSchema
from pydantic_core.core_schema import str_schema

from robotcore.errors import UsageError
from robotcore.runtime.behaviour import Behaviour

__all__ = ["RunRequest"]


@dataclass(frozen=True)
class RunRequest:
    """The request of a run: the app, the backend, the robot and the world.

    >>> from robotcore import run
    >>> request = RunRequest("avoid-obstacles", seed=7, timeout_s=0.5, settings={"speed_m_s": 0.2})
    >>> run(request).ticks
    11
    """

    app: Annotated[str | type[Behaviour] | Behaviour, GetPydanticSchema(lambda *_: str_schema())]
    """The app's name, its ``.py`` file, its class, or an instance.

    An instance has its own settings, and their values are not checked. Its state remains after the run, so create one
    for each run. A recording stores the name of a class and the settings, so a replay of it needs ``--app FILE.py``.
    """
    backend: str = "kinematic"
    robot: str = "rover"
    """The name of a robot description, or its file."""
    world: str | None = None
    """The name of a world, or its file. If it is None, a simulator uses `DEFAULT_WORLD`."""
    seed: int | None = None
    """The seed from which the layout of the world is drawn. If it is None, the layout is that of the world's file."""
    rate_hz: float = 20.0
    """The number of ticks in a second: `MIN_RATE_HZ` to `MAX_RATE_HZ`."""
    timeout_s: float = 120.0
    """The longest duration of the run, in seconds of the robot's time."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """The app's settings, by name."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """The backend's options, by name."""
    gui: bool = False
    """Whether the simulator opens a window. Simulated time then passes at the pace of real time."""
    realtime: bool = False
    """Whether simulated time passes at the pace of real time."""
    randomise: bool = False
    """Whether the seed also draws the light and colours of the world, the sensor noise and the wheel errors."""
    ideal: bool = False
    """Whether the simulated devices have none of the imperfections that the robot's file describes."""
    judge: str | None = None
    """The app whose ``verify`` decides whether the run was a success. If it is None, the app judges itself."""
    faults: tuple[str, ...] = ()
    """The specifications of the faults to inject."""
    has_operator: bool = False
    """Whether a person may drive the robot in place of the app, by ``RunContext.operator``."""
    has_real_time_priority: bool = False
    """Whether the thread of the ticks has the real-time priority of Linux, on a real robot. See the page "Safety"."""
    has_separate_motors: bool = False
    """Whether the app commands each motor and the steering servo separately. The robot then has no drive.

    No rule compares the wheels with the commands, and no range guard limits them. It is for robots off the ground.
    """

    def __post_init__(self) -> None:
        """Raise UsageError if a value has the wrong type."""
        if isinstance(self.app, type) and not issubclass(self.app, Behaviour):
            raise _build_type_error("app", self.app, _TYPES["app"][1])
        for name, (types, expected) in _TYPES.items():
            if not isinstance(value := getattr(self, name), types):
                raise _build_type_error(name, value, expected)
        if self.seed is not None:
            object.__setattr__(self, "seed", int(self.seed))  # NumPy's integers seed no `random.Random`
        if not all(isinstance(fault, str) for fault in self.faults):
            raise _build_type_error("faults", self.faults, _TYPES["faults"][1])

    @property
    def app_reference(self) -> str:
        """The app's name or file. For a class or an instance, the name of the class."""
        if isinstance(self.app, str):
            return self.app
        return (self.app if isinstance(self.app, type) else type(self.app)).__name__


_TYPES: dict[str, tuple[Any, str]] = {
    "app": (
        (str, type, Behaviour),
        "an app's name or file, as a string, a subclass of Behaviour, or an instance of one",
    ),
    "backend": (str, "the name of a backend"),
    "robot": (str, "a robot's name or file, as a string"),
    "world": ((str, NoneType), "a world's name or file, as a string, or None"),
    "seed": ((Integral, NoneType), "a whole number or None"),
    "rate_hz": (Real, "a number"),
    "timeout_s": (Real, "a number"),
    "settings": (Mapping, 'a dict, such as {"speed_m_s": 0.2}'),
    "options": (Mapping, 'a dict, such as {"port": "/dev/ttyUSB0"}'),
    "judge": ((str, NoneType), "an app's name or file, as a string, or None"),
    "faults": ((tuple, list), 'a tuple of specifications, such as ("camera drop=0.2",)'),
}
"""The types of the fields, and the words for them in an error message."""


def _build_type_error(name: str, value: object, expected: str) -> UsageError:
    return UsageError(
        f"{name} of the RunRequest is {value!r}; it must be {expected}", kind="wrong-type", field=name, value=value
    )
