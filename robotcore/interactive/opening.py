"""Open a robot for a prompt, a notebook or a script."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import ExitStack, closing, suppress
from math import inf
from pathlib import Path
from typing import Any

from robotcore.errors import Interrupted, RobotcoreError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.hal.robot import Role
from robotcore.interactive import open_robots
from robotcore.interactive.arguments import name_arguments
from robotcore.interactive.live_app import LiveApp
from robotcore.interactive.live_robot import LiveRobot
from robotcore.live.address import Address
from robotcore.live.live_view import LiveView
from robotcore.recording.foxglove_server import PORT, FoxgloveServer
from robotcore.recording.mcap_file import require_recordable
from robotcore.recording.recorder import Recorder
from robotcore.runtime.forced_exit import print_reason
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import Need
from robotcore.runtime.observer import Observer, RunContext
from robotcore.runtime.plan import Plan, RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunSession
from robotcore.runtime.signals import SignalGuard, raise_again
from robotcore.runtime.trace import TickRecord

__all__ = ["open"]

LONGEST_S = 1e9
"""The time limit of a session in seconds, which no session reaches. The user ends a session."""


class _ContextKeeper:
    """An observer that keeps the description of the run."""

    context: RunContext

    def begin(self, run: RunContext) -> None:
        self.context = run

    def tick(self, record: TickRecord) -> None:
        pass

    def end(self, result: RunResult) -> None:
        pass


def open(  # noqa: A001  users write robotcore.open
    robot: str = "rover",
    backend: str = "kinematic",
    *,
    world: str | None = None,
    seed: int | None = None,
    record: str | Path | None = None,
    force: bool = False,
    record_last_s: float | None = None,
    faults: str | Collection[str] = (),
    realtime: bool = False,
    gui: bool = False,
    randomise: bool = False,
    ideal: bool = False,
    rate_hz: float = 20.0,
    options: Mapping[str, Any] | None = None,
    needs: AbstractSet[Need] | None = None,
    view: bool | str = False,
    foxglove: bool | int = False,
) -> LiveRobot:
    """Open a robot whose calls let time pass, with the layers and the safety stage of a run.

    robot: the name of a robot's description, or its file.
    backend: the simulator or the robot, such as ``"raspberrypi"``.
    world: the name of a world, or its file; None for the default world of a simulator.
    seed: the seed from which the layout of the world is drawn.
    record: the ``.mcap`` file of a recording.
    force: whether the recording may replace an existing file.
    record_last_s: the time before the end of the session that the recording keeps, in seconds; None for all of it.
    faults: the specifications of faults to inject, such as ``"range drop=0.2"``.
    realtime: whether simulated time passes at the pace of real time.
    gui: whether the simulator opens its window.
    randomise: whether the seed also draws the light, the noise and the wheel errors.
    ideal: whether the simulated devices have none of the imperfections that the robot's file describes.
    rate_hz: the number of ticks in a second.
    options: the options of the backend, by name.
    needs: the devices to open: roles, names and kinds. None for all devices of the robot.
    view: True to show the robot on a web page, or the page's address, such as ``"0.0.0.0:8080"``. The function prints
        the link. Simulated time then passes at the pace of real time.
    foxglove: True to show the robot in Foxglove, or a port other than 8765. The function prints the address. Simulated
        time then passes at the pace of real time.

    Raises the errors of `robotcore.run` for a request that cannot be planned, and the error of a robot that cannot be
    opened.

    >>> import robotcore
    >>> with robotcore.open("rover", world="arena") as robot:
    ...     print(robot.range.read())
    ...     pose = robot.drive.turn(1.5)  # radians to the left
    ...     robot.ground_truth.contacts
    Range 0.46 m at 0.00 s
    0
    """
    specifications = (faults,) if isinstance(faults, str) else tuple(faults)
    try:
        open_robots.close_lost()
        request = RunRequest(
            _build_app(robot, backend, options or {}, needs),
            backend,
            robot,
            world,
            seed,
            rate_hz,
            LONGEST_S,
            options=options or {},
            gui=gui,
            realtime=realtime or bool(view) or foxglove is not False,
            randomise=randomise,
            ideal=ideal,
            faults=specifications,
        )
        recorder = _build_recorder(record, record_last_s, is_forced=force)
        return open_request(request, recorder=recorder, view=view, foxglove=foxglove)
    except RobotcoreError as error:
        raise name_arguments(error).with_traceback(None) from None


def _build_recorder(record: str | Path | None, last_s: float | None, *, is_forced: bool) -> Recorder | None:
    """Return the recorder of a session. Raises UsageError if the file or the duration is not valid."""
    if last_s is not None and not (record and 0 < last_s < inf):
        raise UsageError(
            f"record_last_s={last_s}: it needs a recording, and a positive number of seconds. "
            'Use record="drive.mcap", record_last_s=600',
            kind="record-last",
            last_s=last_s,
        )
    if record is None:
        return None
    require_recordable(Path(record), is_forced=is_forced)
    return Recorder(Path(record), last_s=last_s)


def open_request(
    request: RunRequest,
    observers: Sequence[Observer] = (),
    *,
    recorder: Recorder | None = None,
    view: bool | str = False,
    foxglove: bool | int = False,
) -> LiveRobot:
    """Open the robot of a request whose app is a `LiveApp`. The other parameters of a run are those of the request.

    observers: objects that get the description of the session, the record of each tick, and the result.
    recorder, view, foxglove: see `open`.

    Raises the errors of `open`.
    """
    plan = Plan.resolve(request)
    keeper, signals = _ContextKeeper(), SignalGuard()
    with ExitStack() as opened:
        server = opened.enter_context(closing(_open_foxglove(foxglove))) if foxglove is not False else None
        page = opened.enter_context(closing(_open_page(view))) if view else None
        own: list[Observer] = [each for each in (keeper, recorder, page, server) if each]
        taps = [each.layer for each in (recorder, server) if each]
        session = RunSession(plan, [*own, *observers], taps, signals, print_reason, 1.0)

        def finish(result: RunResult) -> RunResult:
            if recorder and recorder.failure:
                raise recorder.failure
            return recorder.complete(result) if recorder and recorder.has_begun else result

        live = None
        try:
            with signals:
                loop = _open_loop(session)
                assert isinstance(request.app, LiveApp)
                request.app.truth = keeper.context.truth
                live = LiveRobot(session, loop, keeper.context, signals, finish)
            live.wait(0.0)
        except BaseException as error:
            if live:
                live.close()
                raise
            if session.result is None:  # a signal came before or after `session.open`
                with suppress(Interrupted):
                    session.close(error)
            opened.close()
            if isinstance(error, Interrupted):
                raise_again(error.signal_number)
            raise
        opened.pop_all()
    return live


def _open_page(view: bool | str) -> LiveView:  # noqa: FBT001  of `open`
    page = LiveView(Address.parse(view) if isinstance(view, str) else Address())
    sys.stdout.write(f"{page.describe_link()}\n")
    return page


def _open_foxglove(port: bool | int) -> FoxgloveServer:  # noqa: FBT001  of `open`
    server = FoxgloveServer(PORT if port is True else port)
    sys.stdout.write(f"{server.describe_link()}\n")
    return server


def _open_loop(session: RunSession) -> Loop:
    if loop := session.open():
        return loop
    assert session.result
    assert session.result.error
    raise session.result.error


def _build_app(robot: str, backend: str, options: Mapping[str, Any], needs: AbstractSet[Need] | None) -> LiveApp:
    if needs is not None:
        return LiveApp(needs, frozenset())
    description = load_backend(backend).load_robot(robot, options)
    names = {device.name for device in description.devices}
    return LiveApp(frozenset(), frozenset({*names, Role.DRIVE}))
