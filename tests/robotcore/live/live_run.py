"""A run with a live page, in a thread of the test."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event, Thread
from typing import Any, ClassVar

from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.live.address import Address
from robotcore.live.live_view import LiveView
from robotcore.runtime.session import RunContext, RunResult
from tests.robotcore.runs import Watcher

OPENING_S = 20.0


class Circles(Behaviour):
    """Drives in circles, shows the camera's picture on the display, and logs the range."""

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    wants = frozenset({Role.DISPLAY})
    milestones: ClassVar[tuple[str, ...]] = ("turning", "never")

    def step(self, robot: Robot) -> Status:
        if self.state == "start":
            print("the circles begin")  # noqa: T201  the page has the lines of an app
        self.state = "turning"
        image = robot.camera.read().image
        if robot.has(Role.DISPLAY):
            robot.display.show(image)
        robot.log("gap", robot.range.read().distance, "m")
        robot.drive.set_velocity(0.2, 0.8)
        return Status.RUNNING


class Battery(Behaviour):
    """Logs a value, reads no sensor and stands."""

    needs = frozenset({Role.DRIVE})
    name = "battery"

    def step(self, robot: Robot) -> Status:
        robot.log(self.name, 11.0, "V")
        return Status.RUNNING


class LiveRun:
    """A run with a live page. It begins at once, and `stop` ends it.

    request: fields of the `RunRequest`.
    """

    def __init__(self, address: Address, **request: Any) -> None:
        self.view, self.watcher = LiveView(address), Watcher()
        self.result: RunResult | None = None
        self._begun = Event()
        fields = {"app": Circles, "world": "open", "realtime": True, "has_operator": True, "timeout_s": 60.0, **request}
        self._request = RunRequest(**fields)
        self._thread = Thread(target=self._run)
        self._thread.start()
        assert self._begun.wait(OPENING_S)

    @property
    def context(self) -> RunContext:
        context: RunContext = self.watcher.calls[0][1]
        return context

    @property
    def wheels(self) -> list[float]:
        """The velocities to which the simulated motors turn the wheels, in rad/s."""
        simulation: Any = self.context.truth
        return [wheel.target for wheel in simulation._source.wheels.values()]

    def wait(self) -> RunResult:
        """Wait for the end of the run."""
        self._thread.join(OPENING_S)
        assert self.result
        return self.result

    def stop(self) -> None:
        if self._thread.is_alive():
            self.context.emergency.press("the test has ended")
        self._thread.join(OPENING_S)

    def _run(self) -> None:
        self.watcher.begin = self._begin  # type: ignore[assignment, method-assign]
        try:
            self.result = run(self._request, [self.watcher, self.view])
        finally:
            self._begun.set()
            self.view.close()

    def _begin(self, context: RunContext) -> None:
        self.watcher.calls.append(("begin", context))
        self._begun.set()


StartRun = Callable[..., LiveRun]
"""The type of the fixture `start_run`: its arguments are those of `LiveRun`, and the address is the default one."""
