"""Each Python listing of a page is run, by the test of its page or here."""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import create_autospec

import numpy as np
import pytest

from docs.generator.public_names import MODULES, list_public_names
from robotcore import Outcome, RunRequest, run
from robotcore.cli.main import execute
from robotcore.cli.scaffold import DRIVER, make
from robotcore.hal.device_test import REVERSED, DeviceTest
from robotcore.optics import Image
from robotcore.sweep import Sweep
from robotcore.sweep.single_run import RunOutput, perform
from robotcore.testing import ConformanceSuite, MockRobot, TestSupport
from tests.docs.listings import ROOT, list_commands, list_listings, read_pages
from tests.docs.reader_files import is_python_file

PAGES = read_pages()
TEMPLATES = ROOT / "robotcore" / "cli" / "scaffold" / "templates"
LISTINGS = [
    (page, listing) for page, text in PAGES.items() for listing in list_listings(text) if listing.language == "python"
]

RUN_BY = {
    "README.md": "test_readme",
    "docs/apps.md": "test_console_listings",
    "docs/calibration.md": "test_calibration_page",
    "docs/deploy.md": "test_deploy_page",
    "docs/faults.md": "test_faults_page",
    "docs/fidelity.md": "test_fidelity_page",
    "docs/interactive.md": "test_console_listings",
    "docs/kinds.md": "test_kinds_page",
    "docs/manoeuvres.md": "test_console_listings",
    "docs/navigation.md": "test_console_listings",
    "docs/recording.md": "test_recording_page",
    "docs/run-from-python.md": "test_console_listings",
    "docs/safety.md": "test_safety_page",
    "docs/teleop.md": "test_teleop_page",
    "docs/tutorials/bubblerob.md": "test_tutorials",
    "docs/tutorials/green-relay.md": "test_tutorials",
}
"""The pages whose Python listings a test of their own runs, and its module."""

PARTS = {
    ("CONTRIBUTING.md", "# bumper.py"): "test_contributing_page",
    ("CONTRIBUTING.md", "# test_bumper.py"): "test_contributing_page",
    ("CONTRIBUTING.md", "class Reflex"): "test_python_listings",
    ("CONTRIBUTING.md", "class TestMyBoard"): "test_python_listings",
    ("docs/coppeliasim.md", "simx"): "test_python_listings",
    ("docs/descriptions.md", "arena.xml"): "test_python_listings",
    ("docs/devices.md", "def test_winches"): "test_python_listings",
    ("docs/sweeps.md", "sys.argv"): "test_python_listings",
    ("docs/sweeps.md", "class Strict"): "test_python_listings",
    ("docs/sweeps.md", "LocalEngine"): "test_python_listings",
    ("docs/vision.md", "ColourDetector"): "test_python_listings",
}
"""The listings of other pages by a part of their text, and the module of the test that runs each."""


def run_listing(page: str, part: str, **names: Any) -> dict[str, Any]:
    """Run the listing of a page with a text, in which these names are known. Return all its names."""
    (text,) = (listing.text for name, listing in LISTINGS if name == page and part in listing.text)
    names.setdefault("__name__", "listing")
    exec(compile(text, "listing.py", "exec", dont_inherit=True), names)  # noqa: S102  of the page
    return names


@pytest.mark.parametrize("page", dict(LISTINGS))
def test_a_test_runs_each_listing_of_a_page(page: str) -> None:
    own = [listing for name, listing in LISTINGS if name == page]
    if page in RUN_BY:
        modules = {RUN_BY[page]}
    else:
        tests = [[PARTS[name, part] for name, part in PARTS if name == page and part in each.text] for each in own]
        assert [len(each) for each in tests] == [1] * len(own), "add the listing to PARTS, and a test that runs it"
        modules = {module for (module,) in tests}
    for module in modules:
        source = (Path(__file__).parent / f"{module}.py").read_text(encoding="utf-8")
        assert f'"{Path(page).stem}' in source or f'"{Path(page).name}"' in source or f'"{page}"' in source


@pytest.mark.parametrize("page", [page for page, module in RUN_BY.items() if module == "test_console_listings"])
def test_a_console_command_names_each_file_of_its_page(page: str) -> None:
    files = {listing.file for name, listing in LISTINGS if name == page and is_python_file(listing)}
    assert len(files) == len([listing for name, listing in LISTINGS if name == page])
    words = {word for command in list_commands(PAGES[page]) for word in command.command.split()}
    assert files - words == set()


def test_the_tables_have_no_stale_entry() -> None:
    assert RUN_BY.keys() | {page for page, _ in PARTS} == set(dict(LISTINGS))
    assert RUN_BY.keys().isdisjoint(page for page, _ in PARTS)
    assert [key for key in PARTS if not any(page == key[0] and key[1] in each.text for page, each in LISTINGS)] == []


def test_listings_and_templates_import_public_names_only() -> None:
    public = [getattr(import_module(module), name) for module in MODULES for name in list_public_names(module)]
    known = {id(each) for each in public} | {id(import_module(each)) for each in MODULES}
    sources = {f"{page}, {listing.file}": listing.text for page, listing in LISTINGS}
    sources |= {str(file): file.read_text(encoding="utf-8") for file in TEMPLATES.rglob("*.py")}
    found = {
        f"{node.module}.{each.name} in {place}": getattr(import_module(node.module), each.name)
        for place, text in sources.items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom) and node.module and node.module.partition(".")[0] == "robotcore"
        for each in node.names
    }
    assert len(found) > 50
    assert [name for name, value in found.items() if id(value) not in known] == []


def test_the_app_in_contributing_drives() -> None:
    app = run_listing("CONTRIBUTING.md", "class Reflex")["Reflex"]
    result = run(RunRequest(app, world="arena", timeout_s=2.0))
    assert (result.outcome, result.contacts, result.error) == (Outcome.TIMEOUT, 0, None)


def test_the_suite_in_contributing_tests_the_backend_of_a_new_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make(DRIVER, tmp_path / "my-board")
    monkeypatch.syspath_prepend(tmp_path / "my-board")
    suite = run_listing("CONTRIBUTING.md", "class TestMyBoard")["TestMyBoard"]
    assert issubclass(suite, ConformanceSuite)
    assert suite.backend().name == "my-board"
    assert (tmp_path / "my-board" / suite.robot).is_file()
    assert suite.lacks.keys() == {TestSupport.WORLD}
    for module in [name for name in sys.modules if name.partition(".")[0] == "my_board"]:
        monkeypatch.delitem(sys.modules, module)


def test_both_names_of_the_old_remote_api_are_its_functions() -> None:
    names = run_listing("docs/coppeliasim.md", "simx")
    assert names["vrep"] is names["sim"]
    assert callable(names["vrep"].simxStart)


@pytest.mark.slow
def test_the_exported_model_drives_in_mujoco(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (command,) = (line for line in PAGES["docs/descriptions.md"].splitlines() if line.endswith("--output arena.xml"))
    assert execute(command.split()[1:]) == 0
    capsys.readouterr()
    names = run_listing("docs/descriptions.md", "arena.xml")
    assert capsys.readouterr().out.startswith("[")
    mujoco, driven = names["mujoco"], names["data"]
    begun = mujoco.MjData(names["model"])
    mujoco.mj_forward(names["model"], begun)
    x, y, z = driven.body("base_link").xpos - begun.body("base_link").xpos
    assert np.hypot(x, y) > 0.3
    assert abs(z) < 0.01


@pytest.mark.parametrize("answer, method", [("y", "confirm"), ("n", "correct"), (None, "skip")])
def test_the_test_of_a_winch_reports_the_answer(answer: str | None, method: str) -> None:
    device, test = SimpleNamespace(send=[].append, stop=lambda: None), create_autospec(DeviceTest, instance=True)
    test.robot, test.ask.return_value = {"winch": device}, answer
    run_listing("docs/devices.md", "def test_winches")["test_winches"](test, [SimpleNamespace(name="winch")])
    (call,) = (each for each in test.method_calls if each[0] in {"confirm", "correct", "skip"})
    assert (call[0], call.args[0]) == (method, "winch")
    assert method != "correct" or REVERSED in call.args


def test_the_table_of_marks_is_that_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (table,) = (each.text for each in list_listings(PAGES["docs/sweeps.md"]) if each.text.startswith("ann"))
    error = table.splitlines()[1].split("\t")[2]
    answers = {
        "ann": {"done": 2, "runs": 2, "groups": [{"verified_share": 1.0}, {"verified_share": 1.0}]},
        "cyd": {"error": error},
        "eve": {"done": 2, "runs": 2, "groups": [{"verified_share": 0.0}, {"verified_share": None}]},
    }
    files = [tmp_path / f"{name}.json" for name in answers]
    for file, answer in zip(files, answers.values(), strict=True):
        file.write_text(json.dumps(answer))
    monkeypatch.setattr(sys, "argv", ["marks.py", *map(str, files)])
    run_listing("docs/sweeps.md", "sys.argv")
    assert [line.rstrip() for line in capsys.readouterr().out.splitlines()] == table.splitlines()


def test_the_strict_judge_refuses_a_run_with_a_contact() -> None:
    judge = run_listing("docs/sweeps.md", "class Strict")["Strict"]()
    seen = SimpleNamespace(is_at_rest=True, sees_target=True, distance_to_target=0.2)
    assert judge.verify(SimpleNamespace(contacts=0, **vars(seen)))
    assert not judge.verify(SimpleNamespace(contacts=1, **vars(seen)))


@pytest.mark.slow
def test_the_sweep_in_python_prints_a_line_for_each_world(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = perform(RunRequest("avoid-obstacles", timeout_s=0.1, world="open"))

    def perform_all(_: object, _sweep: Sweep, requests: Iterable[RunRequest]) -> Iterator[RunOutput]:
        return (build_output(ended, request) for request in requests)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine.perform", perform_all)
    run_listing("docs/sweeps.md", "LocalEngine")
    assert capsys.readouterr().out == "arena 20 of 20\nclutter 20 of 20\n"


def build_output(ended: RunOutput, request: RunRequest) -> RunOutput:
    """Return the output of another run, as that of a verified run of a request."""
    result = replace(ended.record.result, world=request.world, seed=request.seed, verified=True)
    return RunOutput(replace(ended.record, result=result))


def test_the_detector_of_the_page_finds_a_green_patch() -> None:
    image: Image = np.full((240, 320, 3), 128, np.uint8)
    image[100:140, 200:240] = (60, 170, 40)
    robot = MockRobot(camera=image).layered
    (blob,) = run_listing("docs/vision.md", "ColourDetector", robot=robot, frame=robot.camera.read())["blobs"]
    assert blob.box == (200, 100, 40, 40)
