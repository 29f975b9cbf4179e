from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import FirmwareError
from robotcore.hardware.firmware.board import shipped_sketch
from robotcore.hardware.firmware.toolchain import build
from tests.robotcore.hardware.firmware.tools import COMPILES, LISTS_CORE, LISTS_NONE, Tools
from tests.texts import Raises


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Tools:
    return Tools(tmp_path, monkeypatch)


def test_arduino_cli_builds_with_the_name_of_the_board(tools: Tools, tmp_path: Path) -> None:
    tools.put("arduino-cli", LISTS_CORE + COMPILES)
    image, output = build(shipped_sketch(), "nano-old", folder := tmp_path / "built")
    assert (image, output) == (folder / "robotcore_bridge.ino.hex", "Sketch uses 4 bytes.\n")
    assert image.is_file()
    assert tools.calls == [
        "arduino-cli core list",
        f"arduino-cli compile --fqbn arduino:avr:nano:cpu=atmega328old --output-dir {folder} {shipped_sketch()}",
    ]


@pytest.mark.parametrize("arduino_cli", [None, f"{LISTS_NONE} esac"], ids=["no-arduino-cli", "no-core"])
def test_a_missing_tool_is_reported_with_the_way_to_install_it(
    tools: Tools, tmp_path: Path, raises: Raises, arduino_cli: str | None
) -> None:
    if arduino_cli:
        tools.put("arduino-cli", arduino_cli)
    with raises(FirmwareError, "no-build-tool", board="uno"):
        build(shipped_sketch(), "uno", tmp_path)


def test_tool_that_fails_is_quoted(tools: Tools, tmp_path: Path, raises: Raises) -> None:
    tools.put("arduino-cli", LISTS_CORE + "compile*) echo 'config.h:9: no such pin' >&2; exit 1;; esac")
    with raises(FirmwareError, "tool-failed", tool="arduino-cli", status=1):
        build(shipped_sketch(), "uno", tmp_path)
