from __future__ import annotations

from pathlib import Path

import pytest

from drivers.mujoco.backend import MujocoBackend
from drivers.pybullet.backend import PyBulletBackend
from robotcore.cli.main import execute
from robotcore.cli.run import choose_simulator
from robotcore.hal.backend import Backend
from robotcore.hal.check_finding import Finding
from tests.texts import CheckText

Simulator = type[Backend]


def set_working(monkeypatch: pytest.MonkeyPatch, simulator: Simulator, *, failure: str = "") -> None:
    kind = "broken" if failure else "works"
    finding = (
        Finding.error(simulator.name, failure, "", kind=kind)
        if failure
        else Finding.ok(simulator.name, "works", kind=kind)
    )
    monkeypatch.setattr(simulator, "is_installed", True)
    monkeypatch.setattr(simulator, "examine", lambda *_: [finding])


def set_missing(monkeypatch: pytest.MonkeyPatch, *simulators: Simulator) -> None:
    for simulator in simulators:
        monkeypatch.setattr(simulator, "is_installed", False)


def test_chooses_the_physics_simulator_that_needs_no_opengl(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    set_working(monkeypatch, PyBulletBackend)
    set_working(monkeypatch, MujocoBackend)
    backend, why = choose_simulator()
    assert backend == "pybullet"
    check_text(why)


def test_chooses_mujoco_with_the_reason_if_pybullet_is_missing(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    set_missing(monkeypatch, PyBulletBackend)
    set_working(monkeypatch, MujocoBackend)
    backend, why = choose_simulator()
    assert backend == "mujoco"
    check_text(why)


def test_does_not_choose_a_simulator_that_fails(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    set_missing(monkeypatch, PyBulletBackend)
    set_working(monkeypatch, MujocoBackend, failure="eye: there is no OpenGL. Install libegl1")
    backend, why = choose_simulator()
    assert backend == "kinematic"
    check_text(why)


def test_chooses_the_built_in_simulator_with_the_reasons(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    set_missing(monkeypatch, PyBulletBackend, MujocoBackend)
    backend, why = choose_simulator()
    assert backend == "kinematic"
    check_text(why)


@pytest.mark.slow
def test_finds_the_ball_and_draws_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    set_missing(monkeypatch, PyBulletBackend, MujocoBackend)
    picture = tmp_path / "demo.png"
    assert execute(["demo", "--picture", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    assert "\n$ robotcore run green-search --backend kinematic --seed 7 " in capfd.readouterr().out
