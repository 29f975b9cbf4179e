from __future__ import annotations

import os
import pty
from pathlib import Path
from typing import Any

from robotcore.hal.cutoff import Cutoff
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
