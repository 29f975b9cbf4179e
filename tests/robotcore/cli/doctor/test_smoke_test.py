"""test_smoke_test."""

from __future__ import annotations

import pytest

from robotcore.cli.doctor.smoke_test import diagnose
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError
from robotcore.hal.backend import Backend, Setup, load_backend
from robotcore.hal.finding import Finding, Level
from robotcore.hal.robot import Robot
from tests.robotcore.fakes import RigBackend


class Dead(RigBackend):
    """Opens nothing."""

    needs_world = True

    def __init__(self, error: Exception) -> None:
        super().__init__()
        self._error = error

    def open(self, setup: Setup) -> Robot:
        raise self._error


def examined(backend: Backend, robot: str | None = None) -> list[Finding]:
    return list(diagnose(backend, load_robot(robot) if robot else None))


def test_a_simulator_is_opened_driven_and_looked_through() -> None:
    (found,) = examined(load_backend("kinematic"))
    assert found == Finding.ok("kinematic", "opens, moves, measures, renders 320 x 240 pixels, closes")


def test_a_robot_is_tried_by_what_it_has() -> None:
    (found,) = examined(load_backend("kinematic"), "lookout")
    assert found.level is Level.OK
    assert "moves" not in found.said
    assert "renders" in found.said


def test_a_simulator_in_which_nothing_moves_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.kinematic.devices.KinematicMotor._apply", lambda *_: 0.0)
    (found,) = examined(load_backend("kinematic"))
    assert (found.level, found.said) == (Level.ERROR, "opens, but nothing moves")


@pytest.mark.parametrize(
    "error, said, remedy",
    [
        (DeviceError("eye", "no camera"), "eye: no camera", "Try robotcore run green-search --backend rig"),
        (DeviceError("eye", "no lib.so.1. Install it"), "eye: no lib.so.1", "Install it"),
        (DeviceGroupError("opening", [DeviceError("eye", "blind. Look")]), "eye: blind", "Look"),
        (TypeError("wrong\nbuild"), "does not work: TypeError: wrong build", RigBackend().remedy),
    ],
)
def test_a_simulator_that_does_not_open_is_an_error_with_its_cause_and_its_remedy(
    error: Exception, said: str, remedy: str
) -> None:
    assert examined(Dead(error)) == [Finding.error("rig", said, remedy)]


def test_a_backend_that_is_missing_is_a_warning_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("drivers.pybullet.backend.PyBulletBackend.modules", ("no_such_simulator",))
    backend = load_backend("pybullet")
    assert examined(backend) == [Finding.warning("pybullet", "is not installed", backend.remedy)]


def test_a_backend_that_simulates_nothing_is_not_tried() -> None:
    assert examined(load_backend("replay")) == [Finding.ok("replay", "is installed")]


@pytest.mark.parametrize("display, level", [(":0", Level.OK), ("", Level.WARNING)])
def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch, display: str, level: Level) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setattr("drivers.kinematic.backend.KinematicBackend.has_gui", True)
    assert [each.level for each in examined(load_backend("kinematic")) if each.what == "display"] == [level]


def test_a_robot_s_file_that_is_wrong_is_an_error_with_the_command_that_tells_all_of_it() -> None:
    error = DescriptionError.of_all(
        "my.toml", [("board.nose", "is missing", "Add it"), ("b", "c", "D"), ("e", "f", "G")]
    )
    (found,) = examined(Dead(error), "lookout")
    assert found == Finding.error(
        "rig", "cannot open my.toml: board.nose: is missing, and 2 more", "robotcore check lookout"
    )
