from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.errors import FirmwareError, UsageError
from robotcore.hardware.firmware.board import (
    copy_sketch,
    find_only_port,
    find_sketch,
    read_baud,
    require_free,
    shipped_sketch,
)
from tests.doubles.serial.pty import Pty


def test_one_board_is_found_whichever_its_driver_is(tmp_path: Path) -> None:
    (tmp_path / "ttyACM3").touch()
    (tmp_path / "ttyS0").touch()
    assert find_only_port(tmp_path) == str(tmp_path / "ttyACM3")


def test_of_two_boards_none_is_chosen(tmp_path: Path) -> None:
    for name in ("ttyUSB0", "ttyACM0"):
        (tmp_path / name).touch()
    with pytest.raises(UsageError, match=r"which board is it\? There are .*ttyACM0, .*ttyUSB0. Say --port"):
        find_only_port(tmp_path)


def test_where_no_board_is_the_user_is_reported_so(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no board is plugged in"):
        find_only_port(tmp_path)


def test_free_port_may_be_used(tmp_path: Path) -> None:
    pty = Pty(tmp_path)
    try:
        require_free(str(pty.path))
    finally:
        pty.unplug()


def test_port_that_somebody_has_open_is_refused_by_name_and_number(tmp_path: Path) -> None:
    pty = Pty(tmp_path)
    holding = f"import sys; line = open({str(pty.path)!r}, 'rb'); print('open', flush=True); sys.stdin.read()"
    with subprocess.Popen([sys.executable, "-c", holding], stdin=-1, stdout=-1, text=True) as other:
        try:
            assert other.stdout
            assert other.stdout.readline() == "open\n"
            with pytest.raises(FirmwareError, match=rf"in use by \S+ \({other.pid}\). End that first"):
                require_free(str(pty.path))
        finally:
            other.communicate()
            pty.unplug()


@pytest.mark.parametrize("made", [False, True])
def test_what_is_no_port_is_refused(tmp_path: Path, *, made: bool) -> None:
    port = tmp_path / "ttyUSB0"
    if made:
        port.touch()
    with pytest.raises(FirmwareError, match=r"ttyUSB0: is no port. Is the board plugged in"):
        require_free(str(port))


def test_port_that_is_not_the_users_names_the_group(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(FirmwareError, match="usermod -aG dialout"):
        require_free("/dev/null")


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
