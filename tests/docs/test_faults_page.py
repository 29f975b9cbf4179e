from __future__ import annotations

import runpy
import shlex
import sys
from importlib.metadata import EntryPoint
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotcore import Outcome
from robotcore import plugins as registry
from robotcore.cli.main import execute
from robotcore.description import load_robot
from robotcore.errors import DeviceLostError
from robotcore.hal.device import Actuator, Sensor
from robotcore.plugins import fault_names
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.faults.planning import load_fault
from robotcore.runtime.faults.sensor_fields import FieldFault
from robotcore.runtime.faults.spec import forms_of, read_specs
from robotcore.runtime.faults.targets import name_target
from tests.docs.listings import ConsoleCommand, find_code, list_commands, list_listings, read_rows
from tests.robotcore.fakes import picture
from tests.robotcore.runtime.faults.rigs import build_rig
from tests.robotcore.runtime.test_device_loss import Board, lose_motors

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGE = (Path(__file__).parents[2] / "docs" / "faults.md").read_text()
LISTINGS = list_listings(PAGE)
SOURCES = {each.file: each.text for each in LISTINGS if each.language == "python"}
CONSOLE_COMMANDS = list_commands(PAGE)
FILES = [each.text for each in LISTINGS if each.language == "toml"]
ROVER = load_robot("rover")
BASES: dict[type, str] = {Sensor: "every sensor", Actuator: "every actuator"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write the files of the page into a folder, and make it the current folder."""
    for name, text in SOURCES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", CONSOLE_COMMANDS, ids=lambda each: each.command)
def test_command_output_equals_the_page(
    command: ConsoleCommand, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    execute(shlex.split(command.command)[1:])
    out, err = capfd.readouterr()
    assert command.matches(f"{err}\n{out}"), err + out


def test_fault_file_equals_its_faults_on_the_page(tmp_path: Path) -> None:
    file = tmp_path / "faults.toml"
    file.write_text(FILES[0])
    assert read_specs([str(file)]) == ("camera drop=0.2 after=5", "left_motor weak=0.6")


def test_faults_of_the_first_commands_are_valid() -> None:
    shell = next(each.text for each in LISTINGS if each.language == "sh")
    words = [shlex.split(line) for line in shell.splitlines()]
    specs = [after for line in words for word, after in pairwise(line) if word == "--fault"]
    assert len(plan_faults(specs, ROVER, [device.name for device in ROVER.devices])) == 3


def test_table_has_every_effect_with_its_unit_and_its_targets() -> None:
    answer = {(find_code(row[0])[0], row[1]) for row in read_rows(PAGE, "Effects")}
    assert answer == {_build_row(name) for name in fault_names()}


def test_test_of_an_app_passes(folder: Path) -> None:
    found = runpy.run_path(str(folder / "test_patient.py"))
    found["test_stands_while_the_connection_is_lost_and_drives_on"]()


def test_app_of_the_page_survives_a_lost_connection_if_the_robot_waits_for_it(folder: Path) -> None:
    patient = runpy.run_path(str(folder / "patient.py"))["Patient"]
    waiting, impatient = Board(), Board(outage=0.0)
    for board in (waiting, impatient):
        lose_motors(board.rig, board.rig.left, board.rig.right)
    assert waiting.run(patient().step) is Outcome.TIMEOUT
    with pytest.raises(DeviceLostError):
        impatient.run(patient().step)


def test_the_new_fault_of_the_page_works(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    known, added = registry._points, _list_entry_points(FILES[-1])
    monkeypatch.setattr(
        registry, "_points", lambda group: {**known(group), **(added if group == registry.FAULTS else {})}
    )
    rig = build_rig("camera fog=0.5 after=0.05")
    rig.eye.image = picture((20, 180, 220))
    shown = []
    for _ in range(2):
        shown.append(np.unique(rig.robot.camera.read().image).tolist())
        rig.sleep(0.05)
    assert shown == [[20, 180, 220], [100, 180, 200]]


def _list_entry_points(pyproject: str) -> dict[str, EntryPoint]:
    """Return the faults of the package on the page."""
    project = tomllib.loads(pyproject)["project"]
    assert {"name", "version"} <= project.keys(), "else it cannot be installed"
    faults = project["entry-points"][registry.FAULTS]
    return {name: EntryPoint(name, value, registry.FAULTS) for name, value in faults.items()}


def _build_row(name: str) -> tuple[str, str]:
    effect, fault = name.partition(".")[0], load_fault(name)
    if issubclass(fault, FieldFault):
        words = "every other sensor with a number" + (" or a contact" if bool in fault.types else "")
    else:
        classes: tuple[Any, ...] = fault.target_classes
        words = ", ".join(BASES.get(each) or f"`{name_target(each.kind)}`" for each in classes)
    return forms_of(effect, fault)[0], words
