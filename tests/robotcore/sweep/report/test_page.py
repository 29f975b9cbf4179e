from __future__ import annotations

import re
import subprocess
import sys
from base64 import b64decode
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from robotcore.errors import BackendMissingError, UsageError
from robotcore.outcome import Outcome
from robotcore.sweep import report
from robotcore.sweep.record import Record
from robotcore.sweep.report import write_report
from robotcore.sweep.report.page import MAX_PICTURES
from tests.robotcore.sweep.report.pages import Page
from tests.robotcore.sweep.report.samples import failed, many, passed

PNG = b"\x89PNG\r\n\x1a\n and what a picture holds"


def written(records: Sequence[Record], folder: Path, asked: str = "") -> tuple[Page, str]:
    html = write_report(records, folder / "report", folder, asked=asked).read_text(encoding="utf-8")
    return Page(html), html


def a_bit_of_all(folder: Path) -> list[Record]:
    (folder / "7.png").write_bytes(PNG)
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
    assert all(source.startswith("data:image/png;base64,") for source in page.values("img", "src"))
    assert not {name for _, name, _ in page.attributes} & {"href", "srcset", "xlink:href"}
    assert not any(word in html for word in ("http://", "https://", "url(", "@import"))


def test_a_browser_is_told_to_fetch_nothing(tmp_path: Path) -> None:
    page, _ = written([passed()], tmp_path)
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'" in page.values("meta", "content")


def test_the_picture_of_every_failing_run_is_in_it_as_it_is(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path)
    pictures = [b64decode(source.partition(",")[2]) for source in page.values("img", "src")]
    assert pictures == [PNG] * 10
    assert "arena · kinematic · seed 20" in page.values("img", "alt")[0]


def test_all_that_is_drawn_has_words_too(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path)
    drawings = page.values("svg", "role")
    labels = page.values("svg", "aria-label")
    assert len(drawings) == len(labels) == 6  # success, arrivals, milestones, two maps, a condition
    assert (
        labels[0] == "Share of verified runs: arena · kinematic 67 %, arena · pybullet 100 %, clutter · kinematic 100 %"
    )
    assert all(labels)


def test_what_an_app_says_is_no_markup(tmp_path: Path) -> None:
    evil = '<script>alert(1)</script> & "more" \'</style>'
    result = failed(reason=evil, world=evil, app=evil, milestones={evil: 1.0}, conditions={evil: evil}).result
    records = [
        Record(replace(result, seed=seed, outcome=outcome), ((0, 0, 0),), f"robotcore run '{evil}'")
        for seed, outcome in enumerate((Outcome.FAILURE, Outcome.ERROR) * 8)
    ]
    page, _ = written(records, tmp_path, asked=evil)
    assert page.faults == []
    assert "script" not in page.tags
    assert page.words.count(evil) > 8


def test_the_page_tells_what_was_asked_and_what_came_of_it(tmp_path: Path) -> None:
    page, _ = written(a_bit_of_all(tmp_path), tmp_path, asked="robotcore sweep green-search --seeds 0-29")
    assert "45 of 56 runs passed; the others: 10 timeout, 1 contact." in page.words
    assert "robotcore sweep green-search --seeds 0-29" in page.words
    assert "0–29" in page.words
    assert "49 % – 81 %" in page.words.replace("\N{NO-BREAK SPACE}", " ")
    assert "fails more in arena on kinematic where light < 0.6: 10 of 10, elsewhere 0 of 20" in page.words


def test_a_failing_run_tells_cause_conditions_and_command(tmp_path: Path) -> None:
    page, _ = written([failed(seed=3, contacts=2, distance_to_target_m=1.234, conditions={"light": 0.51234})], tmp_path)
    assert "timeout: not done after 20 s; touched something twice" in page.words
    assert "got as far as search, at 0.0 s, ended 1.23 m from the target, light 0.512" in page.words
    assert "robotcore run green-search --seed 3" in page.words


def test_a_success_that_the_simulator_denies_says_so(tmp_path: Path) -> None:
    page, _ = written([passed(verified=False)], tmp_path)
    assert "says success, but the simulator does not agree" in page.words
    assert "1 not verified" in page.words


def test_backends_that_differ_are_told_apart(tmp_path: Path) -> None:
    records = [passed(seed=1), passed(seed=2), passed(seed=1, backend="pybullet"), failed(seed=2, backend="pybullet")]
    page, _ = written(records, tmp_path)
    assert "Where kinematic and pybullet differ: 1 of 2" in page.words
    assert "search → seen → arrived" in page.words


def test_no_runs_make_a_page_that_says_so(tmp_path: Path) -> None:
    page, _ = written([], tmp_path)
    assert page.faults == []
    assert "No runs yet." in page.words


def test_runs_of_a_robot_that_nobody_can_judge_are_told(tmp_path: Path) -> None:
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
    assert "1 (said)" in page.words


def test_a_picture_that_is_gone_is_left_out(tmp_path: Path) -> None:
    page, _ = written([failed(picture="gone.png")], tmp_path)
    assert "img" not in page.tags
    assert "robotcore run green-search --seed 7" in page.words


def test_a_big_sweep_makes_a_page_that_opens(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(PNG)
    records = [replace(record, picture="a.png") for record in many(3000, failing=500)]
    page, html = written(records, tmp_path)
    assert page.tags.count("img") == MAX_PICTURES
    assert all(f"<code>robotcore run green-search --seed {seed}</code>" in html for seed in range(1, 501))
    assert "passing runs: 100 of 2500, failing: 100 of 500" in page.words
    assert len(html) < 500_000


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


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "report").write_text("a file")
    with pytest.raises(UsageError, match=r"--report .*report: File exists\. Name a folder that can be written"):
        written([passed()], tmp_path)


def test_a_missing_package_is_named_with_the_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(report, "find_spec", lambda _: None)
    with pytest.raises(BackendMissingError, match=r"Jinja2.*pip install 'robotcore\[sweep\]'"):
        written([passed()], tmp_path)


def test_jinja_is_imported_only_for_a_page() -> None:
    code = "import sys, robotcore.sweep.report; sys.exit('jinja2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
