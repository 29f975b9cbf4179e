from __future__ import annotations

import io
import json
import re
from pathlib import Path

import pytest

from robotcore import Robot, Role
from robotcore.autonomy.vision import Blob
from robotcore.cli.main import execute
from robotcore.hal.drive import DifferentialDrive
from robotcore.hal.truth import Truth
from robotcore.kinds.camera import Camera, Frame
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.optics import Intrinsics
from robotcore.testing.mock.robot import MockRobot
from tests.docs.listings import (
    find_code,
    list_commands,
    list_listings,
    list_missing_attributes,
    read_rows,
)

PAGE = (Path(__file__).parents[2] / "docs" / "apps.md").read_text()
LISTINGS = list_listings(PAGE)
FILES = [each for each in LISTINGS if each.language == "python"]
CONSOLE_COMMANDS = list_commands(PAGE)
PARTS = [code for row in read_rows(PAGE, "What a robot has") for code in find_code(row[0])]
MISTAKES = read_rows(PAGE, "What an app must not do")
ENDLESS = "`while True: pass`"

ODD = """
import time
from robotcore import Behaviour, Role, Status

class Odd(Behaviour):
    needs = frozenset({{Role.DRIVE, Role.CAMERA}})

    def step(self, robot):
        {code}
        return Status.RUNNING
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make an empty folder the current folder, and close the standard input."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    return tmp_path


def write_odd_app(folder: Path, code: str) -> str:
    """Write an app whose step runs the code of a table's cell, and return its file."""
    file = folder / "odd.py"
    file.write_text(ODD.format(code=find_code(code)[0]))
    return str(file)


def test_every_listing_is_a_file_or_a_console() -> None:
    assert {listing.language for listing in LISTINGS} == {"python", "console"}
    assert all(file.file.endswith(".py") for file in FILES)
    assert len(CONSOLE_COMMANDS) > len(FILES) > 3


def test_each_listed_part_of_a_robot_exists() -> None:
    robot = MockRobot(range=1.0).layered
    blob = Blob((160.0, 120.0), (150, 110, 20, 20), 400, 0.0, is_clipped=False)
    parts = {"robot": robot, "frame": robot.camera.read(), "blob": blob, "Role": Role, "Camera": Camera}
    for code in PARTS:
        exec(compile(code, f"the page's code {code}", "exec"), dict(parts))  # noqa: S102  the page's own words


@pytest.mark.parametrize("row", read_rows(PAGE, "At a prompt and in a notebook"), ids=lambda row: row[0])
def test_value_shows_itself_as_the_page_says(row: list[str]) -> None:
    mock = MockRobot(range=1.24)
    mock.advance(63)
    mock.layered.range.read()
    shown = repr(eval(find_code(row[0])[0], {"robot": mock.layered}))  # noqa: S307  the page's own code
    without_numbers = [re.sub(r"-?\d+(\.\d+)?", "0", text) for text in (shown, find_code(row[1])[0])]
    assert without_numbers[0] == without_numbers[1]


FOR_DRIVERS = {
    "close",
    "kind",
    "is_compensated",
    "is_monitored",
    "find_problem",
    "format_sample",
    "format_state",
    "limit_sample",
    "change_distances",
    "has_rays",
    "list_rays",
    "measure_ahead",
}


@pytest.mark.parametrize(
    "kind, not_for_apps",
    [
        (Robot, {"close", "stop", "truth"}),
        (DifferentialDrive, {"track", "latest_pose"}),
        (RangeSensor, FOR_DRIVERS),
        (Camera, FOR_DRIVERS),
        (Range, {"point"}),
        (Frame, set()),
        (Intrinsics, set()),
        (Blob, set()),
        (Truth, {"update"}),
    ],
)
def test_page_names_every_attribute(kind: type, not_for_apps: set[str]) -> None:
    assert list_missing_attributes(PAGE, kind) - not_for_apps == set()


@pytest.mark.parametrize("row", [row for row in MISTAKES if row[2] and row[0] != ENDLESS], ids=lambda row: row[0])
def test_mistake_ends_as_the_page_shows(row: list[str], folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    code, message, status = row
    assert execute(["run", write_odd_app(folder, code), "--world", "open"]) == int(status)
    assert find_code(message)[0] in capfd.readouterr().err


@pytest.mark.slow
def test_sleep_does_not_advance_the_simulated_time(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (code,) = (row[0] for row in MISTAKES if row[0].startswith("`time.sleep"))
    assert execute(["run", write_odd_app(folder, code), "--world", "open", "--timeout", "0.2", "--json"]) == 1
    result = json.loads(capfd.readouterr().out)
    assert (result["outcome"], result["ticks"]) == ("timeout", 5)


@pytest.mark.slow
def test_endless_loop_ends_as_the_page_shows(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    message, status = next(row[1:] for row in MISTAKES if row[0] == ENDLESS)
    after_the_first_step = f"`exec({find_code(ENDLESS)[0]!r}) if robot.clock.now() else None`"
    assert execute(["run", write_odd_app(folder, after_the_first_step), "--world", "open"]) == int(status)
    assert find_code(message)[0] in capfd.readouterr().err
