from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import UsageError
from robotcore.hardware.firmware.board import copy_sketch, find_sketch, read_baud, shipped_sketch


def test_copy_is_the_whole_sketch_and_is_found_by_either_folder(tmp_path: Path) -> None:
    sketch = copy_sketch(tmp_path)
    assert sorted(file.name for file in sketch.iterdir()) == sorted(file.name for file in shipped_sketch().iterdir())
    assert find_sketch(tmp_path) == find_sketch(sketch) == sketch


def test_copy_never_writes_over_one_that_was_edited(tmp_path: Path) -> None:
    (copy_sketch(tmp_path) / "config.h").write_text("mine")
    with pytest.raises(UsageError, match=r"is there already. Edit its config.h"):
        copy_sketch(tmp_path)
    assert (find_sketch(tmp_path) / "config.h").read_text() == "mine"


def test_folder_without_a_sketch_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"holds no sketch .*robotcore firmware copy"):
        find_sketch(tmp_path)


def test_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="file/robotcore_bridge: Not a directory"):
        copy_sketch(tmp_path / "file")


def test_baud_is_what_the_sketch_says(tmp_path: Path) -> None:
    assert read_baud(shipped_sketch()) == 57600
    config = copy_sketch(tmp_path) / "config.h"
    config.write_text(config.read_text().replace("#define BAUD 57600", "#define BAUD 115200"))
    assert read_baud(find_sketch(tmp_path)) == 115200
    config.unlink()
    assert read_baud(find_sketch(tmp_path)) == 57600
