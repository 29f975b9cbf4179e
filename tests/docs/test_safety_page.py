from __future__ import annotations

import os
import pty
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from robotcore.description import load_robot
from robotcore.errors import EmergencyStopError
from robotcore.hal.cutoff import Cutoff
from robotcore.runtime.result import Outcome
from robotcore.runtime.trace import TickRecord
from tests.docs.listings import list_listings

PAGE = (Path(__file__).parents[2] / "docs" / "safety.md").read_text()


def test_the_cutoff_on_the_page_writes_its_stop_frame_to_the_port() -> None:
    (listing,) = [each.text for each in list_listings(PAGE) if "class StopFrame" in each.text]
    found: dict[str, Any] = {}
    exec(listing, found)  # noqa: S102
    board, port = pty.openpty()
    parameters = {**found["stop"].parameters, "port": os.ttyname(port)}
    cutoff: Cutoff = found["StopFrame"](**parameters)
    cutoff.open()
    cutoff.stop()
    assert os.read(board, 100).endswith(b"m 0 0\r")
    cutoff.close()
    os.close(port)
    os.close(board)


def test_the_button_on_the_page_stops_the_run() -> None:
    (listing,) = [each.text for each in list_listings(PAGE) if "class BenchButton" in each.text]
    found: dict[str, Any] = {}
    exec(listing, found)  # noqa: S102
    button = SimpleNamespace(when_pressed=None)

    def press(_: object, record: TickRecord) -> None:
        if record.tick == 3:
            button.when_pressed()

    found["BenchButton"].tick = press
    result = found["watched"](button)
    assert isinstance(result.error, EmergencyStopError)
    assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)
    assert result.reason == "e-stop: the button on the bench was pressed"
    assert button.when_pressed is None


def test_the_defaults_on_the_page_are_those_of_a_robot() -> None:
    safety = load_robot("rover").safety
    for key in ("stop_distance_m", "deceleration_m_s2", "lease_ticks", "watchdog_s", "answer_s", "follow_s", "stuck_m"):
        default = getattr(safety, key)
        assert f"`{key}` {default:g}" in PAGE or f"`{key}` {default:.2f}" in PAGE or f"`{key}` {default:.1f}" in PAGE, (
            key
        )
