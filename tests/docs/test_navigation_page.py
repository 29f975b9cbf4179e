from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from robotcore import Navigator, OccupancyGrid
from robotcore.autonomy.navigation.grid_file import LAYERS, SCALARS
from tests.docs.listings import find_code, list_missing_attributes, read_rows

PAGE = (Path(__file__).parents[2] / "docs" / "navigation.md").read_text()


@pytest.mark.slow
def test_line_writes_the_picture_of_a_map(tmp_path: Path) -> None:
    (line,) = (code for code in find_code(PAGE) if code.startswith("cv2.imwrite"))
    script = f"import cv2, robotcore; grid = robotcore.OccupancyGrid(); {line}"
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    np.testing.assert_array_equal(np.asarray(cv2.imread(str(tmp_path / "room.png"))), OccupancyGrid().draw())


FOR_THE_NAVIGATOR = {
    "add_free_disc",
    "add_range",
    "clear_echo",
    "contradicts_echo",
    "evidence",
    "find_window",
    "forget",
    "nearest_echo",
    "travelled",
    "updated_at",
}


@pytest.mark.parametrize(
    "value", [Navigator(speed=0.2, turn=1.0), OccupancyGrid()], ids=lambda each: type(each).__name__
)
def test_page_names_every_attribute(value: object) -> None:
    assert list_missing_attributes(PAGE, value) - FOR_THE_NAVIGATOR == set()


def test_each_listed_array_is_in_the_file(tmp_path: Path) -> None:
    OccupancyGrid().save(tmp_path / "room.npz")
    rows = read_rows(PAGE, "The file of a map")
    listed = {name: row[1] for row in rows for name in find_code(row[0])}
    assert listed.keys() == {*SCALARS, *LAYERS}
    with np.load(tmp_path / "room.npz") as arrays:
        assert listed == {
            name: f"{array.dtype}, {'(rows, rows)' if array.ndim else '()'}" for name, array in arrays.items()
        }
