from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import DescriptionError, UsageError
from robotcore.runtime.faults.spec import specs_in

FILE = """
[[fault]]
target = "camera"
effect = "drop"
value = 0.20
after = 5

[[fault]]
target = "right_motor"
effect = "dead"
lasts = 1.5
after = 10.0
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "faults.toml"
    file.write_text(FILE)
    return file


def test_a_file_stands_for_what_is_in_it_among_the_others(file: Path) -> None:
    assert specs_in(["loop stall=0.30", str(file), "camera  freeze"]) == (
        "loop stall=0.3",
        "camera drop=0.2 after=5",
        "right_motor dead after=10 lasts=1.5",
        "camera freeze",
    )


@pytest.mark.parametrize(
    "old, new, told",
    [
        ('effect = "drop"', "", "fault[#1].effect: is missing. Add it"),
        ('"camera"', "3", "fault[#1]: '3.0 drop=0.2 after=5.0': '3.0' is no name. Write TARGET"),
        ("value = 0.20", "value = true", "fault[#1].value: is neither a number nor a word. Write a number, or"),
        ("value = 0.20", "value = nan", "fault[#1].value: is neither a number nor a word. Write a number, or"),
        ("lasts = 1.5", "lasts = [1.5]", "fault[#2].lasts: is neither a number nor a word"),
        ("lasts = 1.5", 'lasts = ""', "fault[#2]: 'right_motor dead lasts= after=10.0': 'lasts=' has no value. Write"),
        ("[[fault]]", "[[faults]]", "faults: is unknown. Correct it or take it out. Did you mean 'fault'?"),
        (FILE, "", "fault: is missing. Add it"),
        (FILE, "fault = []", "fault: should be one or more tables: [[fault]], got a list of 0. Correct it"),
        (FILE, "[fault]", "fault: should be one or more tables: [[fault]], got a table. Correct it"),
        (FILE, "[[fault]", "it is not TOML"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_one_line_with_its_place(
    file: Path, old: str, new: str, told: str
) -> None:
    assert old in FILE
    file.write_text(FILE.replace(old, new))
    with pytest.raises(UsageError) as raised:
        specs_in([str(file)])
    assert str(raised.value).startswith(f"{file}: {told}")
    assert "\n" not in str(raised.value)


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"gone.toml: No such file"):
        specs_in([str(tmp_path / "gone.toml")])


def test_a_file_that_is_no_text_is_told(file: Path) -> None:
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(DescriptionError, match="it is not text"):
        specs_in([str(file)])
