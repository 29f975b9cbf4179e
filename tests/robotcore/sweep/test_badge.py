from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree as ET

import pytest

from robotcore import Outcome
from robotcore.sweep import Record
from robotcore.sweep.badge import _BLUE, _GREEN, _RED, MAX_NAME, build_badge_text, draw_badge
from robotcore.sweep.statistics import Requirement, group_records
from tests.robotcore.sweep.conftest import make_record

SVG = "{http://www.w3.org/2000/svg}"


def describe(records: Sequence[Record], *requirements: str, app: str = "my/search.py") -> tuple[str, str, str]:
    return build_badge_text(app, group_records(records), [Requirement.parse(text) for text in requirements])


def make_runs(passing: int, failing: int, world: str = "open", *, is_verified: bool | None = True) -> list[Record]:
    fine = [make_record(seed=seed, world=world, verified=is_verified) for seed in range(passing)]
    verified = None if is_verified is None else False
    outcome = Outcome.FAILURE
    return fine + [make_record(outcome, seed=passing + at, world=world, verified=verified) for at in range(failing)]


@pytest.mark.parametrize(
    "requirements, verdict, colour",
    [
        ([], "", _BLUE),
        (["verified>=0.9"], "passed: ", _GREEN),
        (["verified>=0.9", "success>=0.99"], "failed: ", _RED),
    ],
)
def test_the_colour_and_the_word_are_those_of_the_gate(requirements: list[str], verdict: str, colour: str) -> None:
    assert describe(make_runs(19, 1), *requirements) == (
        "search",
        f"{verdict}95 % of 20 runs verified (76–99 %)",
        colour,
    )


def test_several_groups_show_the_lowest_rate_and_the_gate_of_all() -> None:
    records = [*make_runs(4, 0), *make_runs(1, 3, "arena")]
    assert describe(records, "verified>=0.5") == (
        "search",
        "failed: 25 % of 4 runs verified (5–70 %), lowest of 2 groups",
        _RED,
    )


def test_without_verification_the_badge_counts_the_successes_of_the_app() -> None:
    assert describe(make_runs(3, 1, is_verified=None))[1] == "75 % of 4 runs succeeded (30–95 %)"


@pytest.mark.parametrize(
    "passing, failing, percent", [(299, 1, "99 %"), (1, 299, "1 %"), (3, 0, "100 %"), (0, 3, "0 %")]
)
def test_only_all_runs_are_100_percent_and_only_none_is_0(passing: int, failing: int, percent: str) -> None:
    assert describe(make_runs(passing, failing))[1].startswith(f"{percent} of ")


def test_the_picture_is_svg_that_refers_to_no_other_file_and_holds_any_name() -> None:
    name = "robots/<&>\x1b" + "x" * 100 + ".py"
    content = draw_badge(build_badge_text(name, group_records(make_runs(1, 0)), []))
    root = ET.fromstring(content)  # noqa: S314  written here
    label, message = (each.text or "" for each in root.iter(f"{SVG}text"))
    assert label.startswith(r"<&>\x1bxxx")
    assert label.endswith("x…")
    assert len(label) == MAX_NAME + len(r"\x1b") - 1
    assert message == "100 % of 1 run verified (21–100 %)"
    assert root.attrib["aria-label"] == f"{label}: {message}"
    assert content.count(b"http") == 1, "the name of SVG itself"
    assert b"href" not in content


def test_the_texts_lie_within_their_boxes() -> None:
    root = ET.fromstring(draw_badge(build_badge_text("search", group_records(make_runs(9, 1)), [])))  # noqa: S314  the same
    boxes = list(root.iter(f"{SVG}rect"))[1:]
    for box, text in zip(boxes, root.iter(f"{SVG}text"), strict=True):
        left, right = float(box.attrib["x"]), float(box.attrib["x"]) + float(box.attrib["width"])
        begin = float(text.attrib["x"])
        assert left < begin < begin + float(text.attrib["textLength"]) < right
