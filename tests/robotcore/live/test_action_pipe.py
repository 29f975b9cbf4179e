"""The pipe of the viewers' actions, while the run does not read it."""

from __future__ import annotations

import asyncio
import json
import os
import threading
from collections.abc import Callable
from typing import Any

import pytest

from robotcore.live import server
from robotcore.live.server import MAX_WAITING, ActionPipe

Act = Callable[[dict[str, Any]], None]


def read_after(write: Callable[[Act], None]) -> list[dict[str, Any]]:
    """Return the actions that reach the run after the pipe was full, without their times."""

    async def fill_and_read() -> list[dict[str, Any]]:
        source, target = os.pipe()
        loop = asyncio.get_running_loop()
        pipe = ActionPipe(target, loop)
        try:
            while True:
                os.write(target, b"#" * 4095 + b"\n")
        except BlockingIOError:
            write(pipe.write)
        lines = b""
        while b"end" not in lines:
            lines += await loop.run_in_executor(None, os.read, source, 1_000_000)
        os.close(source)
        os.close(target)
        actions = [json.loads(each) for each in lines.splitlines() if not each.startswith(b"#")]
        assert all(loop.time() - each.pop("time") < 10 for each in actions)
        return actions

    return asyncio.run(fill_and_read())


def drive(linear: float) -> dict[str, Any]:
    return {"type": "drive", "linear": linear, "angular": 0.0}


END = {"type": "end"}


@pytest.mark.posix("it fills a pipe without waiting")
def test_the_run_gets_the_newest_velocity_only() -> None:
    def write(act: Act) -> None:
        for step in range(1000):
            act(drive(step / 1000))
        act({"type": "release"})
        act(drive(0.0))
        act(END)

    assert read_after(write) == [{"type": "release"}, drive(0.0), END]


@pytest.mark.posix("it fills a pipe without waiting")
def test_the_estop_comes_before_what_waits() -> None:
    def write(act: Act) -> None:
        act(drive(1.0))
        act({"type": "pace", "speed": 1.0})
        act({"type": "pace", "is_paused": True})
        act({"type": "estop"})
        act(END)

    expected = [{"type": "estop"}, drive(1.0), {"type": "pace", "speed": 1.0}, {"type": "pace", "is_paused": True}, END]
    assert read_after(write) == expected


@pytest.mark.posix("it fills a pipe without waiting")
def test_commands_to_many_devices_do_not_fill_the_memory() -> None:
    def write(act: Act) -> None:
        for number in range(1000):
            act({"type": "actuate", "device": f"lamp{number}", "value": [1.0]})
        act(drive(0.0))
        act(END)

    actions = read_after(write)
    assert len(actions) == MAX_WAITING + 2
    assert actions[-2] == drive(0.0)


def test_without_posix_a_thread_writes_the_actions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "HAS_POSIX", False)
    source, target = os.pipe()
    loop = asyncio.new_event_loop()
    pipe = ActionPipe(target, loop)
    with os.fdopen(source, "rb") as reading:
        for action in (drive(1.0), {"type": "estop"}, END):
            pipe.write(action)
        lines = [json.loads(reading.readline()) for _ in range(3)]
    assert sorted(each["type"] for each in lines) == ["drive", "end", "estop"]
    pipe.write(END)  # the run has ended, so the thread ends
    (thread,) = (each for each in threading.enumerate() if each.name == "actions")
    thread.join(5)
    loop.close()
    os.close(target)
