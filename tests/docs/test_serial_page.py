from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGE = (Path(__file__).parents[2] / "docs" / "serial.md").read_text()
DRIVERS = {
    point.name: point
    for point in entry_points(group="robotcore.devices")
    if point.value.startswith(("drivers.serial.boards.", "drivers.serial.ranging."))
}


def sections() -> Iterator[Any]:
    for listing in re.findall(r"(?s)```toml\n(.*?)```", PAGE):
        yield from tomllib.loads(listing).get("serial", {}).values()


def test_the_table_has_every_driver_and_no_other() -> None:
    rows = re.findall(r"(?m)^\| (`[^|]*`) \|.*\|.*\|.*\|$", PAGE[PAGE.index("| driver | for |") :])
    answer = {name for row in rows for name in re.findall(r"`([a-z0-9-]+)`", row)}
    assert answer == set(DRIVERS)


@pytest.mark.parametrize("section", [*sections()], ids=lambda section: section["driver"])
def test_the_sections_are_valid_for_their_drivers(section: dict[str, Any]) -> None:
    driver = DRIVERS[section["driver"]].load()
    driver.model_validate({key: value for key, value in section.items() if key != "driver"})
