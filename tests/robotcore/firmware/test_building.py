from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import FirmwareError
from robotcore.firmware import avr_gcc
from robotcore.firmware.boards import BOARDS
from robotcore.firmware.building import build
from robotcore.firmware.sketch import copy, shipped
from tests.robotcore.firmware.tools import COMPILES, LISTS_CORE, LISTS_NONE, Tools

UNO = BOARDS["uno"]

needs_avr_gcc = pytest.mark.skipif(not avr_gcc.is_here(), reason=f"needs {avr_gcc.DEBIAN_PACKAGES}")


@needs_avr_gcc
def test_sketch_compiles_without_a_warning(tmp_path: Path) -> None:
    image = avr_gcc.build(shipped(), BOARDS["nano"], tmp_path, flags=["-Wall", "-Wextra", "-Werror"])
    assert image.read_text().startswith(":10000000")
    assert image.with_suffix(".elf").read_bytes()[:4] == b"\x7fELF"


@needs_avr_gcc
def test_fault_of_a_sketch_is_told_as_the_compiler_does_by_the_users_own_file(tmp_path: Path) -> None:
    sketch = copy(tmp_path)
    config = sketch / "config.h"
    config.write_text(config.read_text().replace("#define LEFT_ENABLE_PIN 9 ", "#define LEFT_ENABLE_PIN 3 "))
    with pytest.raises(FirmwareError, match=r"avr-g\+\+ failed") as raised:
        avr_gcc.build(sketch, UNO, tmp_path / "built")
    assert "config.h: LEFT_ENABLE_PIN and RIGHT_ENABLE_PIN are 9 and 10" in str(raised.value)


def test_arduino_cli_is_taken_where_it_has_the_core(tools: Tools, tmp_path: Path) -> None:
    tools.put("arduino-cli", LISTS_CORE + COMPILES)
    (folder := tmp_path / "built").mkdir()
    built = build(shipped(), BOARDS["nano-old"], folder)
    assert (built.tool, built.size_bytes) == ("arduino-cli", 4)
    assert tools.calls == [
        "arduino-cli core list",
        f"arduino-cli compile --fqbn arduino:avr:nano:cpu=atmega328old --output-dir {folder} {shipped()}",
    ]


def test_arduino_cli_without_the_core_names_the_command_that_installs_it(tools: Tools, tmp_path: Path) -> None:
    tools.put("arduino-cli", f"{LISTS_NONE} esac")
    with pytest.raises(FirmwareError, match="arduino-cli core install arduino:avr"):
        build(shipped(), UNO, tmp_path)


def test_where_no_tool_is_there_both_ways_to_one_are_named(tools: Tools, tmp_path: Path) -> None:
    with pytest.raises(FirmwareError, match="nothing here builds for a uno") as raised:
        build(shipped(), UNO, tmp_path)
    assert "sudo apt install gcc-avr arduino-core-avr" in str(raised.value)
    assert "arduino.github.io/arduino-cli" in str(raised.value)


def test_tool_that_fails_is_quoted(tools: Tools, tmp_path: Path) -> None:
    tools.put("arduino-cli", LISTS_CORE + "compile*) echo 'config.h:9: no such pin' >&2; exit 1;; esac")
    with pytest.raises(FirmwareError, match=r"arduino-cli failed \(exit 1\). It said:\nconfig.h:9: no such pin"):
        build(shipped(), UNO, tmp_path)


def test_program_that_is_too_big_for_the_board_is_refused(tools: Tools, tmp_path: Path) -> None:
    record = ":FF000000" + 255 * "00" + "01\\n"
    tools.put("arduino-cli", f'{LISTS_CORE} compile*) printf "{130 * record}" > "$5/$(basename "$6").ino.hex";; esac')
    with pytest.raises(FirmwareError, match="has 33150 bytes, and a uno takes 32256"):
        build(shipped(), UNO, tmp_path)
