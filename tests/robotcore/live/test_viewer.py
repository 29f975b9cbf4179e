"""A viewer that reads slowly, and the delays of its commands."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from robotcore.live.viewer import LATE_S, MAX_LATE_S, MAX_MESSAGES, Delays, Viewer
from robotcore.runtime.operator_input import LEASE_S


class SlowSocket:
    """A WebSocket whose client reads a message in each turn of the event loop."""

    def __init__(self) -> None:
        self.sent = 0

    async def send_text(self, _text: str) -> None:
        self.sent += 1
        await asyncio.sleep(0)


class Nothing:
    tick = b""
    pictures: dict[str, bytes] = {}  # noqa: RUF012


def test_a_viewer_that_reads_too_slowly_is_dropped_and_its_messages_are_bounded() -> None:
    async def send() -> tuple[Viewer, int]:
        socket: Any = SlowSocket()
        viewer = Viewer(socket, Nothing())
        sending = asyncio.create_task(viewer.send_all())
        for _ in range(200):
            for _ in range(10):
                viewer.add_message(b"{}")
            await asyncio.sleep(0)
        await asyncio.wait_for(sending, 1.0)
        return viewer, socket.sent

    viewer, sent = asyncio.run(send())
    assert viewer.is_dropped
    assert len(viewer._messages) <= MAX_MESSAGES
    assert sent < 200


def test_a_viewer_with_as_many_messages_as_allowed_is_not_dropped() -> None:
    socket: Any = SlowSocket()
    viewer = Viewer(socket, Nothing())
    for _ in range(MAX_MESSAGES):
        viewer.add_message(b"{}")
    assert not viewer.is_dropped
    viewer.add_message(b"{}")
    assert viewer.is_dropped


def test_a_command_is_late_if_it_needed_longer_than_the_lease_beyond_the_fastest_one() -> None:
    assert LATE_S == LEASE_S
    delays = Delays()
    assert not delays.is_late(sent=1000.0, now=5.0)
    assert not delays.is_late(sent=1000.5, now=5.4)  # faster
    assert not delays.is_late(sent=1001.0, now=5.9 + 0.9 * LATE_S)
    assert delays.is_late(sent=1002.0, now=6.9 + 1.1 * LATE_S)
    assert not delays.is_late(sent=1003.0, now=8.0)


def test_clocks_with_different_rates_make_no_command_late() -> None:
    delays = Delays()
    assert not any(delays.is_late(sent=second * (1 - 5e-4), now=float(second)) for second in range(10_000))


def test_only_late_commands_for_a_while_are_an_error() -> None:
    delays = Delays()
    delays.is_late(sent=100.0, now=0.0)
    assert all(delays.is_late(sent=0.0, now=tenth / 10) for tenth in range(1, int(10 * MAX_LATE_S)))
    with pytest.raises(ValueError, match="late"):
        delays.is_late(sent=0.0, now=MAX_LATE_S + 0.2)
