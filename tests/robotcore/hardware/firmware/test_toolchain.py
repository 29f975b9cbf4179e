from __future__ import annotations

import re
from pathlib import Path

import pytest

from robotcore.errors import FirmwareError
from robotcore.hardware.firmware import toolchain
from robotcore.hardware.firmware.board import BOARDS, copy_sketch, shipped_sketch
from robotcore.hardware.firmware.toolchain import build
from tests.robotcore.hardware.firmware.tools import COMPILES, LISTS_CORE, LISTS_NONE, Tools
from tests.texts import CheckText, Raises

UNO = BOARDS["uno"]

needs_avr_gcc = pytest.mark.skipif(not toolchain.has_avr_gcc(), reason=f"needs {toolchain.DEBIAN_PACKAGES}")


@pytest.mark.slow
@needs_avr_gcc
def test_sketch_compiles_without_a_warning(tmp_path: Path) -> None:
    image = toolchain.build_with_avr_gcc(
        shipped_sketch(), BOARDS["nano"], tmp_path, flags=["-Wall", "-Wextra", "-Werror"]
    )
    assert image.read_text().startswith(":10000000")
    assert image.with_suffix(".elf").read_bytes()[:4] == b"\x7fELF"


@needs_avr_gcc
def test_mistakes_in_config_h_are_compiler_errors_by_macro(tmp_path: Path, check_text: CheckText) -> None:
    sketch = copy_sketch(tmp_path)
    wrong = {"LEFT_ENABLE_PIN": "3", "LEFT_FORWARD_PIN": "99", "SONAR_ECHO_PIN": "A4", "BATTERY_PIN": "13", "KO": "0"}
    config = (sketch / "config.h").read_text()
    for name, value in wrong.items():
        config = re.sub(rf"(#define {name}) \S+", rf"\1 {value}", config)
    (sketch / "config.h").write_text(config)
    with pytest.raises(FirmwareError) as caught:
        toolchain.build_with_avr_gcc(sketch, UNO, tmp_path / "built")
    assert (caught.value.kind, caught.value.fields["tool"]) == ("tool-failed", "avr-g++")
    check_text("\n".join(sorted(set(re.findall(r"config\.h: [^ \"\n][^\"\n]*", str(caught.value))))))


def test_arduino_cli_builds_if_it_has_the_core(tools: Tools, tmp_path: Path) -> None:
    tools.put("arduino-cli", LISTS_CORE + COMPILES)
    (folder := tmp_path / "built").mkdir()
    built = build(shipped_sketch(), BOARDS["nano-old"], folder)
    assert (built.tool, built.size_bytes) == ("arduino-cli", 4)
    assert tools.calls == [
        "arduino-cli core list",
        f"arduino-cli compile --fqbn arduino:avr:nano:cpu=atmega328old --output-dir {folder} {shipped_sketch()}",
    ]


def test_arduino_cli_without_the_core_names_the_command_that_installs_it(
    tools: Tools, tmp_path: Path, raises: Raises
) -> None:
    tools.put("arduino-cli", f"{LISTS_NONE} esac")
    with raises(FirmwareError, "no-build-tool", board="uno"):
        build(shipped_sketch(), UNO, tmp_path)


def test_without_a_tool_both_installations_are_named(tools: Tools, tmp_path: Path, raises: Raises) -> None:
    with raises(FirmwareError, "no-build-tool", board="uno"):
        build(shipped_sketch(), UNO, tmp_path)


def test_tool_that_fails_is_quoted(tools: Tools, tmp_path: Path, raises: Raises) -> None:
    tools.put("arduino-cli", LISTS_CORE + "compile*) echo 'config.h:9: no such pin' >&2; exit 1;; esac")
    with raises(FirmwareError, "tool-failed", tool="arduino-cli", status=1):
        build(shipped_sketch(), UNO, tmp_path)


def test_program_that_is_too_big_for_the_board_is_refused(tools: Tools, tmp_path: Path, raises: Raises) -> None:
    record = ":FF000000" + 255 * "00" + "01\\n"
    tools.put("arduino-cli", f'{LISTS_CORE} compile*) printf "{130 * record}" > "$5/$(basename "$6").ino.hex";; esac')
    with raises(FirmwareError, "image-too-large", size_bytes=33150, flash_bytes=32256):
        build(shipped_sketch(), UNO, tmp_path)
