from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from robotcore import Outcome
from robotcore.deploy import checks, simulation
from robotcore.deploy.bundle import Bundle
from robotcore.deploy.checks import run_python
from robotcore.deploy.project import DeployOptions, Project, build_project
from robotcore.deploy.simulation import choose_simulator, is_pass
from robotcore.deploy.staging import copy_files
from robotcore.errors import DescriptionError, UnprovenError, UsageError
from robotcore.runtime.plan import RunRequest
from tests.robotcore.deploy.projects import DRIVES_ON, TABLE, project_in, write
from tests.robotcore.sweep.conftest import record_of

RAISES = DRIVES_ON.replace("return Status.RUNNING", "return 1 / 0")


def bundle_of(project: Project, tmp_path: Path) -> Bundle:
    """Return a project as it is sent; robotcore is the one that runs the tests, which is compiled already."""
    folder = write(tmp_path.with_name(f"{tmp_path.name}-bundle"), {"site/packaged.py": ""})
    copy_files(project.folder or tmp_path, folder / "project")
    return Bundle(project, folder, ())


def test_tests_that_pass_are_counted(tmp_path: Path) -> None:
    write(tmp_path, {"tests/test_a.py": "def test_a(): pass\ndef test_b(): pass\n"})
    said: list[str] = []
    assert checks.run_tests(project_in(tmp_path), said.append).summary == "2 passed"
    assert said == ["pytest"]


def test_a_test_that_fails_is_named_with_what_repeats_it(tmp_path: Path) -> None:
    write(tmp_path, {"a b/test_a.py": "def test_a(): pass\ndef test_b(): assert 1 == 2\n"})
    with pytest.raises(UnprovenError) as raised:
        checks.run_tests(project_in(tmp_path), str)
    assert str(raised.value).startswith("tests: 1 failed, 1 passed\n  FAILED a b/test_a.py::test_b")
    assert str(raised.value).endswith(f"Repeat it: cd {tmp_path.resolve()} && python -m pytest")


def test_tests_that_cannot_be_read_are_not_taken_for_none(tmp_path: Path) -> None:
    write(tmp_path, {"test_a.py": "import nothing_of_that_name\n"})
    with pytest.raises(UnprovenError) as raised:
        checks.run_tests(project_in(tmp_path), str)
    assert raised.value.kind == "tests-failed"


def test_tests_that_hang_are_ended_with_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "LIMIT_S", 3.0)
    write(tmp_path, {"test_a.py": "import time\ndef test_a(): time.sleep(600)\n"})
    with pytest.raises(UnprovenError) as raised:
        checks.run_tests(project_in(tmp_path), str)
    assert raised.value.kind == "tests-hang"


def test_a_project_without_tests_is_reported_so(tmp_path: Path) -> None:
    assert checks.run_tests(project_in(tmp_path), str).summary == "none"


def test_a_wrong_description_is_reported_in_all_its_faults(tmp_path: Path) -> None:
    write(tmp_path, {"-my room.toml": "[floor]\nlenght_m = 3\nwidth_m = 3\n[walls]\nhight_m = 1\n"})
    project = project_in(tmp_path, TABLE.replace("\n\n", '\nworld = "-my room.toml"\n\n'))
    with pytest.raises(UnprovenError) as raised:
        checks.check_descriptions(project, str)
    assert raised.value.kind == "description-check-failed"
    cause = raised.value.__cause__
    assert isinstance(cause, DescriptionError)
    assert {each.key for each in (cause, *cause.others)} >= {"floor.lenght_m", "walls.hight_m"}
    assert str(raised.value).endswith("robotcore check './-my room.toml'")


def test_a_robot_without_the_section_that_its_backend_needs_is_reported_at_the_desk(tmp_path: Path) -> None:
    rover = build_project(DeployOptions(app="avoid-obstacles", robot="bubblerob"), tmp_path)
    with pytest.raises(UnprovenError) as raised:
        checks.check_descriptions(rover, str)
    assert raised.value.kind == "description-check-failed"


def test_an_app_that_never_says_success_passes_by_going_on_without_a_touch(tmp_path: Path) -> None:
    write(tmp_path, {"drivers/__init__.py": "", "json.py": "raise ImportError"})  # a folder of the user's own
    said: list[str] = []
    result = simulation.simulate(bundle_of(project_in(tmp_path), tmp_path), said.append)
    assert result.summary == "kinematic, arena, seeds 1: 1 of 1 without a contact"
    assert "kinematic, arena, seeds 1: 0 of 1 runs" in said


def test_what_is_simulated_is_what_is_sent_and_stays_as_it_is(tmp_path: Path) -> None:
    app = "import helper, packaged\n" + DRIVES_ON.replace("return", "open('log', 'a').close()\n        return")
    project = project_in(write(tmp_path, {"helper.py": ""}), app=app)
    bundle = bundle_of(project, tmp_path)
    (tmp_path / "helper.py").write_text("raise OSError('changed meanwhile')")
    before = {*bundle.folder.rglob("*")}
    simulation.simulate(bundle, str)
    assert {*bundle.folder.rglob("*")} == before
    (bundle.folder / "project" / "helper.py").unlink()
    with pytest.raises(UnprovenError, match="No module named 'helper'") as raised:
        simulation.simulate(bundle, str)
    assert "it lacks a file that is not sent" in str(raised.value)


def test_a_run_that_fails_is_reported_with_the_line_that_repeats_it(tmp_path: Path) -> None:
    project = project_in(write(tmp_path / "a 'b", {}), app=RAISES)
    with pytest.raises(UnprovenError) as raised:
        simulation.simulate(bundle_of(project, tmp_path), str)
    assert "ZeroDivisionError" in str(raised.value)
    assert "robotcore run app.py --world arena --seed 1" in str(raised.value)
    assert f"cd '{tmp_path.resolve()}/a '\"'\"'b' && " in str(raised.value)


def test_an_app_that_hangs_is_reported_in_its_own_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "HANG_MARGIN_S", 3.0 - RunRequest.timeout_s)
    project = project_in(tmp_path, app="import time\n" + DRIVES_ON.replace("return", "time.sleep(600); return"))
    monkeypatch.setattr(simulation, "run_python", partial(_patient, run_python))
    with pytest.raises(UnprovenError) as raised:
        simulation.simulate(bundle_of(project, tmp_path), str)
    assert raised.value.kind == "run-failed"
    assert raised.value.fields["seed"] == 1


def _patient(asked: Callable[..., object], *words: object, limit_s: float, **more: object) -> object:
    return asked(*words, limit_s=limit_s + 1000, **more)


def test_required_bounds_decide_and_not_what_is_usual(tmp_path: Path) -> None:
    project = project_in(tmp_path, TABLE + 'require = ["verified>=0.5"]\n')
    words = simulation.sweep_arguments(project, "kinematic", "arena")
    assert words[words.index("--require") + 1] == "verified>=0.5"
    failing = [record_of(Outcome.FAILURE, verified=False)]
    simulation._require_pass(project, [], failing)
    with pytest.raises(UnprovenError) as raised:
        simulation._require_pass(project, ["kinematic, arena: verified is 0.3, required verified>=0.5"], failing)
    assert raised.value.kind == "bound-missed"
    assert raised.value.fields["missed"] == ("kinematic, arena: verified is 0.3, required verified>=0.5",)


def test_an_app_that_cannot_be_run_at_all_is_reported_why(tmp_path: Path) -> None:
    with pytest.raises(UnprovenError) as raised:
        simulation.simulate(bundle_of(project_in(tmp_path, app="x = 1\n"), tmp_path), str)
    assert raised.value.kind == "simulation-not-run"
    assert "&& robotcore sweep app.py --backend kinematic" in str(raised.value)


@pytest.mark.parametrize(
    "change, is_passed",
    [
        ({"outcome": Outcome.SUCCESS, "verified": True}, True),
        ({"outcome": Outcome.SUCCESS, "verified": None}, True),
        ({"outcome": Outcome.SUCCESS, "verified": False}, False),
        ({"outcome": Outcome.SUCCESS, "verified": True, "contacts": 1}, False),
        ({"outcome": Outcome.TIMEOUT, "verified": None}, True),
        ({"outcome": Outcome.TIMEOUT, "verified": None, "contacts": 1}, False),
        ({"outcome": Outcome.TIMEOUT, "verified": False}, False),
        ({"outcome": Outcome.STOPPED, "verified": None}, False),
        ({"outcome": Outcome.ERROR, "verified": None}, False),
    ],
)
def test_what_passes_where_nothing_is_required(change: dict[str, object], *, is_passed: bool) -> None:
    record = record_of()
    result = replace(record.result, **{"contacts": 0, **change})  # type: ignore[arg-type]
    assert is_pass(replace(record, result=result)) is is_passed


def test_simulated_is_what_comes_nearest_to_the_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rover = build_project(DeployOptions(app="green-search", robot="rover"), tmp_path)
    assert choose_simulator(rover) == ("virtualpi", ())
    assert choose_simulator(replace(rover, robot="bubblerob")) == ("kinematic", ())
    assert choose_simulator(replace(rover, backend="kinematic")) == ("kinematic", ())
    monkeypatch.setattr(simulation, "find_spec", lambda _: None)
    backend, notes = choose_simulator(rover)
    assert (backend, len(notes)) == ("kinematic", 1)
    assert "pip install gpiozero" in notes[0]


def test_a_world_that_a_sweep_would_take_for_two_is_refused(tmp_path: Path) -> None:
    write(tmp_path, {"a,b.toml": ""})
    project = project_in(tmp_path, TABLE.replace("\n\n", '\nworld = "a,b.toml"\n\n'))
    with pytest.raises(UsageError) as raised:
        simulation.simulate(bundle_of(project, tmp_path), str)
    assert raised.value.kind == "comma-in-world"
