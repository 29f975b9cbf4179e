from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from robotcore import Outcome, RunRequest
from robotcore.junit import format_junit
from robotcore.sweep import Record, Results, Sweep
from robotcore.sweep.junit import build_suites
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.statistics import Requirement
from tests.robotcore.junit_schema import read_junit
from tests.robotcore.sweep.conftest import make_record

COMMAND = "robotcore sweep green-search --require verified>=0.5"


def write_results(folder: Path, records: Sequence[Record]) -> Results:
    worlds = tuple(dict.fromkeys(record.result.world or "" for record in records))
    seeds = tuple(dict.fromkeys(record.result.seed or 0 for record in records))
    results = Results(Sweep(RunRequest("green-search"), worlds=worlds, seeds=seeds), folder / "results")
    with results:
        for record in records:
            results.add(RunOutput(record, b"a picture" if record.is_failure else None))
    return results


def build(folder: Path, records: Sequence[Record], *requirements: str) -> ET.Element:
    bounds = [Requirement.parse(text) for text in requirements]
    return read_junit(format_junit(build_suites(write_results(folder, records), bounds, COMMAND)))


def test_each_backend_in_each_world_is_a_suite_and_each_run_a_case(tmp_path: Path) -> None:
    records = [make_record(world=world, seed=seed) for seed in (2, 1) for world in ("open", "arena")]
    root = build(tmp_path, records)
    assert [suite.attrib["name"] for suite in root] == [
        "green-search in arena on kinematic",
        "green-search in open on kinematic",
    ]
    assert [(case.attrib["classname"], case.attrib["name"]) for case in root[1].iter("testcase")] == [
        ("green-search.kinematic.open", "seed 1 in open on kinematic"),
        ("green-search.kinematic.open", "seed 2 in open on kinematic"),
    ]
    facts = {each.attrib["name"]: each.attrib["value"] for each in root[1].iter("property")}
    expected = {"robot": "rover", "command": COMMAND, "results": str(tmp_path / "results")}
    assert facts | expected == facts


def test_a_failing_run_has_its_cause_its_seed_its_command_and_its_picture(tmp_path: Path) -> None:
    late = make_record(Outcome.TIMEOUT, verified=False, seed=7, reason="not done after 60 s")
    record = replace(late, result=replace(late.result, wall_time_s=1.5))
    root = build(tmp_path, [record])
    case = root[0].find("testcase")
    assert case is not None
    assert case.attrib["time"] == "1.500"
    failure = case.find("failure")
    assert failure is not None
    assert failure.attrib == {"type": "timeout", "message": "timeout, not done after 60 s"}
    assert failure.text
    assert "Seed 7: timeout, 10.0 s on the robot's clock, 0 contacts\n" in failure.text
    assert failure.text.endswith("\nRepeat the run: robotcore run green-search --world open --seed 7")
    picture = tmp_path / "results" / "failures" / "kinematic-open-7.png"
    assert f"[[ATTACHMENT|{picture}]]" in (case.findtext("system-out") or "")
    assert picture.exists()


def test_a_run_that_ended_by_an_error_is_an_error(tmp_path: Path) -> None:
    root = build(tmp_path, [make_record(Outcome.ERROR, verified=None, reason="the app raised ValueError")])
    assert [(each.tag, each.attrib["type"]) for each in root.iter() if each.tag in ("error", "failure")] == [
        ("error", "error")
    ]


@pytest.mark.parametrize(
    "requirements, verdicts, statuses",
    [
        ([], ["failure"], []),
        (["verified>=0.5"], ["skipped"], [True]),
        (["verified>=0.9"], ["failure"], [False]),
        (["verified>=0.5", "contacts<=1"], ["failure"], [True, False]),
    ],
)
def test_a_failing_run_fails_unless_its_group_meets_all_requirements(
    tmp_path: Path, requirements: list[str], verdicts: list[str], statuses: list[bool]
) -> None:
    failing = make_record(Outcome.FAILURE, verified=False, contacts=2, seed=1)
    root = build(tmp_path, [failing, make_record(seed=2), make_record(seed=3)], *requirements)
    runs, gates = root[0].findall("testcase")[:3], root[0].findall("testcase")[3:]
    assert [each.tag for run in runs for each in run if each.tag != "system-out"] == verdicts
    assert [gate.attrib["name"] for gate in gates] == [f"{each} in open on kinematic" for each in requirements]
    assert [gate.find("failure") is None for gate in gates] == statuses


def test_a_missed_requirement_is_a_failure_with_the_value_and_the_command(tmp_path: Path) -> None:
    root = build(tmp_path, [make_record(verified=False), make_record(seed=2)], "verified>=0.9")
    failure = root[0].findall("testcase")[-1].find("failure")
    assert failure is not None
    assert failure.attrib == {"type": "gate", "message": "kinematic, open: verified is 0.5, required verified>=0.9"}
    assert (failure.text or "").endswith(f"Repeat the sweep: {COMMAND}")
