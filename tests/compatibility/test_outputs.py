"""The commands of each released version run, with the exit status and the JSON fields that they had."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import pytest

from tests.compatibility.conftest import HERE, VERSIONS, CopyCorpus
from tests.compatibility.make_corpus import run_command

NAMED = {"batteries", "conditions", "faults", "intervention_s", "milestones"}
"""Fields whose keys are names that depend on the run."""

OF_THE_MACHINE = {"doctor"}
"""Commands whose exit status depends on the machine."""


@cache
def read_outputs(version: str) -> Any:
    return json.loads((HERE / version / "outputs.json").read_text(encoding="utf-8"))


def list_changes(before: Any, now: Any, path: str = "") -> list[str]:
    """Return the fields of an output that are missing now, or that have a value of another type."""
    if before is None or now is None:  # a value that could not be measured
        return []
    if isinstance(before, (int, float)) and isinstance(now, (int, float)):
        return [] if isinstance(before, bool) == isinstance(now, bool) else [path]
    if type(before) is not type(now):
        return [path]
    if isinstance(before, dict) and path.rpartition(".")[2] not in NAMED:
        missing = [f"{path}.{name}" for name in before.keys() - now.keys()]
        shared = before.keys() & now.keys()
        return missing + [each for name in shared for each in list_changes(before[name], now[name], f"{path}.{name}")]
    if isinstance(before, list) and before and now:
        return list_changes(before[0], now[0], f"{path}[]")
    return []


@pytest.mark.slow
@pytest.mark.parametrize("version, name", [(version, name) for version in VERSIONS for name in read_outputs(version)])
def test_a_command_has_its_exit_status_and_its_fields(version: str, name: str, copy_corpus: CopyCorpus) -> None:
    before = read_outputs(version)[name]
    copy_corpus(version)
    command = [f"again-{each}" if each == "sweep" and index else each for index, each in enumerate(before["command"])]
    now = run_command(*command)
    assert now["exit_status"] == before["exit_status"] or name in OF_THE_MACHINE
    assert list_changes(before["json"], now["json"]) == []


@pytest.mark.parametrize(
    "now, changes",
    [
        ({"a": 1.5, "b": [{"c": "x", "new": 1}]}, []),
        ({"a": None, "b": []}, []),
        ({"b": []}, [".a"]),
        ({"a": "1", "b": []}, [".a"]),
        ({"a": True, "b": []}, [".a"]),
        ({"a": 1, "b": [{}]}, [".b[].c"]),
    ],
)
def test_a_missing_field_and_another_type_are_found(now: Any, changes: list[str]) -> None:
    assert list_changes({"a": 1, "b": [{"c": "y"}]}, now) == changes
