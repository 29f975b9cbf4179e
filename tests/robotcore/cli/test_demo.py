from __future__ import annotations

from pathlib import Path

import pytest

from drivers.pybullet.backend import PyBulletBackend
from robotcore.cli.demo import chosen_backend
from robotcore.cli.main import execute


def test_takes_the_physics_simulator_that_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PyBulletBackend, "is_installed", True)
    backend, why = chosen_backend()
    assert backend == "pybullet"
    assert "installed for this Python" in why


def test_says_why_it_takes_the_built_in_simulator_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PyBulletBackend, "is_installed", False)
    backend, why = chosen_backend()
    assert backend == "kinematic"
    assert why.startswith("pybullet is not installed. ")


def test_finds_the_ball_and_leaves_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(PyBulletBackend, "is_installed", False)
    picture = tmp_path / "demo.png"
    assert execute(["demo", "--picture", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    assert "--backend kinematic --seed 7" in capfd.readouterr().out
