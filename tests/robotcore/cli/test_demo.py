from __future__ import annotations

from pathlib import Path

import pytest

from drivers.mujoco.backend import MujocoBackend
from drivers.pybullet.backend import PyBulletBackend
from robotcore.cli.demo import chosen_backend
from robotcore.cli.main import execute
from robotcore.hal.backend import Backend
from robotcore.hal.finding import Finding

Simulator = type[Backend]


def works(monkeypatch: pytest.MonkeyPatch, simulator: Simulator, *, fault: str = "") -> None:
    found = Finding.error(simulator.name, fault, "") if fault else Finding.ok(simulator.name, "works")
    monkeypatch.setattr(simulator, "is_installed", True)
    monkeypatch.setattr(simulator, "examine", lambda *_: [found])


def is_missing(monkeypatch: pytest.MonkeyPatch, *simulators: Simulator) -> None:
    for simulator in simulators:
        monkeypatch.setattr(simulator, "is_installed", False)


def test_takes_the_physics_simulator_that_needs_no_opengl(monkeypatch: pytest.MonkeyPatch) -> None:
    works(monkeypatch, PyBulletBackend)
    works(monkeypatch, MujocoBackend)
    assert chosen_backend() == ("pybullet", "pybullet (Bullet rigid-body physics, in process): the demo runs on it.")


def test_takes_mujoco_where_there_is_no_pybullet_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    is_missing(monkeypatch, PyBulletBackend)
    works(monkeypatch, MujocoBackend)
    backend, why = chosen_backend()
    assert backend == "mujoco"
    assert why.startswith("pybullet is not installed. ")
    assert why.endswith(f" mujoco ({MujocoBackend.summary}): the demo runs on it.")


def test_takes_no_simulator_that_does_not_work(monkeypatch: pytest.MonkeyPatch) -> None:
    is_missing(monkeypatch, PyBulletBackend)
    works(monkeypatch, MujocoBackend, fault="eye: there is no OpenGL. Install libegl1")
    backend, why = chosen_backend()
    assert backend == "kinematic"
    assert "mujoco: eye: there is no OpenGL. Install libegl1. The demo runs on the built-in" in why


def test_says_why_it_takes_the_built_in_simulator_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    is_missing(monkeypatch, PyBulletBackend, MujocoBackend)
    backend, why = chosen_backend()
    assert backend == "kinematic"
    assert why.startswith("pybullet is not installed. ")
    assert "mujoco is not installed. " in why


def test_finds_the_ball_and_leaves_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    is_missing(monkeypatch, PyBulletBackend, MujocoBackend)
    picture = tmp_path / "demo.png"
    assert execute(["demo", "--picture", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    assert "--backend kinematic --seed 7" in capfd.readouterr().out
