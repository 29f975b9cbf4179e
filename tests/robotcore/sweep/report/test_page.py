from __future__ import annotations

import re
import subprocess
import sys
from base64 import b64decode
from collections.abc import Sequence
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from robotcore.errors import BackendMissingError, UsageError
from robotcore.runtime.result import Outcome
from robotcore.sweep import report
from robotcore.sweep.record import Record
from robotcore.sweep.report import write_report
from robotcore.sweep.report.failures import MAX_DETAILED, MAX_LISTED
from robotcore.sweep.report.page import MAX_OPEN
from robotcore.sweep.statistics import Requirement, group_records
from robotcore.sweep.tables import COLUMNS
from tests.robotcore.sweep.report.samples import Page, failed, many, passed
from tests.texts import Raises


def written(
    records: Sequence[Record], folder: Path, command: str = "", require: Sequence[str] = ()
) -> tuple[Page, str]:
    requirements = [Requirement.parse(text) for text in require]
    file = write_report(records, folder / "report", folder, command=command, requirements=requirements)
    html = file.read_text(encoding="utf-8")
    return Page(html), html


def write_noise(file: Path) -> None:
    """Write such a picture as a noisy camera leaves."""
    cv2.imwrite(str(file), np.random.default_rng(1).integers(100, 120, (500, 800, 3)).astype(np.uint8))


def a_bit_of_all(folder: Path) -> list[Record]:
    write_noise(folder / "7.png")
    return [
        *(passed(seed=seed, conditions={"light": 1.0}) for seed in range(20)),
        *(failed(seed=seed, conditions={"light": 0.1}, picture="7.png") for seed in range(20, 30)),
        *(passed(seed=seed, backend="pybullet") for seed in range(25)),
        passed(world="clutter", seed=None, contacts=2),
    ]


def test_every_tag_closes(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path)
    assert page.faults == []


def test_the_page_needs_nothing_else(tmp_path: Path) -> None:
    page, html = written(a_bit_of_all(tmp_path), tmp_path)
    assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags)
    assert all(source.startswith("data:image/jpeg;base64,") for source in page.values("img", "src"))
    assert not {name for _, name, _ in page.attributes} & {"href", "srcset", "xlink:href"}
    assert not any(word in html for word in ("http://", "https://", "url(", "@import"))


def test_a_browser_is_reported_to_fetch_nothing(tmp_path: Path) -> None:
    page, _ = written([passed()], tmp_path)
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'" in page.values("meta", "content")


def test_the_picture_of_every_failing_run_is_in_it_small(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path)
    pictures = [b64decode(source.partition(",")[2]) for source in page.values("img", "src")]
    shown = np.asarray(cv2.imdecode(np.frombuffer(pictures[0], np.uint8), cv2.IMREAD_COLOR))
    assert len(pictures) == 10
    assert shown.shape == (300, 480, 3)
    assert shown.mean() == pytest.approx(109.5, abs=1)
    assert len(pictures[0]) < (tmp_path / "7.png").stat().st_size / 10
    assert "arena · kinematic · seed 20" in page.values("img", "alt")[0]


def test_all_that_is_drawn_has_words_too(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path)
    drawings = page.values("svg", "role")
    labels = page.values("svg", "aria-label")
    assert len(drawings) == len(labels) == 6  # success, arrivals, milestones, two maps, a condition
    assert labels[0] == "Verified runs: arena · kinematic 20/30, arena · pybullet 25/25, clutter · kinematic 1/1"
    assert all(labels)


def test_what_an_app_says_is_no_markup(tmp_path: Path) -> None:
    evil = '<script>alert(1)</script> & "more" \'</style>'
    result = failed(reason=evil, world=evil, app=evil, milestones={evil: 1.0}, conditions={evil: evil}).result
    records = [
        Record(replace(result, seed=seed, outcome=outcome), ((0, 0, 0),), f"robotcore run '{evil}'")
        for seed, outcome in enumerate((Outcome.FAILURE, Outcome.ERROR) * 8)
    ]
    page, _ = written(records, tmp_path, command=evil)
    assert page.faults == []
    assert "script" not in page.tags
    assert page.words.count(evil) > 8


def test_the_page_tells_what_was_asked_and_what_came_of_it(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path, command="robotcore sweep green-search --seeds 0-29")
    assert "45 of 56 runs passed; the others: 10 timeout, 1 contact." in page.words
    assert "robotcore sweep green-search --seeds 0-29" in page.words
    assert "48.8–80.8" in page.words
    assert "fails more in arena on kinematic where light < 0.6: 10 of 10, elsewhere 0 of 20" in page.words


def test_a_failing_run_tells_cause_conditions_and_command(tmp_path: Path) -> None:
    page, _ = written([failed(seed=3, contacts=2, distance_to_target_m=1.234, conditions={"light": 0.51234})], tmp_path)
    assert "timeout, not done after 20 s, 2 contacts" in page.words
    assert "got as far as search, at 0.0 s, ended 1.23 m from the target" in page.words
    assert "light0.5123" in page.words
    assert "robotcore run green-search --seed 3" in page.words


def test_a_success_that_the_simulator_denies_says_so(tmp_path: Path) -> None:
    page, _ = written([passed(verified=False)], tmp_path)
    assert "success, the simulator does not agree" in page.words
    assert "1 not verified" in page.words


@pytest.mark.parametrize(
    "judge, verified, shown",
    [(None, True, "the app itself"), (None, None, "nobody"), ("strict.py", False, "strict.py")],
)
def test_the_head_says_who_judged(judge: str | None, verified: bool | None, shown: str, tmp_path: Path) -> None:
    file = write_report([passed(verified=verified, judge=judge)], tmp_path / "report", tmp_path)
    page = Page(file.read_text(encoding="utf-8"))
    assert f"Judge{shown}" in page.words
    assert page.words.count("success, the judge does not agree") == (2 if verified is False else 0)


def test_backends_that_differ_are_reported_apart(tmp_path: Path) -> None:
    records = [passed(seed=1), passed(seed=2), passed(seed=1, backend="pybullet"), failed(seed=2, backend="pybullet")]
    page, _ = written(records, tmp_path)
    assert "Where kinematic and pybullet differ: 1 of 2" in page.words
    assert "search → seen → arrived" in page.words


def test_no_runs_make_a_page_that_says_so(tmp_path: Path) -> None:
    page, _ = written([], tmp_path)
    assert page.faults == []
    assert "No runs yet." in page.words


def test_runs_of_a_robot_that_nobody_can_judge_are_reported(tmp_path: Path) -> None:
    unknown: dict[str, Any] = {
        "backend": "raspberrypi",
        "world": None,
        "seed": None,
        "verified": None,
        "contacts": None,
        "path": None,
    }
    page, _ = written([passed(**unknown, milestones={}), failed(**unknown, milestones={})], tmp_path)
    assert page.faults == []
    assert "1 of them passed by the app's own word" in page.words
    assert "?/2" in page.words


def test_a_picture_that_is_gone_is_left_out(tmp_path: Path) -> None:
    page, _ = written([failed(picture="gone.png")], tmp_path)
    assert "img" not in page.tags
    assert "robotcore run green-search --seed 7" in page.words


def test_a_picture_that_is_spoilt_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "half.png").write_bytes(b"\x89PNG\r\n")
    (tmp_path / "empty.png").touch()
    page, _ = written([failed(picture=name) for name in ("half.png", "empty.png")], tmp_path)
    assert "img" not in page.tags


def test_what_a_group_reached_is_reported_in_the_words_of_the_terminal(tmp_path: Path) -> None:
    records = [passed(), failed(contacts=None, verified=None)]
    page, _ = written(records, tmp_path)
    (group,) = group_records(records)
    assert "".join(format_column(group) for format_column in COLUMNS.values()) in page.words.replace("\n", "")


def test_requirements_are_reported_with_what_was_got(tmp_path: Path) -> None:
    records = [passed(), failed(), passed(world="open")]
    page, html = written(records, tmp_path, require=["verified>=0.97", "contacts<=0"])
    assert "Requirements: 1 of 4 missed" in page.words
    assert page.words.count("✗ missed: 0.5") == 1
    assert page.words.count("✓ kept: ") == 3
    assert "2 of 3 runs passed, requirements missed</title>" in html


def test_requirements_that_are_all_kept_are_reported_so(tmp_path: Path) -> None:
    page, html = written([passed()], tmp_path, require=["verified>=0.97"])
    assert "Requirements: all kept." in page.words
    assert "1 of 1 runs passed</title>" in html


def test_no_requirement_is_reported_where_there_was_none(tmp_path: Path) -> None:
    page, _ = written([failed()], tmp_path)
    assert "Requirements" not in page.words


def test_a_condition_that_was_found_to_matter_comes_first(tmp_path: Path) -> None:
    drawn = [(make, light) for make, light in ((failed, 0.0), (passed, 1.0)) for _ in range(9)]
    records = [make(seed=at, conditions={"floor": "wood", "light": light}) for at, (make, light) in enumerate(drawn)]
    page, _ = written(records, tmp_path)
    words = " ".join(page.words.split())
    assert "Runs fail more where light0light < 0.5 floorwood" in words


def test_a_finding_of_one_backend_is_not_reported_of_another(tmp_path: Path) -> None:
    dark = [make(conditions={"light": light}) for make, light in ((failed, 0.0), (passed, 1.0)) for _ in range(9)]
    page, _ = written([*dark, failed(backend="pybullet", conditions={"light": 0.5})], tmp_path)
    words = " ".join(page.words.split())
    assert words.count("light0light < 0.5") == 9
    assert "ConditionHere light0.5 " in words


def test_where_no_condition_explains_failures_the_page_says_so(tmp_path: Path) -> None:
    page, _ = written([failed(conditions={"light": 1.0}), passed(conditions={"light": 2.0})], tmp_path)
    assert "Too few runs to tell any condition from chance (2 runs, 1 failing)." in page.words


@pytest.mark.parametrize("failing, is_open", [(MAX_OPEN, True), (MAX_OPEN + 1, False)])
def test_a_few_failing_runs_are_shown_and_many_folded(failing: int, is_open: bool, tmp_path: Path) -> None:
    page, _ = written([failed(seed=seed) for seed in range(failing)], tmp_path)
    assert (("details", "open", "") in page.attributes) == is_open


def test_a_command_can_be_copied_as_it_is(tmp_path: Path) -> None:
    command = "robotcore run 'my  app.py' --world \"lab\" --set a=--b --timeout 20"
    _, html = written([replace(failed(), command=command)], tmp_path)
    (code,) = re.findall("<code>(.*?)</code>", html)
    assert unescape(re.sub("</?span>", "", code)) == command


def test_a_big_sweep_makes_a_page_that_opens(tmp_path: Path) -> None:
    write_noise(tmp_path / "a.png")
    conditions = {f"condition_{index}": index / 7 for index in range(33)}
    records = [replace(record, picture="a.png") for record in many(3000, failing=1200, conditions=conditions)]
    page, html = written(records, tmp_path)
    assert page.tags.count("img") == MAX_DETAILED
    assert len(set(re.findall(r"robotcore run green-search --seed \d+", page.words))) == MAX_DETAILED + MAX_LISTED
    assert "arena · kinematic 100 of 1200 runs" in page.words
    assert "And 100 more: failures.csv beside the results." in page.words
    assert "passing runs: 100 of 1800, failing: 100 of 1200" in page.words
    assert len(html) < 4_000_000


def test_the_order_in_which_runs_end_does_not_matter(tmp_path: Path) -> None:
    records = [make(seed=seed, backend=name) for seed in (2, 1) for name in ("b", "a") for make in (failed, passed)]
    _, html = written(records, tmp_path)
    _, other = written(records[::-1], tmp_path)
    titles = re.findall("<h4>(.*)</h4>", html)
    assert titles == [f"arena · {name} · seed {seed}" for name in "ab" for seed in (1, 2)]
    assert titles == re.findall("<h4>(.*)</h4>", other)


def test_letters_that_no_file_can_hold_are_replaced(tmp_path: Path) -> None:
    page, _ = written([failed(reason="no file \udcff.toml")], tmp_path)
    assert "no file ?.toml" in page.words


def test_a_page_is_written_over_an_older_one(tmp_path: Path) -> None:
    written([failed()], tmp_path)
    page, _ = written([passed()], tmp_path)
    assert "1 of 1 runs passed" in page.words


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "report").write_text("a file")
    with raises(UsageError, "unusable-folder", directory=str(tmp_path / "report")):
        written([passed()], tmp_path)


def test_a_missing_package_is_named_with_the_extra(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    monkeypatch.setattr(report, "find_spec", lambda _: None)
    with raises(BackendMissingError, "library-missing", module="jinja2", extra="sweep"):
        written([passed()], tmp_path)


def test_jinja_is_imported_only_for_a_page() -> None:
    code = "import sys, robotcore.sweep.report; sys.exit('jinja2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
