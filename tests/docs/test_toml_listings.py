"""The TOML listings of each page are valid parts of the file of a robot, a world, a project or faults."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tomlkit

from robotcore import plugins
from robotcore.cli.main import execute
from robotcore.deploy.project import read_tables
from robotcore.description import WorldDescription
from robotcore.plugins import backend_names
from robotcore.runtime.faults.spec import read_specs
from tests.docs.listings import list_listings, read_pages
from tests.robotcore.description.files import ARENA, SHIPPED

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Table = dict[str, Any]

LISTINGS: dict[str, Table] = {
    f"{page}-{number}": tomllib.loads(listing.text)
    for page, text in read_pages().items()
    for number, listing in enumerate(each for each in list_listings(text) if each.language == "toml")
}

BASES = {"skid": "freenove-4wd", "ackermann": "picar"}
"""The shipped robot that has a drive of a kind, which a listing changes. Other listings change the rover."""

MOTORS = {"left": "motor", "right": "motor", "motor": "motor", "encoder": "encoder"}
"""The keys of a drive that name devices, and the kinds of the devices."""

SIMILAR = {"coppeliasim": "vrep"}
"""The backend whose section a shipped robot has in place of that of another one, with the same keys."""

GROUPS = {plugins.BACKENDS, plugins.APPS, plugins.FAULTS, plugins.DEVICES, plugins.KINDS}
OWN_KINDS = {"speed_sensor"}
"""The kinds of the reader's own packages, whose tests are those of their pages."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make an empty folder the current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def find_mistake(table: Table, folder: Path) -> str:
    """Return the output about the mistakes of a listing; ``""`` if it is valid in a file of its kind."""
    if table.keys() <= {"project", "tool"}:
        return _find_mistake_of_project(table, folder)
    if "fault" in table:
        file = folder / "faults.toml"
        file.write_text(tomlkit.dumps(table), encoding="utf-8")
        return "" if read_specs([str(file)]) else "no faults"
    is_world = table.keys() <= WorldDescription.model_fields.keys()
    changed = build_world(table, folder) if is_world else build_robot(table)
    file = folder / ("my_world.toml" if is_world else "my_robot.toml")
    file.write_text(tomlkit.dumps(changed), encoding="utf-8")
    return "" if execute(["check", file.name]) == 0 else "robotcore check has found a mistake"


def build_world(table: Table, folder: Path) -> Table:
    """Return the tables of the shipped world with those of a listing, and write the picture that it names."""
    if image := table.get("floor", {}).get("image"):
        cv2.imwrite(str(folder / image["file"]), np.full((20, 28, 3), 255, np.uint8))
    return {"name": "room", **table} if "floor" in table else {**tomllib.loads(ARENA), **table}


def build_robot(table: Table) -> Table:
    """Return the tables of a shipped robot with those of a listing, and with the devices that the listing names."""
    drive = table.get("drive", {})
    base = BASES.get(drive.get("kind"), "rover")
    robot = tomllib.loads(SHIPPED.joinpath("robots", f"{base}.toml").read_text(encoding="utf-8"))
    devices = {each["name"]: each for each in (*_list_devices(), *robot["devices"], *table.get("devices", ()))}
    named = {each["name"] for each in (*robot["devices"], *table.get("devices", ()))}
    if "kind" in drive:
        robot["drive"] = drive
        for name, kind in _list_motors(drive):
            devices.setdefault(name, {**next(each for each in devices.values() if each["kind"] == kind), "name": name})
            named.add(name)
    else:
        robot["drive"] |= drive
    shipped = {name: robot.pop(name) for name in backend_names() if name in robot}
    for section in backend_names():
        if section in table:
            robot[section] = {**shipped.get(SIMILAR.get(section, section), {}), **table[section]}
            named |= table[section].keys()
    robot["devices"] = [device for name, device in devices.items() if name in named]
    return robot


def _list_devices() -> Iterator[Table]:
    """Yield the tables of the devices in all listings. A section for a backend may name a device of another listing."""
    for table in LISTINGS.values():
        yield from table.get("devices", ())


def _list_motors(drive: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, kind in MOTORS.items():
        given = drive.get(key, [])
        yield from ((name, kind) for name in ([given] if isinstance(given, str) else given))


def _find_mistake_of_project(table: Table, folder: Path) -> str:
    for group, points in table.get("project", {}).get("entry-points", {}).items():
        if group not in GROUPS or not all(value.count(":") == 1 for value in points.values()):
            return f"the entry points {group} are not valid"
    if "tool" in table:
        (folder / "pyproject.toml").write_text(tomlkit.dumps(table), encoding="utf-8")
        return "" if read_tables(folder).robotcore else "no table tool.robotcore"
    return ""


@pytest.mark.parametrize("name", LISTINGS)
def test_listing_is_valid(name: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    table = LISTINGS[name]
    if any(each["kind"] in OWN_KINDS for each in table.get("devices", ())):
        pytest.skip("the kind is of the reader's package")
    assert find_mistake(table, folder) == "", capfd.readouterr()


@pytest.mark.parametrize(
    "text",
    [
        '[[devices]]\nkind = "imu"\nname = "imu"\n[raspberrypi.imu]\ndriver = "mpu6051"',
        '[raspberrypi.left_motor]\ndriver = "h-bridge"\nforward = 17\nbackward = 17',
        "[drive]\nwheel_radius_mm = 40",
        "[conditions]\ncamera_nois = 4.0",
        '[coppeliasim.left_motor]\npth = "/rover/left"',
    ],
)
def test_wrong_listing_is_found(text: str, folder: Path) -> None:
    assert find_mistake(tomllib.loads(text), folder)


def test_wrong_entry_point_is_found(folder: Path) -> None:
    assert find_mistake(tomllib.loads('[project.entry-points."robotcore.app"]\nreflex = "a:B"'), folder)
