"""The package on the page about kinds works in processes that find it, without a changed line of robotcore."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from robotcore import kinds
from robotcore.cli.scaffold import KIND, make
from robotcore.description import load_robot
from robotcore.hal.backend import load_backend
from robotcore.plugins import kind_names
from tests.docs.listings import Listing, find_code, list_listings, read_rows
from tests.robotcore.description.files import ROVER

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGE = (Path(__file__).parents[2] / "docs" / "kinds.md").read_text()
SCANNER, ROAM, TURN, TELEOP, SCRIPT, REAL, SENSOR, GRIPPER, *LISTINGS = list_listings(PAGE)
"""The lidar and its app, an app with an IMU, and the app, the script and the driver for a gamepad; then the package.

The second listing of the package is another kind, a gripper.
"""
LISTINGS.insert(0, SENSOR)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Create the package of the page, and register its kind as an installed package does."""
    folder = tmp_path / "speed-sensor"
    make(KIND, folder)
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    package = folder / "speed_sensor-0.1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 0.1\n")
    lines = [f"{name} = {value}" for name, value in project["entry-points"]["robotcore.kinds"].items()]
    (package / "entry_points.txt").write_text("\n".join(["[robotcore.kinds]", *lines]))
    return folder


@pytest.mark.parametrize("listing", LISTINGS, ids=lambda each: each.file)
def test_listing_is_a_part_of_the_new_package(folder: Path, listing: Listing) -> None:
    assert listing.text.partition("\n")[2] in (folder / listing.file).read_text()


def test_gripper_limits_commands_by_the_key_of_its_description() -> None:
    names: dict[str, Any] = {"__name__": "gripper"}
    exec(compile(GRIPPER.text, "gripper.py", "exec", dont_inherit=True), names)  # noqa: S102  of the page
    kind = names["KIND"]
    gripper = type("Hand", (kind.device,), {"_apply": lambda _self, _command: None})
    hand = gripper("hand", **kind.description(kind="gripper", name="hand", max_opening_m=0.05).arguments())
    assert hand.send(0.2) == 0.05


def type_command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, "-m", *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def run_app(folder: Path, *words: str) -> Any:
    options = ("--robot", "robot.toml", "--world", "open", "--json")
    answer = type_command(folder, "robotcore", "run", "cautious.py", *options, *words)
    return json.loads(answer.stdout)


def test_every_kind_is_in_the_table() -> None:
    rows = {find_code(kind)[0]: find_code(name)[0] for kind, name, _ in read_rows(PAGE, "Kinds of devices")}
    assert sorted(rows) == kind_names()
    assert {name: getattr(kinds, each).kind for name, each in rows.items()} == {name: name for name in rows}


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
def test_app_uses_the_kind_in_a_simulator(folder: Path, backend: str) -> None:
    answer = run_app(folder, "--backend", backend)
    assert answer["outcome"] == "success"
    assert float(answer["reason"].removesuffix(" m/s")) >= 0.19


@pytest.mark.slow
def test_run_with_the_kind_is_recorded_and_replayed(folder: Path) -> None:
    run_app(folder, "--record", "run.mcap", "--fault", "flow bias=0.05")
    assert type_command(folder, "robotcore", "info", "run.mcap", "--csv", "run.csv").returncode == 0
    assert "flow_m_s" in (folder / "run.csv").read_text().splitlines()[0]
    assert type_command(folder, "robotcore", "replay", "run.mcap").returncode == 0


@pytest.mark.slow
def test_fault_of_the_kind_changes_its_value(folder: Path) -> None:
    answer = run_app(folder, "--fault", "flow bias=-0.05", "--timeout", "3")
    assert answer["outcome"] == "timeout"


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet"])
def test_app_roams_by_the_lidar_without_contact(tmp_path: Path, backend: str) -> None:
    (tmp_path / ROAM.file).write_text(ROAM.text)
    (tmp_path / SCANNER.file).write_text(f"{ROVER}\n{SCANNER.text}")
    words = (ROAM.file, "--robot", SCANNER.file, "--world", "arena", "--seed", "2", "--timeout", "70", "--json")
    answer = json.loads(type_command(tmp_path, "robotcore", "run", *words, "--backend", backend).stdout)
    assert (answer["outcome"], answer["contacts"]) == ("success", 0)


@pytest.mark.slow
def test_app_turns_by_the_imu_with_wheels_that_slip(tmp_path: Path) -> None:
    (tmp_path / TURN.file).write_text(TURN.text)
    imu = '\n[[devices]]\nkind = "imu"\nname = "imu"\nyaw_rate_bias_rad_s = 0.01\n'
    (tmp_path / "turning.toml").write_text(ROVER + imu)
    words = (TURN.file, "--robot", "turning.toml", "--world", "open", "--fault", "encoders slip=0.2", "--json")
    answer = json.loads(type_command(tmp_path, "robotcore", "run", *words).stdout)
    assert answer["outcome"] == "success"
    assert float(answer["reason"].removesuffix(" rad by the encoders")) == pytest.approx(0.8 * math.pi / 2, abs=0.03)


@pytest.mark.slow
def test_gamepad_script_drives_the_robot(tmp_path: Path) -> None:
    (tmp_path / TELEOP.file).write_text(TELEOP.text)
    (tmp_path / SCRIPT.file).write_text(f"{ROVER}\n{SCRIPT.text}")
    words = (TELEOP.file, "--robot", SCRIPT.file, "--world", "open", "--json")
    answer = json.loads(type_command(tmp_path, "robotcore", "run", *words).stdout)
    assert (answer["outcome"], answer["sim_time_s"]) == ("success", 4.0)
    (tmp_path / REAL.file).write_text(f"{ROVER}\n{SCRIPT.text}\n{REAL.text}")
    assert load_backend("mujoco").check(load_robot(str(tmp_path / REAL.file))) == "1 real device"


@pytest.mark.slow
def test_sweep_and_test_of_the_page_pass(folder: Path) -> None:
    words = ("sweep", "cautious.py", "--robot", "robot.toml", "--world", "open", "--seeds", "1-4", "--json")
    assert json.loads(type_command(folder, "robotcore", *words).stdout)["exit_status"] == 0
    passed = type_command(folder, "pytest", "-q", "-p", "no:cacheprovider", "test_cautious.py")
    assert passed.returncode == 0, passed.stdout
