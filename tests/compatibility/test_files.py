"""Robots, worlds, maps and results of sweeps of each released version are read."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.cli.main import execute
from robotcore.description import RobotDescription, WorldDescription, load_any
from robotcore.sweep.results_file import read_results
from tests.compatibility.conftest import HERE, VERSIONS, CopyCorpus
from tests.compatibility.interface import list_keys
from tests.compatibility.make_corpus import SOURCES

of_all_versions = pytest.mark.parametrize("version", VERSIONS)


class Everything:
    """A collection that contains everything."""

    def __contains__(self, _: object) -> bool:
        return True


@pytest.mark.parametrize(
    "version, name",
    [(version, file.name) for version in VERSIONS for file in sorted((HERE / version).glob("*.toml"))],
)
def test_a_robot_or_a_world_is_read(version: str, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE / version)
    assert execute(["check", name]) == 0


@of_all_versions
def test_a_map_is_read(version: str) -> None:
    grid = OccupancyGrid.load(HERE / version / "map.npz")
    assert (grid.size, grid.cell, grid.travelled) == (2.0, 0.1, 1.5)
    assert (grid.evidence[5, 5], grid.evidence[6, 6]) == (3.0, -3.0)


@of_all_versions
def test_the_results_of_a_sweep_are_read(version: str) -> None:
    file = HERE / version / "sweep" / "results.jsonl"
    records = list(read_results(file, Everything()))
    assert [record.result.seed for record in records] == [1, 2, 3]
    assert {record.result.outcome.value for record in records} == {"success"}


@pytest.mark.slow
@of_all_versions
def test_a_sweep_does_not_mix_its_runs_with_those_of_another_version(
    version: str, copy_corpus: CopyCorpus, capfd: pytest.CaptureFixture[str]
) -> None:
    copy_corpus(version)
    outputs = json.loads(Path("outputs.json").read_text(encoding="utf-8"))
    assert execute(outputs["sweep"]["command"]) == 2
    assert "results of another sweep" in capfd.readouterr().err


@of_all_versions
def test_a_project_and_its_packages_have_robots_that_are_read(version: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE / version)
    for file in ("old-robot/old_robot.toml", "old-robot/room.toml", "old-board/old_board.toml"):
        assert load_any(file).name


def list_used_keys(value: object, path: str = "") -> set[str]:
    """Return the keys of a file's content in the form of `list_keys`."""
    if isinstance(value, (list, tuple)):
        return set().union(*(list_used_keys(each, path) for each in value)) if value else set()
    if not isinstance(value, dict):
        return set()
    tag = value.get("kind") or value.get("shape") or ("differential" if path == "drive" else "")
    here = f"{path}[{tag}]" if tag else path
    found = {f"{here}.{key}".lstrip(".") for key in value}
    return found.union(*(list_used_keys(each, f"{here}.{key}".lstrip(".")) for key, each in value.items()))


EXEMPT = {"backends"}
"""Keys that no file has: the sections of backends are top-level tables."""
ADDED_BY_A_RUN = ("devices[operator]",)


def name_mount(key: str) -> str:
    """Return a key of a mount without its device, because the mounts of all devices have the same keys."""
    return re.sub(r"^devices\[\w+\]\.mount", "mount", key)


@pytest.mark.parametrize("model", [RobotDescription, WorldDescription])
def test_the_sources_of_the_next_corpus_use_every_key(
    model: type[RobotDescription | WorldDescription], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(SOURCES)
    loaded = [each for each in map(load_any, sorted(map(str, Path().glob("*.toml")))) if isinstance(each, model)]
    used = set().union(*(list_used_keys(each.model_dump(exclude_unset=True)) for each in loaded))
    keys = {key for key in list_keys(model.model_json_schema()) if not key.startswith(ADDED_BY_A_RUN)}
    assert {*map(name_mount, keys)} - {*map(name_mount, used)} - EXEMPT == set()
