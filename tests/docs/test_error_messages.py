"""The messages in the notes about errors are those of real runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import robotcore
from docs.generator.error_pages import read_notes
from robotcore import RunRequest, description, run
from robotcore.errors import RobotcoreError

ROVER = (Path(description.__file__).parent / "robots" / "rover.toml").read_text(encoding="utf-8")
APP = "from robotcore import Behaviour\n\nclass App(Behaviour)\n    pass\n"


def load(text: str, other: str) -> Callable[[], object]:
    """Return a function that loads the rover's file after a change."""

    def load_changed() -> None:
        assert text in ROVER
        Path("robot.toml").write_text(ROVER.replace(text, other, 1), encoding="utf-8")
        description.load_robot("robot.toml")

    return load_changed


def run_broken_app() -> None:
    Path("app.py").write_text(APP, encoding="utf-8")
    run(RunRequest("app.py"))


def drive_into_an_obstacle() -> None:
    with robotcore.open("rover", world="arena") as robot:
        robot.drive.straight(2.0)


MISTAKES: dict[str, Callable[[], object]] = {
    "unknown-key": load("wheel_radius_m", "wheel_radus_m"),
    "missing-key": load("track_m = 0.155\n", ""),
    "out-of-bounds": load("track_m = 0.155", "track_m = 155"),
    "wrong-value": load("track_m = 0.155", 'track_m = "wide"'),
    "not-toml": load('name = "rover"', 'name = "rover'),
    "unmet-need": lambda: run(RunRequest("green-search", robot="lookout")),
    "unknown-app": lambda: run(RunRequest("green-serch")),
    "unknown-robot": lambda: run(RunRequest("green-search", robot="rovr")),
    "unknown-world": lambda: run(RunRequest("green-search", world="arna")),
    "app-not-importable": run_broken_app,
    "blocked": drive_into_an_obstacle,
}


def test_each_note_with_a_message_is_repeated() -> None:
    assert MISTAKES.keys() == {kind for kind, note in read_notes().items() if "message" in note}


@pytest.mark.parametrize("kind", MISTAKES)
def test_the_message_of_a_note_is_that_of_a_real_run(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RobotcoreError) as found:
        MISTAKES[kind]()
    assert (found.value.kind, str(found.value)) == (kind, read_notes()[kind]["message"])
