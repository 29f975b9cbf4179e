"""The hub: which actions of viewers reach the run."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from robotcore.live.hub import Hub
from robotcore.live.viewer import Viewer


def act(*messages: dict[str, Any], leaves: bool = False) -> list[dict[str, Any]]:
    """Return the actions that reach the run after messages of one viewer, without the numbers of viewers."""

    async def send() -> list[dict[str, Any]]:
        actions: list[dict[str, Any]] = []
        hub = Hub(actions.append)
        socket: Any = None
        viewer = Viewer(socket, hub)
        hub.enter(viewer)
        for each in messages:
            hub.handle(viewer, json.dumps(each))
        if leaves:
            hub.leave(viewer)
        return [each for each in actions if each["type"] != "viewers"]

    return asyncio.run(send())


TAKE = {"type": "take"}
DRIVE = {"type": "drive", "linear": 1.0, "angular": 0.0}
STAND = {"type": "drive", "linear": 0.0, "angular": 0.0}


def test_a_velocity_of_the_viewer_who_drives_reaches_the_run_without_the_viewers_time() -> None:
    assert act(TAKE, {**DRIVE, "sent": 1.0}) == [DRIVE]
    assert act({**DRIVE, "sent": 1.0}) == []


def test_the_robot_stands_at_once_when_the_viewer_who_drives_leaves() -> None:
    assert act(TAKE, {**DRIVE, "sent": 1.0}, leaves=True) == [DRIVE, STAND]
    assert act(leaves=True) == []


def test_a_late_command_does_not_reach_the_run() -> None:
    late = {"type": "actuate", "device": "pan", "value": [0.5], "sent": 700.0}
    assert act(TAKE, {**DRIVE, "sent": 1000.0}, {**DRIVE, "sent": 700.0}, late) == [DRIVE]
    assert act(TAKE, {**DRIVE, "sent": 1000.0}, {**DRIVE, "sent": 900.0}) == [DRIVE, DRIVE]
