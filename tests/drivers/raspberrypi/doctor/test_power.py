from __future__ import annotations

from pathlib import Path

import pytest

from drivers.raspberrypi.doctor.power import COOLER, STRONGER, power
from robotcore.hal.finding import Level


def found(word: str) -> list[tuple[Level, str, str]]:
    told = power(Path("/"), lambda _: f"throttled={word}\n")
    return [(each.level, each.said, each.remedy) for each in told]


def test_a_board_that_was_always_strong_and_cool_is_ok() -> None:
    assert [level for level, _, _ in found("0x0")] == [Level.OK]


@pytest.mark.parametrize(
    "word, level, said, remedy",
    [
        ("0x1", Level.ERROR, "the voltage is low now", STRONGER),
        ("0x50000", Level.WARNING, "at some time since the start: the voltage is low, the chip is throttled", STRONGER),
        ("0x8", Level.WARNING, "the chip is at its soft temperature limit now", COOLER),
        ("0x20000", Level.WARNING, "at some time since the start: the clock is capped", COOLER),
    ],
)
def test_each_bit_is_told_with_its_remedy(word: str, level: Level, said: str, remedy: str) -> None:
    assert found(word) == [(level, said, remedy)]


def test_what_is_now_is_not_told_once_more_as_what_was() -> None:
    assert [said for _, said, _ in found("0x50005")] == ["the voltage is low, the chip is throttled now"]
    assert [level for level, _, _ in found("0xD0001")] == [Level.ERROR, Level.WARNING]


def test_an_answer_that_is_none_is_no_ok() -> None:
    with pytest.raises(ValueError, match="invalid literal"):
        list(power(Path("/"), lambda _: "error=1 error_msg='Command not registered'"))


def test_the_firmwares_own_program_is_asked(tmp_path: Path) -> None:
    program = tmp_path / "usr/bin/vcgencmd"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n[ "$1" = get_throttled ] && echo throttled=0x0\n')
    program.chmod(0o755)
    assert [each.level for each in power(tmp_path)] == [Level.OK]
    program.write_text('#!/bin/sh\necho "VCHI initialization failed" >&2; exit 255\n')
    with pytest.raises(OSError, match="vcgencmd says: VCHI initialization failed"):
        list(power(tmp_path))


def test_a_system_without_the_program_is_not_ok_either(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        list(power(tmp_path))
