from __future__ import annotations

import re
from base64 import b64decode
from collections.abc import Sequence
from dataclasses import replace
from html import unescape
from pathlib import Path

import cv2
import numpy as np
import pytest

from robotcore.errors import BackendMissingError
from robotcore.runtime.result import Outcome
from robotcore.sweep.record import Record
from robotcore.sweep.report import write_report
from robotcore.sweep.report.failures import MAX_DETAILED, MAX_LISTED
from robotcore.sweep.statistics import Requirement
from tests.robotcore.sweep.report.samples import Page, make_fail, make_many, make_pass
from tests.texts import CheckText, Raises


def write_page(
    records: Sequence[Record], folder: Path, command: str = "", require: Sequence[str] = ()
) -> tuple[Page, str]:
    requirements = [Requirement.parse(text) for text in require]
    file = write_report(records, folder / "report", folder, command=command, requirements=requirements)
    html = file.read_text(encoding="utf-8")
    return Page(html), html


def write_noise(file: Path) -> None:
    """Write the picture of a noisy camera."""
    cv2.imwrite(str(file), np.random.default_rng(1).integers(100, 120, (500, 800, 3)).astype(np.uint8))


def make_records(folder: Path) -> list[Record]:
    """Return runs of two backends and two worlds, ten of them failing with a picture."""
    write_noise(folder / "7.png")
    return [
        *(make_pass(seed=seed, conditions={"light": 1.0}) for seed in range(20)),
        *(make_fail(seed=seed, conditions={"light": 0.1}, picture="7.png") for seed in range(20, 30)),
        *(make_pass(seed=seed, backend="pybullet") for seed in range(25)),
        make_pass(world="clutter", seed=None, contacts=2),
    ]


def test_the_page_is_well_formed_and_needs_no_other_file(tmp_path: Path, check_text: CheckText) -> None:
    page, html = write_page(make_records(tmp_path), tmp_path, command="robotcore sweep green-search --seeds 0-29")
    assert page.mistakes == []
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'" in page.values("meta", "content")
    assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags)
    assert all(source.startswith("data:image/jpeg;base64,") for source in page.values("img", "src"))
    assert not {name for _, name, _ in page.attributes} & {"href", "srcset", "xlink:href"}
    assert not any(word in html for word in ("http://", "https://", "url(", "@import"))
    assert "robotcore sweep green-search --seeds 0-29" in page.words
    check_text("\n".join([get_verdict(page), page.section("Results"), page.section("Why runs fail")]))


def test_each_drawing_has_a_description_and_each_failing_run_a_small_picture(
    tmp_path: Path, check_text: CheckText
) -> None:
    page, _ = write_page(make_records(tmp_path), tmp_path)
    labels = page.values("svg", "aria-label")
    assert len(labels) == len(page.values("svg", "role"))
    check_text("\n".join(labels))
    pictures = [b64decode(source.partition(",")[2]) for source in page.values("img", "src")]
    shown = np.asarray(cv2.imdecode(np.frombuffer(pictures[0], np.uint8), cv2.IMREAD_COLOR))
    assert (len(pictures), shown.shape) == (10, (300, 480, 3))
    assert shown.mean() == pytest.approx(109.5, abs=1)
    assert len(pictures[0]) < (tmp_path / "7.png").stat().st_size / 10
    assert "arena · kinematic · seed 20" in page.values("img", "alt")[0]


def test_a_text_of_an_app_is_escaped(tmp_path: Path) -> None:
    evil = '<script>alert(1)</script> & "more" \'</style>'
    result = make_fail(reason=evil, world=evil, app=evil, milestones={evil: 1.0}, conditions={evil: evil}).result
    records = [
        Record(replace(result, seed=seed, outcome=outcome), ((0, 0, 0),), f"robotcore run '{evil}'")
        for seed, outcome in enumerate((Outcome.FAILURE, Outcome.ERROR) * 8)
    ]
    page, _ = write_page(records, tmp_path, command=evil)
    assert page.mistakes == []
    assert "script" not in page.tags
    assert page.words.count(evil) > 8


def get_verdict(page: Page) -> str:
    """Return the head of the page without its facts."""
    return page.section("").split("\nJudge")[0]


@pytest.mark.parametrize(
    "judge, verified, shown",
    [(None, True, "the app itself"), (None, None, "none"), ("strict.py", False, "strict.py")],
)
def test_the_head_has_the_judge_seeds_as_ranges_times_in_hours_and_no_empty_fact(
    judge: str | None, verified: bool | None, shown: str, tmp_path: Path
) -> None:
    seeds = (3, 1, 2, 9, 7, 8)
    runs = [make_pass(seed=seed, sim_time_s=610.2, world=None, verified=verified, judge=judge) for seed in seeds]
    head = write_page(runs, tmp_path)[0].section("")
    assert all(fact in head for fact in (f"Judge{shown}", "Seeds1-3,7-9", "Robot's time1 h 1 min 1 s"))
    assert "Worlds" not in head


def test_a_failing_run_has_cause_conditions_and_a_command_that_can_be_copied(
    tmp_path: Path, check_text: CheckText
) -> None:
    command = "robotcore run 'my  app.py' --world \"lab\" --set a=--b --timeout 20"
    record = make_fail(seed=3, contacts=2, distance_to_target_m=1.234, conditions={"light": 0.51234})
    page, html = write_page([replace(record, command=command)], tmp_path)
    check_text(page.section("Failing runs"))
    (code,) = re.findall("<code>(.*?)</code>", html)
    assert unescape(re.sub("</?span>", "", code)) == command
    assert ("details", "open", "") in page.attributes


def test_backends_that_differ_have_a_table(tmp_path: Path, check_text: CheckText) -> None:
    records = [
        make_pass(seed=1),
        make_pass(seed=2, verified=False),
        make_pass(seed=1, backend="pybullet"),
        make_fail(seed=2, backend="pybullet"),
    ]
    page, _ = write_page(records, tmp_path)
    check_text(page.section("Do the backends agree?"))


@pytest.mark.parametrize("is_empty", [False, True])
def test_runs_without_a_world_a_seed_or_a_verdict_and_no_runs_have_a_page(
    is_empty: bool, tmp_path: Path, check_text: CheckText
) -> None:
    unknown = dict.fromkeys(("world", "seed", "verified", "contacts", "path"))
    records = [make(**unknown, backend="raspberrypi", milestones={}) for make in (make_pass, make_fail)]
    page, _ = write_page([] if is_empty else records, tmp_path)
    assert page.mistakes == []
    check_text(re.split("(?i)\nrobot", get_verdict(page))[0])


def test_a_damaged_or_missing_picture_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "half.png").write_bytes(b"\x89PNG\r\n")
    (tmp_path / "empty.png").touch()
    page, _ = write_page([make_fail(picture=name) for name in ("half.png", "empty.png", "gone.png")], tmp_path)
    assert "img" not in page.tags


def test_each_requirement_has_the_value_of_each_group(tmp_path: Path, check_text: CheckText) -> None:
    all_met, _ = write_page([make_pass()], tmp_path, require=["verified>=0.97"])
    records = [make_pass(), make_fail(), make_pass(world="open")]
    page, _ = write_page(records, tmp_path, require=["verified>=0.97", "contacts<=0"])
    check_text("\n".join([get_verdict(all_met), get_verdict(page), page.section("Requirements")]))


def test_a_condition_with_a_significant_split_of_its_group_comes_first(tmp_path: Path) -> None:
    drawn = [(make, light) for make, light in ((make_fail, 0.0), (make_pass, 1.0)) for _ in range(9)]
    records = [make(seed=at, conditions={"floor": "wood", "light": light}) for at, (make, light) in enumerate(drawn)]
    page, _ = write_page([*records, make_fail(backend="pybullet", conditions={"light": 0.5})], tmp_path)
    words = " ".join(page.words.split())
    assert words.count(" light0light < 0.5 floorwood") == 9
    assert "ConditionValue light0.5 " in words


@pytest.mark.slow
def test_the_page_of_a_big_sweep_has_less_than_4_mb(tmp_path: Path) -> None:
    write_noise(tmp_path / "a.png")
    conditions = {f"condition_{index}": index / 7 for index in range(33)}
    records = [replace(record, picture="a.png") for record in make_many(3000, failing=1200, conditions=conditions)]
    page, html = write_page(records, tmp_path)
    assert page.tags.count("img") == MAX_DETAILED
    assert len(set(re.findall(r"robotcore run green-search --seed \d+", page.words))) == MAX_DETAILED + MAX_LISTED
    assert "arena · kinematic 100 of 1200 runs" in page.words
    assert "100 more failing runs are not shown" in page.words
    assert "passing runs: 100 of 1800, failing: 100 of 1200" in page.words
    assert len(html) < 4_000_000


def test_failing_runs_are_sorted_and_many_are_folded(tmp_path: Path) -> None:
    seeds = range(1, 10)
    page, html = write_page([make_fail(seed=seed, backend=name) for seed in seeds[::-1] for name in "ba"], tmp_path)
    assert re.findall("<h4>(.*)</h4>", html) == [f"arena · {name} · seed {seed}" for name in "ab" for seed in seeds]
    assert ("details", "open", "") not in page.attributes


def test_a_missing_library_is_reported_with_its_extra(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    monkeypatch.setattr("robotcore.extras.find_spec", lambda _: None)
    with raises(BackendMissingError, "library-missing", extra="sweep", modules=["jinja2"]):
        write_page([make_pass()], tmp_path)
