"""The pictures of the pages are those that the present code draws."""

from __future__ import annotations

import shlex
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest

from robotcore.cli.main import execute
from tests.docs.listings import list_listings, read_pages, write_files

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "images"
COMMANDS = {
    "green-search.png": "robotcore run green-search --backend pybullet --seed 7 --picture green-search.png",
    "bubblerob-reflex.png": "robotcore run reflex.py --robot bubblerob --world occluded --picture bubblerob-reflex.png",
    "green-lookout.png": ("robotcore run mark-green --robot lookout --world open --seed 3 --picture green-lookout.png"),
}
"""The pictures that one command draws anywhere. The titles of the pictures contain the speed of the run."""

OTHERS = {
    "badge.svg": "tests/docs/test_project_ci_page.py draws it again",
    "bubblerob-scene.png": "a screenshot of CoppeliaSim",
    "coppeliasim-built.png": "a screenshot of CoppeliaSim",
    "fidelity.png": "a recording of the robot with wrong motors, which is not kept",
    "green-v0.png": "a picture of a vision sensor in CoppeliaSim",
    "green-v1.png": "a picture of a vision sensor in CoppeliaSim",
    "live-page-dark.png": "python -m benchmarks.live_screenshots",
    "live-page-phone.png": "python -m benchmarks.live_screenshots",
    "live-page-recordings.png": "python -m benchmarks.live_screenshots",
    "live-page.png": "python -m benchmarks.live_screenshots",
}
"""The other pictures, and where they come from."""

MAX_DIFFERENCE = 2.0
"""The greatest mean difference of two pictures, in grey levels. The text of the speed makes less."""


def test_each_picture_has_an_origin_and_a_page() -> None:
    pictures = {file.name for file in FOLDER.iterdir()}
    assert pictures == COMMANDS.keys() | OTHERS.keys()
    text = "\n".join(read_pages().values())
    assert [name for name in pictures if f"images/{name}" not in text] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_command_draws_the_picture_again(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if "pybullet" in COMMANDS[name] and find_spec("pybullet") is None:
        pytest.skip("needs PyBullet")
    tutorial = (ROOT / "docs" / "tutorials" / "bubblerob.md").read_text(encoding="utf-8")
    write_files((each for each in list_listings(tutorial) if each.file == "reflex.py"), tmp_path)
    monkeypatch.chdir(tmp_path)
    execute(shlex.split(COMMANDS[name])[1:])
    drawn, shown = cv2.imread(name), cv2.imread(str(FOLDER / name))
    assert drawn is not None
    assert shown is not None
    assert drawn.shape == shown.shape
    assert np.abs(drawn.astype(int) - shown).mean() < MAX_DIFFERENCE
