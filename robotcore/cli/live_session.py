"""Opens a robot for a command that drives it step by step, with the space bar as the e-stop."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from contextlib import ExitStack, closing, contextmanager
from typing import TYPE_CHECKING, Any

from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.runtime.needs import Need


@contextmanager
def open_live_robot(
    robot: str,
    backend: str,
    *,
    world: str | None = None,
    seed: int | None = None,
    rate_hz: float = 20.0,
    options: Mapping[str, Any],
    needs: AbstractSet[Need] = frozenset(),
    wants: AbstractSet[Need] = frozenset(),
    faults: tuple[str, ...] = (),
    has_separate_motors: bool = False,
) -> Iterator[LiveRobot]:
    """Open a robot, and close it at the end of the ``with`` block. The parameters are those of a `RunRequest`.

    In a terminal, the space bar stops every motor and ends the session, at any time.

    needs: the devices to open. It is an error if the robot lacks one of them.
    wants: the devices to open if the robot has them.

    Raises the errors of `robotcore.open`.
    """
    from robotcore.cli.estop_key import EmergencyStopKey, can_listen
    from robotcore.interactive.live_app import LiveApp
    from robotcore.interactive.opening import open_request
    from robotcore.runtime.request import RunRequest

    request = RunRequest(
        LiveApp(needs, wants),
        backend,
        robot,
        world,
        seed,
        rate_hz,
        timeout_s=1e9,
        options=options,
        faults=faults,
        has_separate_motors=has_separate_motors,
    )
    with ExitStack() as stack:
        key = EmergencyStopKey() if can_listen() else None
        if key:
            stack.enter_context(closing(key))
        live = stack.enter_context(open_request(request, [key] if key else []))
        if key and sys.stderr:
            write_line(f"{key.get_hint()} every motor", is_error=True)
        yield live
