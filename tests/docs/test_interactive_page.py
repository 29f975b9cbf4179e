from __future__ import annotations

from pathlib import Path

from robotcore import LiveRobot

PAGE = (Path(__file__).parents[2] / "docs" / "interactive.md").read_text()


def test_page_names_every_method_of_a_live_robot() -> None:
    own = {name for name in vars(LiveRobot) if not name.startswith("_")}
    assert {name for name in own - {"is_running", "drive"} if f"robot.{name}" not in PAGE} == set()
