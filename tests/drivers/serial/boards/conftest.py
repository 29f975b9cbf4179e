from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TypeAlias

import pytest

from robotcore.errors import DeviceError
from tests.doubles.serial.bench import Devices, Rig
from tests.doubles.serial.board import BoardDouble

OpenRig: TypeAlias = Callable[[BoardDouble, Devices], Rig]


@pytest.fixture
def open_rig(tmp_path: Path) -> Iterator[OpenRig]:
    """Return a rover on a board. It is closed after the test."""
    with ExitStack() as opened:

        def make(board: BoardDouble, devices: Devices) -> Rig:
            rig = Rig(tmp_path, board, devices)
            opened.enter_context(suppress(DeviceError))  # the test may have unplugged the board
            opened.callback(rig.close)
            return rig

        yield make
