"""Write a robot's behaviour once, test it in simulators, and run the same file on the real robot.

Apps, notebooks and tests of apps need to import only this package. A module of the package is imported when one of its
names is first used, so that the command line starts fast.

>>> import robotcore
>>> result = robotcore.run(robotcore.RunRequest(app="green-search", backend="kinematic", seed=7))
>>> result.outcome.value, result.contacts
('success', 0)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from robotcore.python_versions import require_supported_python

require_supported_python()

if TYPE_CHECKING:
    from robotcore import errors as errors
    from robotcore import kinds as kinds
    from robotcore import testing as testing
    from robotcore.autonomy import navigation as navigation
    from robotcore.autonomy import vision as vision
    from robotcore.autonomy.manoeuvres import arc as arc
    from robotcore.autonomy.manoeuvres import face as face
    from robotcore.autonomy.manoeuvres import follow_path as follow_path
    from robotcore.autonomy.manoeuvres import go_to as go_to
    from robotcore.autonomy.manoeuvres import move as move
    from robotcore.autonomy.manoeuvres import straight as straight
    from robotcore.autonomy.manoeuvres import turn as turn
    from robotcore.autonomy.navigation import Navigator as Navigator
    from robotcore.autonomy.navigation import OccupancyGrid as OccupancyGrid
    from robotcore.autonomy.routines import Routine as Routine
    from robotcore.autonomy.routines import on_stop as on_stop
    from robotcore.autonomy.routines import parallel as parallel
    from robotcore.autonomy.routines import race as race
    from robotcore.autonomy.routines import repeat as repeat
    from robotcore.autonomy.routines import sequence as sequence
    from robotcore.autonomy.routines import until as until
    from robotcore.autonomy.routines import wait as wait
    from robotcore.autonomy.routines import wait_until as wait_until
    from robotcore.autonomy.routines import with_timeout as with_timeout
    from robotcore.errors import BlockedError as BlockedError
    from robotcore.errors import DeviceError as DeviceError
    from robotcore.geometry import Pose as Pose
    from robotcore.geometry import Twist as Twist
    from robotcore.hal.robot import Robot as Robot
    from robotcore.hal.robot import Role as Role
    from robotcore.hal.truth import Truth as Truth
    from robotcore.interactive.live_robot import LiveRobot as LiveRobot
    from robotcore.interactive.opening import open as open  # noqa: A004
    from robotcore.optics import Image as Image
    from robotcore.runtime.behaviour import Behaviour as Behaviour
    from robotcore.runtime.behaviour import Status as Status
    from robotcore.runtime.behaviour import Stopping as Stopping
    from robotcore.runtime.plan import RunRequest as RunRequest
    from robotcore.runtime.result import Outcome as Outcome
    from robotcore.runtime.result import RunResult as RunResult
    from robotcore.runtime.session import run as run
    from robotcore.runtime.settings import Interval as Interval
    from robotcore.runtime.settings import Positive as Positive

_MODULES = {
    "Behaviour": "runtime.behaviour",
    "BlockedError": "errors",
    "DeviceError": "errors",
    "Image": "optics",
    "LiveRobot": "interactive.live_robot",
    "Interval": "runtime.settings",
    "Navigator": "autonomy.navigation",
    "OccupancyGrid": "autonomy.navigation",
    "Outcome": "runtime.result",
    "Pose": "geometry",
    "Positive": "runtime.settings",
    "Robot": "hal.robot",
    "Role": "hal.robot",
    "Routine": "autonomy.routines",
    "RunRequest": "runtime.plan",
    "RunResult": "runtime.result",
    "Status": "runtime.behaviour",
    "Stopping": "runtime.behaviour",
    "Truth": "hal.truth",
    "Twist": "geometry",
    "arc": "autonomy.manoeuvres",
    "face": "autonomy.manoeuvres",
    "follow_path": "autonomy.manoeuvres",
    "go_to": "autonomy.manoeuvres",
    "move": "autonomy.manoeuvres",
    "on_stop": "autonomy.routines",
    "open": "interactive.opening",
    "parallel": "autonomy.routines",
    "race": "autonomy.routines",
    "repeat": "autonomy.routines",
    "run": "runtime.session",
    "sequence": "autonomy.routines",
    "straight": "autonomy.manoeuvres",
    "turn": "autonomy.manoeuvres",
    "until": "autonomy.routines",
    "wait": "autonomy.routines",
    "wait_until": "autonomy.routines",
    "with_timeout": "autonomy.routines",
}
"""A mapping from each public name to the module that defines it."""

_PACKAGES = {
    "errors": "errors",
    "kinds": "kinds",
    "navigation": "autonomy.navigation",
    "testing": "testing",
    "vision": "autonomy.vision",
}

__all__ = [
    "Behaviour",
    "BlockedError",
    "DeviceError",
    "Image",
    "Interval",
    "LiveRobot",
    "Navigator",
    "OccupancyGrid",
    "Outcome",
    "Pose",
    "Positive",
    "Robot",
    "Role",
    "Routine",
    "RunRequest",
    "RunResult",
    "Status",
    "Stopping",
    "Truth",
    "Twist",
    "arc",
    "errors",
    "face",
    "follow_path",
    "go_to",
    "kinds",
    "move",
    "navigation",
    "on_stop",
    "open",
    "parallel",
    "race",
    "repeat",
    "run",
    "sequence",
    "straight",
    "testing",
    "turn",
    "until",
    "vision",
    "wait",
    "wait_until",
    "with_timeout",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from robotcore.compatibility import read_version

        return read_version()
    if name in _PACKAGES:
        return import_module(f"robotcore.{_PACKAGES[name]}")
    if name not in _MODULES:
        raise AttributeError(f"module 'robotcore' has no attribute {name!r}")
    return getattr(import_module(f"robotcore.{_MODULES[name]}"), name)


def __dir__() -> "list[str]":
    return list(__all__)
