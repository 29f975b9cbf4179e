"""Each text is a fault specification or raises a UsageError."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcore.errors import RobotcoreError, UsageError
from robotcore.plugins import fault_names
from robotcore.runtime.faults import Spec
from robotcore.runtime.faults.planning import read_effect
from robotcore.runtime.faults.spec import read_specs
from robotcore.runtime.faults.targets import list_targets
from tests.robotcore.fakes import ROVER
from tests.robotcore.runtime.faults.rigs import TICK_S, build_rig
from tests.texts import CheckText, Raises


@pytest.mark.parametrize(
    "text, canonical",
    [
        ("camera drop=0.2", "camera drop=0.2"),
        ("  camera   drop=.20\tlasts=3.0  after=5e0 ", "camera drop=0.2 after=5 lasts=3"),
        ("range no-echo=0.5", "range no_echo=0.5"),
        ("camera freeze", "camera freeze"),
        ("camera fog=thick", "camera fog=thick"),
        ("loop stall=0.1 every=1_0", "loop stall=0.1 every=10"),
    ],
)
def test_canonical_form_parses_to_the_same_specification(text: str, canonical: str) -> None:
    assert str(Spec.parse(text)) == canonical
    assert Spec.parse(canonical) == Spec.parse(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "camera",
        "camera drop=0.2 after",
        "camera drop= after=5",
        "ca/mera drop=0.2",
        "camera drop=0.2 after=5 after=6",
        "camera drop=0.2\x07",
    ],
)
def test_text_of_another_form_is_refused(text: str, raises: Raises) -> None:
    with raises(UsageError, "fault-form"):
        Spec.parse(text)


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


def test_name_of_a_file_is_replaced_by_its_specifications(file: Path) -> None:
    assert read_specs(["loop stall=0.30", str(file), "camera  freeze"]) == (
        "loop stall=0.3",
        "camera drop=0.2 after=5",
        "right_motor dead after=10 lasts=1.5",
        "camera freeze",
    )


@pytest.mark.parametrize(
    "old, new",
    [
        ('effect = "drop"', ""),
        ("value = 0.20", "value = true"),
        ("value = 0.20", "value = nan"),
        ("lasts = 1.5", 'lasts = ""'),
        (FILE, ""),
        (FILE, "[fault]"),
    ],
)
def test_mistake_in_a_file_is_reported_with_its_place(file: Path, old: str, new: str, check_text: CheckText) -> None:
    file.write_text(FILE.replace(old, new))
    with pytest.raises(UsageError) as raised:
        read_specs([str(file)])
    check_text(raised.value)


NAMES = [device.name for device in ROVER.devices]
EFFECTS = sorted({read_effect(name) for name in fault_names()})
TARGETS = [*list_targets(ROVER, NAMES), "screen", "x"]
VALUES = ["0", "1", "0.5", "0.001", "-1", "1e999", "1e-320", "60", "100000", "nan", "inf", "x", "'", "٣", "\\", "0x1"]
WORDS = st.one_of(st.sampled_from(VALUES), st.text(max_size=8), st.floats().map(str))
KEYS = st.sampled_from(["after", "lasts", "every", "field", "size", "value", "model_config", "on", "x"])


@pytest.mark.slow
@settings(max_examples=400, deadline=None, derandomize=True)
@given(
    st.sampled_from(TARGETS),
    st.sampled_from([*EFFECTS, "noise.camera", "x"]),
    st.one_of(st.just(""), WORDS.map(lambda word: f"={word}")),
    st.lists(st.tuples(KEYS, WORDS), max_size=3),
)
def test_any_text_like_a_specification_runs_on_a_robot_or_is_a_usage_error(
    target: str, effect: str, value: str, rest: list[tuple[str, str]]
) -> None:
    try:
        rig = build_rig(*read_specs([" ".join([target, effect + value, *(f"{key}={word}" for key, word in rest)])]))
    except UsageError:
        return
    for _ in range(3):
        with suppress(RobotcoreError):
            rig.robot.camera.read()
            rig.robot.drive.set_velocity(0.1, 0.0)
            rig.commit()
        rig.sleep(TICK_S)
    rig.robot.close()
    assert rig.wheels == (0.0, 0.0)
