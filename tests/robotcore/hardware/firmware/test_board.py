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
from robotcore.processes import describe_process
from tests.doubles.serial.pty import Pty
from tests.texts import Raises


def test_only_a_single_board_is_found(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "ttyS0").touch()
    with raises(UsageError, "no-board"):
        find_only_port(tmp_path)
    (tmp_path / "ttyACM3").touch()
    assert find_only_port(tmp_path) == str(tmp_path / "ttyACM3")
    (tmp_path / "ttyUSB0").touch()
    with raises(UsageError, "port-ambiguous"):
        find_only_port(tmp_path)


def test_port_is_refused_only_if_another_process_holds_it(tmp_path: Path, raises: Raises) -> None:
    with Pty(tmp_path) as pty:
        require_free(str(pty.path))
        holding = f"import sys; line = open({str(pty.path)!r}, 'rb'); print('open', flush=True); sys.stdin.read()"
        with subprocess.Popen([sys.executable, "-c", holding], stdin=-1, stdout=-1, text=True) as other:
            assert other.stdout
            assert other.stdout.readline() == "open\n"
            holder = describe_process(other.pid)
            with raises(FirmwareError, "port-in-use", port=str(pty.path), holders=holder, hide=[holder]):
                require_free(str(pty.path))
            other.communicate()


@pytest.mark.parametrize("made", [False, True])
def test_file_that_is_no_port_is_refused(tmp_path: Path, raises: Raises, *, made: bool) -> None:
    port = tmp_path / "ttyUSB0"
    if made:
        port.touch()
    with raises(FirmwareError, "port-missing", port=str(port)):
        require_free(str(port))


def test_port_that_is_not_the_users_names_the_group(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)
    with raises(FirmwareError, "port-permission", port="/dev/null"):
        require_free("/dev/null")


def test_copy_is_the_whole_sketch_and_is_found_by_either_folder(tmp_path: Path) -> None:
    sketch = copy_sketch(tmp_path)
    assert sorted(file.name for file in sketch.iterdir()) == sorted(file.name for file in shipped_sketch().iterdir())
    assert find_sketch(tmp_path) == find_sketch(sketch) == sketch


def test_copy_never_writes_over_one_that_was_edited(tmp_path: Path, raises: Raises) -> None:
    (copy_sketch(tmp_path) / "config.h").write_text("mine")
    with raises(UsageError, "sketch-exists"):
        copy_sketch(tmp_path)
    assert (find_sketch(tmp_path) / "config.h").read_text() == "mine"


def test_folder_without_a_sketch_is_refused(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "sketch-missing", folder=str(tmp_path)):
        find_sketch(tmp_path)


def test_folder_that_cannot_be_written_is_named(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "file").touch()
    with raises(UsageError, "folder-not-writable"):
        copy_sketch(tmp_path / "file")


def test_baud_is_read_from_the_sketch(tmp_path: Path) -> None:
    assert read_baud(shipped_sketch()) == 57600
    config = copy_sketch(tmp_path) / "config.h"
    config.write_text(config.read_text().replace("#define BAUD 57600", "#define BAUD 115200"))
    assert read_baud(find_sketch(tmp_path)) == 115200
    config.unlink()
    assert read_baud(find_sketch(tmp_path)) == 57600
