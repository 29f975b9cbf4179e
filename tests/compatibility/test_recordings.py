"""Recordings of each released version open, and replay to the decisions that were recorded."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from robotcore.cli.main import execute
from robotcore.recording import read
from robotcore.recording.replay import evaluate, replay
from tests.compatibility.conftest import HERE, VERSIONS, CopyCorpus
from tests.compatibility.recordings import SURVEY

KILLED = "killed.mcap"
FACTS: dict[tuple[str, str], dict[str, Any]] = {
    (version, name): facts
    for version in VERSIONS
    for name, facts in json.loads((HERE / version / "recordings.json").read_text(encoding="utf-8")).items()
    if name != KILLED
}
"""The facts of each recording, by its version and its file."""

REPLAYABLE = [each for each, facts in FACTS.items() if facts["is_replayable"] and facts["app"] == SURVEY]
"""The recordings of the corpus' own app. A shipped app may decide otherwise in a later version."""

of_all = pytest.mark.parametrize("version, name", FACTS)


def find(version: str, name: str) -> Path:
    return HERE / version / "recordings" / name


@of_all
def test_a_recording_has_what_was_recorded(version: str, name: str) -> None:
    facts, recording = FACTS[version, name], read(find(version, name))
    assert (recording.damage, recording.is_cut) == ("", False)
    assert len(recording.ticks) == facts["ticks"]
    assert len(recording.samples) == facts["samples"]
    assert sum(map(len, recording.logged.values())) == facts["logged"]
    assert sum(map(len, recording.printed.values())) == facts["printed"]
    assert (recording.result.outcome.value if recording.result else None) == facts["outcome"]
    assert recording.is_replayable == facts["is_replayable"]
    assert list(recording.ticks[-1].pose or ()) == facts["last_pose"]
    assert all(recording.samples[key] for key in recording.samples)


@pytest.mark.parametrize("version, name", REPLAYABLE)
def test_a_recording_replays_to_the_recorded_decisions(
    version: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(HERE / version)
    result = replay(read(find(version, name)))
    assert result.deviation is None
    assert result.ticks == FACTS[version, name]["ticks"]


@of_all
def test_the_present_app_decides_on_the_samples_of_a_recording(
    version: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(HERE / version)
    assert evaluate(read(find(version, name)), FACTS[version, name]["app"]).result.ticks


@pytest.mark.slow
@of_all
def test_the_commands_show_a_recording(
    version: str, name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = str(find(version, name))
    assert execute(["info", file, "--csv", str(tmp_path / "table.csv"), "--picture", str(tmp_path / "run.png")]) == 0
    assert name in capfd.readouterr().out
    assert len((tmp_path / "table.csv").read_text().splitlines()) == FACTS[version, name]["ticks"] + 1


@pytest.mark.parametrize("version", VERSIONS)
def test_the_segments_of_a_killed_run_are_joined(version: str, copy_corpus: CopyCorpus) -> None:
    file = copy_corpus(version) / "recordings" / KILLED
    recording = read(file)
    assert recording.is_cut
    assert not recording.damage
    assert len(recording.ticks) >= 20
    assert evaluate(recording, SURVEY).result.ticks
