from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.resources import files
from pathlib import Path

import pytest

from robotcore import Outcome
from robotcore.deploy import checks, simulation
from robotcore.deploy.bundle import Bundle
from robotcore.deploy.checks import run_python
from robotcore.deploy.project import DeployOptions, DeployTable, Project, build_project
from robotcore.deploy.simulation import choose_simulator, is_pass
from robotcore.deploy.staging import copy_files
from robotcore.errors import DescriptionError, ReleaseCheckError, UsageError
from robotcore.runtime.plan import RunRequest
from tests.robotcore.deploy.projects import DRIVES_ON, TABLE, write, write_project
from tests.robotcore.sweep.conftest import make_record
from tests.texts import CheckText, Raises

RAISES = DRIVES_ON.replace("return Status.RUNNING", "return 1 / 0")


def build_small_bundle(project: Project, tmp_path: Path) -> Bundle:
    """Return a bundle of a project without robotcore. The simulation imports the robotcore of the tests instead."""
    folder = write(tmp_path.with_name(f"{tmp_path.name}-bundle"), {"site/packaged.py": ""})
    copy_files(project.folder or tmp_path, folder / "project")
    return Bundle(project, folder, ())


@pytest.mark.slow
def test_passing_tests_are_counted(tmp_path: Path) -> None:
    said: list[str] = []
    assert checks.run_tests(write_project(tmp_path), said.append).summary == "none"
    write(tmp_path, {"tests/test_a.py": "def test_a(): pass\ndef test_b(): pass\n"})
    assert checks.run_tests(write_project(tmp_path), said.append).summary == "2 passed"
    assert said == ["pytest"]


@pytest.mark.slow
def test_failing_test_is_named_with_the_command_that_repeats_it(tmp_path: Path, raises: Raises) -> None:
    write(tmp_path, {"a b/test_a.py": "def test_a(): pass\ndef test_b(): assert 1 == 2\n"})
    with raises(ReleaseCheckError, "tests-failed"):
        checks.run_tests(write_project(tmp_path), str)


@pytest.mark.slow
def test_hanging_tests_are_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "LIMIT_S", 3.0)
    write(tmp_path, {"test_a.py": "import time\ndef test_a(): time.sleep(600)\n"})
    with pytest.raises(ReleaseCheckError) as raised:
        checks.run_tests(write_project(tmp_path), str)
    assert raised.value.kind == "tests-hang"


def test_every_mistake_of_a_description_is_reported(tmp_path: Path, raises: Raises) -> None:
    write(tmp_path, {"-my room.toml": "[floor]\nlenght_m = 3\nwidth_m = 3\n[walls]\nhight_m = 1\n"})
    project = write_project(tmp_path, TABLE.replace("\n\n", '\nworld = "-my room.toml"\n\n'))
    with raises(ReleaseCheckError, "description-check-failed") as raised:
        checks.check_descriptions(project, str)
    cause = raised.value.__cause__
    assert isinstance(cause, DescriptionError)
    assert {each.key for each in (cause, *cause.others)} >= {"floor.lenght_m", "walls.hight_m"}


def test_doubtful_values_of_the_robot_and_the_world_are_warnings(tmp_path: Path) -> None:
    robot = files("robotcore.description").joinpath("robots/rover.toml").read_text(encoding="utf-8")
    target = '[[targets]]\nname = "ball"\ncolour = "red"\nx_m = 9\ny_m = 0\nradius_m = 0.1\n'
    world = f'name = "room"\n[floor]\nlength_m = 3\nwidth_m = 3\n{target}'
    write(tmp_path, {"cm.toml": robot.replace("width_m = 0.185", "width_m = 18.5"), "room.toml": world})
    result = checks.check_descriptions(write_project(tmp_path, robot="cm.toml", world="room.toml"), str)
    assert [each.split(":")[:2] for each in result.warnings] == [["warning", " body"], ["warning", " ball"]]


def test_error_for_a_missing_section_names_no_check_that_passes(tmp_path: Path, check_text: CheckText) -> None:
    with pytest.raises(ReleaseCheckError) as raised:
        checks.check_descriptions(write_project(tmp_path, robot="bubblerob", backend="raspberrypi"), str)
    check_text(str(raised.value))


@pytest.mark.slow
def test_endless_app_passes_if_it_has_no_contact(tmp_path: Path) -> None:
    write(
        tmp_path, {"drivers/__init__.py": "", "json.py": "raise ImportError"}
    )  # the user's names hide no module of robotcore
    said: list[str] = []
    result = simulation.simulate(build_small_bundle(write_project(tmp_path), tmp_path), said.append)
    assert result.summary == "kinematic, arena, seeds 1: 1 of 1 without a contact"
    assert "kinematic, arena, seeds 1: 0 of 1 runs" in said


@pytest.mark.slow
def test_simulation_uses_the_bundle_and_does_not_change_it(tmp_path: Path, raises: Raises) -> None:
    app = "import helper, packaged\n" + DRIVES_ON.replace("return", "open('log', 'a').close()\n        return")
    project = write_project(write(tmp_path, {"helper.py": ""}), app=app)
    bundle = build_small_bundle(project, tmp_path)
    (tmp_path / "helper.py").write_text("raise OSError('changed meanwhile')")
    before = {*bundle.folder.rglob("*")}
    simulation.simulate(bundle, str)
    assert {*bundle.folder.rglob("*")} == before
    (bundle.folder / "project" / "helper.py").unlink()
    with raises(ReleaseCheckError, "simulation-not-run"):
        simulation.simulate(bundle, str)


@pytest.mark.slow
def test_failing_run_is_reported_with_the_command_that_repeats_it(tmp_path: Path, raises: Raises) -> None:
    project = write_project(write(tmp_path / "a 'b", {}), app=RAISES)
    with raises(ReleaseCheckError, "run-failed", seed=1):
        simulation.simulate(build_small_bundle(project, tmp_path), str)


@pytest.mark.slow
def test_hanging_app_fails_the_simulation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "HANG_MARGIN_S", 3.0 - RunRequest.timeout_s)
    project = write_project(tmp_path, app="import time\n" + DRIVES_ON.replace("return", "time.sleep(600); return"))
    monkeypatch.setattr(simulation, "run_python", partial(_run_with_long_limit, run_python))
    with pytest.raises(ReleaseCheckError) as raised:
        simulation.simulate(build_small_bundle(project, tmp_path), str)
    assert raised.value.kind == "run-failed"
    assert raised.value.fields["seed"] == 1


def _run_with_long_limit(run: Callable[..., object], *words: object, limit_s: float, **more: object) -> object:
    return run(*words, limit_s=limit_s + 1000, **more)


def test_required_bounds_decide_instead_of_the_runs(tmp_path: Path) -> None:
    project = write_project(tmp_path, TABLE + 'require = ["verified>=0.5"]\n')
    words = simulation.build_sweep_arguments(project, "kinematic", "arena")
    assert words[words.index("--require") + 1] == "verified>=0.5"
    failing = [make_record(Outcome.FAILURE, verified=False)]
    simulation._require_pass(project, [], failing)
    with pytest.raises(ReleaseCheckError) as raised:
        simulation._require_pass(project, ["kinematic, arena: verified is 0.3, required verified>=0.5"], failing)
    assert raised.value.kind == "bound-missed"
    assert raised.value.fields["missed"] == ("kinematic, arena: verified is 0.3, required verified>=0.5",)


def test_runs_that_pass_without_required_bounds() -> None:
    for outcome, verified, contacts, is_passed in [
        (Outcome.SUCCESS, True, 0, True),
        (Outcome.SUCCESS, None, 0, True),
        (Outcome.SUCCESS, False, 0, False),
        (Outcome.SUCCESS, True, 1, False),
        (Outcome.TIMEOUT, None, 0, True),
        (Outcome.TIMEOUT, None, 1, False),
        (Outcome.TIMEOUT, False, 0, False),
        (Outcome.STOPPED, None, 0, False),
        (Outcome.ERROR, None, 0, False),
    ]:
        record = make_record()
        result = replace(record.result, outcome=outcome, verified=verified, contacts=contacts)
        assert is_pass(replace(record, result=result)) is is_passed, (outcome, verified, contacts)


def test_simulator_is_the_nearest_one_to_the_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rover = build_project(DeployOptions(app="green-search", robot="rover"), tmp_path)
    assert choose_simulator(rover) == ("virtualpi", ())
    assert choose_simulator(replace(rover, robot="bubblerob")) == ("kinematic", ())
    assert choose_simulator(replace(rover, deploy=DeployTable(backend="kinematic"))) == ("kinematic", ())
    monkeypatch.setattr(simulation, "find_spec", lambda _: None)
    backend, warnings = choose_simulator(rover)
    assert (backend, len(warnings)) == ("kinematic", 1)
    assert "pip install gpiozero" in warnings[0]


def test_world_with_a_comma_in_its_name_is_refused(tmp_path: Path) -> None:
    write(tmp_path, {"a,b.toml": ""})
    project = write_project(tmp_path, TABLE.replace("\n\n", '\nworld = "a,b.toml"\n\n'))
    with pytest.raises(UsageError) as raised:
        simulation.simulate(build_small_bundle(project, tmp_path), str)
    assert raised.value.kind == "comma-in-world"
