from __future__ import annotations

from pathlib import Path

import pytest

from drivers.mujoco.backend import MujocoBackend
from drivers.pybullet.backend import PyBulletBackend
from robotcore.cli.main import execute
from robotcore.cli.run import choose_simulator
from robotcore.hal.check_finding import Finding
from tests.texts import CheckText

WORKS = Finding.ok("simulator", "works", kind="works")
BROKEN = Finding.error("simulator", "eye: there is no OpenGL. Install libegl1", "", kind="broken")


@pytest.mark.parametrize(
    "pybullet, mujoco, chosen",
    [
        (WORKS, WORKS, "pybullet"),
        (None, WORKS, "mujoco"),
        (None, BROKEN, "kinematic"),
        (None, None, "kinematic"),
    ],
    ids=["both", "without pybullet", "broken mujoco", "neither"],
)
def test_the_best_simulator_that_works_is_chosen_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
    pybullet: Finding | None,
    mujoco: Finding | None,
    chosen: str,
    check_text: CheckText,
) -> None:
    for simulator, finding in ((PyBulletBackend, pybullet), (MujocoBackend, mujoco)):
        monkeypatch.setattr(simulator, "is_installed", finding is not None)
        monkeypatch.setattr(simulator, "examine", lambda *_, finding=finding: [finding])
    backend, why = choose_simulator()
    assert backend == chosen
    check_text(why)


@pytest.mark.slow
def test_finds_the_ball_and_draws_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for simulator in (PyBulletBackend, MujocoBackend):
        monkeypatch.setattr(simulator, "is_installed", False)
    picture = tmp_path / "demo.png"
    assert execute(["demo", "--picture", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    assert "\n$ robotcore run green-search --backend kinematic --seed 7 " in capfd.readouterr().out


@pytest.mark.posix("Windows keeps a working folder")
def test_a_deleted_working_folder_is_named_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    for simulator in (PyBulletBackend, MujocoBackend):
        monkeypatch.setattr(simulator, "is_installed", False)
    (tmp_path / "deleted").mkdir()
    monkeypatch.chdir(tmp_path / "deleted")
    (tmp_path / "deleted").rmdir()
    assert execute(["demo"]) == 2
    check_text(capfd.readouterr().err)
