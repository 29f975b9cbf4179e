"""The changes of a robot's file by measured values."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.cli.robot_changes import RobotChanges
from robotcore.description import read_shipped
from robotcore.errors import DescriptionError
from robotcore.hal.backend import load_backend


@pytest.fixture
def changes(tmp_path: Path) -> RobotChanges:
    file = tmp_path / "own.toml"
    file.write_text(read_shipped("rover"))
    return RobotChanges(str(file), is_writing=True)


def test_values_with_mistakes_are_shown_and_not_written(
    changes: RobotChanges, capsys: pytest.CaptureFixture[str]
) -> None:
    changes.set_device("nose", offset_m=1.2)
    with pytest.raises(DescriptionError):
        changes.finish(load_backend("virtualpi"))
    changes.show(is_right=False)
    shown = capsys.readouterr().out
    assert "+offset_m = 1.2" in shown
    assert "stays as it is: the new values have mistakes." in shown


def test_new_values_that_blind_the_range_guard_are_written_with_a_warning(
    changes: RobotChanges, capsys: pytest.CaptureFixture[str]
) -> None:
    changes.set_device("nose", offset_m=-0.3)
    changes.finish(load_backend("virtualpi"))
    changes.show(is_right=True)
    assert changes.is_written
    assert "warning: safety.stop_distance_m: nose measures no distance ahead below" in capsys.readouterr().out
