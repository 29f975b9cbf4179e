from __future__ import annotations

import re
from importlib.metadata import entry_points
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "serial.md").read_text()
DRIVERS = {
    point.name: point
    for point in entry_points(group="robotcore.devices")
    if point.value.startswith(("drivers.serial.boards.", "drivers.serial.ranging."))
}


def test_the_table_has_every_driver_and_no_other() -> None:
    rows = re.findall(r"(?m)^\| (`[^|]*`) \|.*\|.*\|.*\|$", PAGE[PAGE.index("| driver | for |") :])
    answer = {name for row in rows for name in re.findall(r"`([a-z0-9-]+)`", row)}
    assert answer == set(DRIVERS)
