from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import pytest

from robotcore.cli.doctor.smoke_test import diagnose
from robotcore.description import load_robot, load_world
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, Mistake
from robotcore.hal.backend import Backend, Setup, load_backend
from robotcore.hal.check_finding import Finding, Level
from robotcore.hal.robot import Robot
from tests.robotcore.fakes import RigBackend
from tests.texts import CheckText


class RaisingBackend(RigBackend):
    """A backend whose ``open`` raises an error."""

    needs_world = True

    def __init__(self, error: Exception) -> None:
        super().__init__()
        self._error = error

    def open(self, setup: Setup) -> Robot:
        raise self._error


def diagnose_all(backend: Backend, robot: str | None = None) -> list[Finding]:
    return list(diagnose(backend, load_robot(robot) if robot else None))


def test_a_simulator_opens_moves_a_robot_and_renders(check_text: CheckText) -> None:
    (found,) = diagnose_all(load_backend("kinematic"))
    assert (found.level, found.kind) == (Level.OK, "works")
    check_text(found.message)


def test_a_note_of_a_simulator_that_works_is_a_warning_with_its_remedy(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    backend = load_backend("kinematic")
    opened = backend.open(Setup(load_robot("rover"), load_world("open"), frozenset({"nose"})))
    opened.notes = ("the pictures are painted, because there is no lib.so.1. Install it",)
    monkeypatch.setattr(backend, "open", lambda _: opened)
    (found,) = diagnose_all(backend)
    assert (found.level, found.kind) == (Level.WARNING, "works-with-notes")
    check_text(f"{found.message}\n{found.remedy}")


def test_only_the_devices_of_the_robot_are_tested(check_text: CheckText) -> None:
    (found,) = diagnose_all(load_backend("kinematic"), "lookout")
    assert (found.level, found.kind) == (Level.OK, "works")
    check_text(found.message)


def test_a_simulator_in_which_nothing_moves_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.kinematic.devices.KinematicMotor._apply", lambda *_: 0.0)
    (found,) = diagnose_all(load_backend("kinematic"))
    assert (found.level, found.kind) == (Level.ERROR, "nothing-moves")


@pytest.mark.parametrize(
    "error, kind",
    [
        (DeviceError("eye", "no camera"), "device"),
        (DeviceError("eye", "no lib.so.1. Install it", kind="no-library"), "no-library"),
        (DeviceGroupError("opening", [DeviceError("eye", "blind. Look")]), "device-group"),
        (TypeError("wrong\nbuild"), "simulator-broken"),
    ],
    ids=["no remedy", "remedy", "group", "bug"],
)
def test_a_simulator_that_does_not_open_is_an_error_with_its_cause_and_its_remedy(
    error: Exception, kind: str, check_text: CheckText
) -> None:
    (found,) = diagnose_all(RaisingBackend(error))
    assert (found.subject, found.level, found.kind) == ("rig", Level.ERROR, kind)
    check_text(f"{found.message}\n{found.remedy}")


def test_a_backend_that_is_missing_is_a_warning_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("drivers.pybullet.backend.PyBulletBackend.modules", ("no_such_simulator",))
    backend = load_backend("pybullet")
    (found,) = diagnose_all(backend)
    assert (found.level, found.kind, found.remedy) == (Level.WARNING, "not-installed", backend.remedy)


def test_a_backend_that_simulates_nothing_is_not_tested() -> None:
    (found,) = diagnose_all(load_backend("replay"))
    assert (found.level, found.kind) == (Level.OK, "installed")


def test_a_simulator_whose_own_check_fails_has_one_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Finding.warning("rig", "no server listens", "Start it", kind="connection-refused")
    monkeypatch.setattr(RaisingBackend, "examine", lambda *_: [found])
    assert diagnose_all(RaisingBackend(DeviceError("rig", "no server listens"))) == [found]


def test_a_wrong_pin_is_one_finding_of_the_virtual_pi(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    text = files("robotcore.description").joinpath("robots/rover.toml").read_text(encoding="utf-8")
    file.write_text(text.replace("trigger = 16", "trigger = 17"), encoding="utf-8")
    (found,) = diagnose_all(load_backend("virtualpi"), str(file))
    assert found.level is Level.ERROR


def test_a_robot_without_a_section_is_an_error_that_names_no_check_that_passes(check_text: CheckText) -> None:
    (found,) = diagnose_all(load_backend("virtualpi"), "bubblerob")
    assert (found.level, found.kind) == (Level.ERROR, "no-section")
    check_text(f"{found.message}\n{found.remedy}")


@pytest.mark.parametrize("display, level", [(":0", Level.OK), ("", Level.WARNING)])
def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch, display: str, level: Level) -> None:
    monkeypatch.setattr("robotcore.cli.doctor.smoke_test.IS_LINUX", True)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setattr("drivers.kinematic.backend.KinematicBackend.has_gui", True)
    assert [each.level for each in diagnose_all(load_backend("kinematic")) if each.subject == "display"] == [level]


def test_a_wrong_robot_file_is_an_error_with_the_command_that_checks_it(check_text: CheckText) -> None:
    error = DescriptionError.of_all(
        "my.toml",
        [Mistake("is missing", "Add it", key="board.nose"), Mistake("c", "D", key="b"), Mistake("f", "G", key="e")],
    )
    (found,) = diagnose_all(RaisingBackend(error), "lookout")
    assert (found.level, found.kind, found.remedy) == (Level.ERROR, "description", "robotcore check lookout")
    check_text(found.message)
