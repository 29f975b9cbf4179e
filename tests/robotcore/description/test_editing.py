"""Changes in a robot's file: what is kept, what is refused, and what is written."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from robotcore.description import load_robot, read_shipped, robot_names
from robotcore.description.editing import RobotEditor
from robotcore.description.loading import read_toml
from robotcore.errors import DescriptionError, UsageError
from tests.texts import Raises

BODY = """\
name = "own"  # the name

[body]
length_m = 0.2
width_m = 0.2
height_m = 0.1
clearance_m = 0.02
mass_kg = 1.0

[raspberrypi.left]  # before the drive
driver = "h-bridge"
forward = 17
backward = 27
model = {dead_band = 0.10, forward_rad_s = 14.0, backward_rad_s = 14.0} # by hand

[drive]
left = "left"
right = "right"
track_m   =   0.150   # measured with a ruler
wheel_radius_m = 0.03
wheel_width_m = 0.02
wheel_mass_kg = 0.05

# The motors.
[[devices]]
kind = "motor"
name = "left"
max_velocity_rad_s = 12.0

[[devices]]
kind = "motor"
name = "right"
max_velocity_rad_s = 12.0
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "own.toml"
    file.write_text(BODY, encoding="utf-8")
    return file


@pytest.mark.parametrize("name", robot_names())
def test_an_editor_without_a_change_returns_the_text_of_each_shipped_robot(name: str, tmp_path: Path) -> None:
    file = tmp_path / "copy.toml"
    file.write_text(read_shipped(name), encoding="utf-8")
    editor = RobotEditor(str(file))
    assert (editor.text, editor.diff, editor.has_changed) == (read_shipped(name), "", False)


@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_each_number_of_each_shipped_robot_can_be_changed_alone(name: str, tmp_path: Path) -> None:
    file = tmp_path / "copy.toml"
    file.write_text(read_shipped(name), encoding="utf-8")
    content = read_toml(name, file.read_bytes())
    for device in content["devices"]:
        for key in [key for key, value in device.items() if isinstance(value, float)]:
            editor = RobotEditor(str(file))
            editor.set_device(device["name"], **{key: 0.123456})
            lines = [line for line in editor.diff.splitlines()[2:] if line[0] in "+-"]
            assert len(lines) == 2, editor.diff
            assert lines[1].startswith(f"+{key} = 0.123456")


def test_a_change_keeps_comments_order_and_format(file: Path) -> None:
    editor = RobotEditor(str(file))
    editor.set_drive(track_m=0.148)
    editor.set_device("right", lag_s=0.07)
    editor.set_section("raspberrypi", "left", model={"dead_band": 0.13, "max_duty": 0.9}, frequency_hz=200)
    editor.write()
    expected = (
        BODY.replace("track_m   =   0.150   #", "track_m   =   0.148   #")
        .replace("dead_band = 0.10,", "dead_band = 0.13,")
        .replace("14.0} # by hand\n", "14.0, max_duty = 0.9 } # by hand\nfrequency_hz = 200\n")
    )
    written = file.read_text(encoding="utf-8").replace("14.0,max", "14.0, max")  # as some versions of tomlkit write it
    assert written == expected + "lag_s = 0.07\n"
    assert load_robot(str(file)).all_of("motor")[1].lag_s == 0.07


def test_an_equal_value_keeps_its_digits(file: Path) -> None:
    editor = RobotEditor(str(file))
    editor.set_drive(track_m=0.15)
    editor.set_section("raspberrypi", "left", model={"dead_band": 0.1})
    assert not editor.has_changed


def test_the_diff_is_a_unified_diff_of_the_file(file: Path) -> None:
    editor = RobotEditor(str(file))
    editor.set_drive(wheel_radius_m=0.031)
    assert editor.diff.splitlines() == [
        f"--- {file}",
        f"+++ {file} (new)",
        "@@ -17,7 +17,7 @@",
        ' left = "left"',
        ' right = "right"',
        " track_m   =   0.150   # measured with a ruler",
        "-wheel_radius_m = 0.03",
        "+wheel_radius_m = 0.031",
        " wheel_width_m = 0.02",
        " wheel_mass_kg = 0.05",
        " ",
    ]
    assert file.read_text(encoding="utf-8") == BODY


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_line_ends_of_windows_and_a_byte_order_mark_are_kept(file: Path, mark: bytes) -> None:
    file.write_bytes(mark + BODY.replace("\n", "\r\n").encode())
    editor = RobotEditor(str(file))
    editor.set_drive(max_acceleration_rad_s2=40.0)
    editor.write()
    added = BODY.replace("mass_kg = 0.05\n", "mass_kg = 0.05\nmax_acceleration_rad_s2 = 40.0\n")
    assert file.read_bytes() == mark + added.replace("\n", "\r\n").encode()


def test_a_shipped_robot_is_not_changed(raises: Raises) -> None:
    with raises(UsageError, "shipped-robot", robot="freenove-4wd"):
        RobotEditor("freenove-4wd")


@pytest.mark.parametrize(
    "method, names",
    [("set_device", ("middle",)), ("set_section", ("raspberrypi", "right")), ("set_section", ("serial", "left"))],
)
def test_a_missing_table_is_an_error(method: str, names: tuple[str, ...], file: Path, raises: Raises) -> None:
    editor = RobotEditor(str(file))
    with raises(UsageError, "no-such-table", file=str(file)):
        getattr(editor, method)(*names, lag_s=0.1)


def test_an_invalid_value_is_not_written(file: Path, raises: Raises) -> None:
    editor = RobotEditor(str(file))
    editor.set_device("left", lag_s=-1.0)
    with raises(DescriptionError, "out-of-bounds"):
        editor.write()
    assert file.read_text(encoding="utf-8") == BODY


def test_a_description_that_the_check_refuses_is_not_written(file: Path) -> None:
    def refuse(robot: Any) -> None:
        assert robot.drive.track_m == 0.14
        raise DescriptionError(str(file), "raspberrypi", "is wrong", "Correct it")

    editor = RobotEditor(str(file))
    editor.set_drive(track_m=0.14)
    with pytest.raises(DescriptionError):
        editor.write(refuse)
    assert file.read_text(encoding="utf-8") == BODY


def test_a_file_that_another_program_has_changed_is_not_overwritten(file: Path, raises: Raises) -> None:
    editor = RobotEditor(str(file))
    editor.set_drive(track_m=0.14)
    file.write_text(BODY + "\n", encoding="utf-8")
    with raises(UsageError, "file-changed", file=str(file)):
        editor.write()
    assert file.read_text(encoding="utf-8") == BODY + "\n"


def test_a_file_that_cannot_be_written_is_an_error(file: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    editor = RobotEditor(str(file))
    editor.set_drive(track_m=0.14)
    with raises(UsageError, "unwritable-file", file=str(file)):
        editor.write()
    assert list(file.parent.iterdir()) == [file]


def test_a_link_is_refused_with_its_target(file: Path, tmp_path: Path, raises: Raises) -> None:
    link = tmp_path / "link.toml"
    link.symlink_to(file.name)
    editor = RobotEditor(str(link))
    editor.set_drive(track_m=0.14)
    with raises(UsageError, "linked-file", file=str(link), target=str(file.resolve())):
        editor.require_writable()
    with raises(UsageError, "linked-file"):
        editor.write()
    assert link.is_symlink()


def test_a_table_is_replaced_and_equal_values_keep_their_format(file: Path) -> None:
    editor = RobotEditor(str(file))
    model = {"dead_band": 0.1, "forward_rad_s": 14.0, "backward_rad_s": 14.0}
    editor.replace_section("raspberrypi", "left", {"driver": "phase-enable", "phase": 5, "model": model})
    editor.write()
    assert load_robot(str(file)).backends["raspberrypi"]["left"]["driver"] == "phase-enable"
    text = file.read_text(encoding="utf-8")
    assert "backward = 27" not in text
    assert "model = {dead_band = 0.10," in text


def edit_lines(file: Path, content: bytes) -> list[bytes]:
    """Write a file, change a value, add a key within the file and one at its end, and return the lines."""
    file.write_bytes(content)
    editor = RobotEditor(str(file))
    editor.set_drive(track_m=0.148)
    editor.set_section("raspberrypi", "left", frequency_hz=200)
    editor.set_device("right", lag_s=0.07)
    assert [line for line in editor.diff.splitlines()[2:] if line.startswith("+")] == [
        "+frequency_hz = 200", "+track_m   =   0.148   # measured with a ruler", "+lag_s = 0.07",
    ]  # fmt: skip
    editor.write()
    return file.read_bytes().splitlines(keepends=True)


@pytest.mark.parametrize("ending", [b"\n", b"\r\n"])
def test_new_lines_end_as_the_other_lines_of_the_file(ending: bytes, file: Path) -> None:
    lines = edit_lines(file, BODY.encode().replace(b"\n", ending))
    assert len(lines) == BODY.count("\n") + 2
    assert all(line.endswith(ending) and line.count(b"\r") == ending.count(b"\r") for line in lines)


def test_each_line_of_a_file_with_mixed_endings_keeps_its_own(file: Path) -> None:
    before = [line.encode() + (b"\r\n" if number % 3 else b"\n") for number, line in enumerate(BODY.splitlines())]
    lines = edit_lines(file, b"".join(before))
    expected = [line.replace(b"0.150", b"0.148") for line in before]
    model = next(number for number, line in enumerate(before) if line.startswith(b"model"))
    endings = [b"\r\n" if before[number].endswith(b"\r\n") else b"\n" for number in (model, -1)]
    expected.insert(model + 1, b"frequency_hz = 200" + endings[0])
    assert lines == [*expected, b"lag_s = 0.07" + endings[1]]


def test_a_line_behind_a_last_line_without_an_ending_adds_no_other_ending(file: Path) -> None:
    file.write_bytes(BODY.rstrip("\n").encode().replace(b"\n", b"\r\n"))
    editor = RobotEditor(str(file))
    editor.set_device("right", lag_s=0.07)
    editor.write()
    lines = file.read_bytes().splitlines(keepends=True)
    assert lines[-2] == b"max_velocity_rad_s = 12.0\r\n"
    assert lines[-1].rstrip() == b"lag_s = 0.07"
    assert all(line.endswith(b"\r\n") for line in lines[:-1])
