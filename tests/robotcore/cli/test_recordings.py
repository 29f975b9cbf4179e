"""``robotcore replay``, ``compare``, ``info`` and ``fidelity``, on files that ``run --record`` wrote."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robotcore.canvas import GOOD
from robotcore.recording.chunks import ChunkedFile, ChunkLocation
from tests.robotcore.cli.conftest import AppFile, Cli, RecordedRun
from tests.texts import CheckText

COMMANDS = ("replay", "info", "compare", "fidelity")
HEAD_BYTES = 9
"""The length of a record's head in an MCAP file, in bytes. The head has the record's kind and length."""


@pytest.mark.parametrize("name", [".", "..", "/", ""])
@pytest.mark.parametrize("command", ["info", "fidelity"])
def test_a_folder_in_place_of_a_recording_is_a_usage_error(
    cli: Cli, command: str, name: str, check_text: CheckText
) -> None:
    answer = cli(command, name, "--json")
    assert (answer.status, answer.json["kind"]) == (2, "recording-unreadable")
    check_text(answer.err)


@pytest.mark.slow
def test_same_app_is_bit_equal(cli: Cli, recorded: RecordedRun, check_text: CheckText) -> None:
    answers = cli("replay", str(recorded.file))
    assert (answers.status, answers.err) == (0, "")
    check_text(answers.out, hide=[f"{recorded.ticks} ticks, {recorded.time}", *re.findall("[0-9a-f]{64}", answers.out)])


@pytest.mark.slow
def test_json_is_one_line_with_the_digests(cli: Cli, recorded: RecordedRun) -> None:
    answers = cli("replay", str(recorded.file), "--json").json
    assert (answers["bit_equal"], answers["deviation"], answers["exit_status"]) == (True, None, 0)
    assert answers["ticks"] == recorded.ticks
    assert answers["trace_sha256"] == answers["recorded_sha256"]


@pytest.mark.slow
def test_another_setting_is_evaluated_and_drawn(cli: Cli, search_recording: Path, tmp_path: Path) -> None:
    picture = tmp_path / "other.png"
    answers = cli("replay", str(search_recording), "--set", "speed_m_s=0.1", "--picture", str(picture), "--json")
    assert answers.status == 0
    assert answers.json["parting"]
    assert answers.json["differing_ticks"] > 0
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape == (1000, 1600, 3)
    assert not (drawn[:130, :, ::-1] == GOOD).all(axis=2).any()


def test_app_that_needs_another_device_is_refused(cli: Cli, brief_recording: Path, check_text: CheckText) -> None:
    answers = cli("replay", str(brief_recording), "--app", "green-search")
    assert answers.status == 2
    check_text(answers.err)


def test_lossy_recording_is_refused_and_evaluated_with_a_warning(
    cli: Cli, tmp_path: Path, check_text: CheckText
) -> None:
    file = str(tmp_path / "lossy.mcap")
    cli("run", "mark-green", "--robot", "lookout", "--timeout", "1", "--record", file, "--record-jpeg")
    refused = cli("replay", file)
    assert refused.status == 2
    check_text(refused.err)
    answers = cli("replay", file, "--app", "mark-green", "--json")
    assert answers.status == 0
    check_text(answers.json["warning"])


@pytest.mark.slow
def test_comparison_of_a_run_with_itself_is_alike(
    cli: Cli, search_recording: Path, tmp_path: Path, check_text: CheckText
) -> None:
    picture = tmp_path / "both.png"
    answers = cli("compare", str(search_recording), str(search_recording), "--picture", str(picture))
    assert answers.status == 0
    check_text(answers.out.splitlines()[0])
    assert picture.stat().st_size > 10_000


@pytest.mark.slow
def test_comparison_of_different_runs_has_exit_status_1(
    cli: Cli, search_recording: Path, brief_recording: Path
) -> None:
    answers = cli("compare", str(search_recording), str(brief_recording), "--json")
    assert answers.status == answers.json["exit_status"] == 1
    assert (answers.json["first"]["outcome"], answers.json["second"]["outcome"]) == ("success", "timeout")


def test_info_shows_the_run_and_its_devices(cli: Cli, recorded: RecordedRun) -> None:
    answers = cli("info", str(recorded.file))
    assert answers.status == 0
    assert f"{recorded.ticks} ticks" in answers.out
    devices = [line.split()[0] for line in answers.out.rpartition("─\n")[2].splitlines()]
    assert devices == ["left_motor", "right_motor", "left_encoder", "right_encoder", "nose", "eye", "screen"]


def test_error_without_a_text_is_reported_without_a_colon(cli: Cli, app_file: AppFile, check_text: CheckText) -> None:
    answers = cli("run", app_file("raise ValueError"))
    check_text(answers.plain_err)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("content", [None, b"", b"no recording", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x89MCAP0\r\n"])
def test_a_file_that_is_no_recording_is_named(
    cli: Cli, tmp_path: Path, command: str, content: Any, check_text: CheckText
) -> None:
    file = tmp_path / "odd.mcap"
    if content is not None:
        file.write_bytes(content)
    answers = cli(command, *[str(file)] * (2 if command == "compare" else 1))
    assert (answers.status, answers.out) == (2, "")
    check_text(answers.plain_err)


@pytest.mark.parametrize("command", COMMANDS)
def test_missing_extra_is_named_with_its_remedy(
    cli: Cli, search_recording: Path, monkeypatch: pytest.MonkeyPatch, command: str, check_text: CheckText
) -> None:
    monkeypatch.setattr("robotcore.extras.find_spec", lambda _: None)
    answers = cli(command, *[str(search_recording)] * (2 if command == "compare" else 1))
    assert answers.status == 3
    check_text(answers.err)


@pytest.mark.slow
def test_a_damaged_recording_is_replayed_up_to_the_damage(
    cli: Cli, search_recording: Path, tmp_path: Path, check_text: CheckText
) -> None:
    file = tmp_path / "damaged.mcap"
    chunk = _middle_chunk(search_recording)
    file.write_bytes(_flip_bit(search_recording.read_bytes(), chunk.offset + chunk.length // 2))
    info, replayed = cli("info", str(file)), cli("replay", str(file))
    answers = cli("info", str(file), "--json").json
    assert (info.status, answers["damaged"], answers["whole"]) == (0, True, False)
    time = f"{answers['duration_s']:.1f} s"
    (damage,) = (line for line in info.out.splitlines() if line.startswith("damaged  "))
    # The contents of the chunk decide whether its decompression or its checksum fails.
    check_text(re.sub(r"byte \d+, [^)]*", "byte N, REASON", damage), hide=[time])
    assert replayed.status == 0
    assert time in replayed.out.splitlines()[-1]
    assert cli("replay", str(file), "--json").json["bit_equal"] is True


@pytest.mark.slow
def test_damage_between_two_chunks_loses_no_tick(cli: Cli, recorded: RecordedRun, tmp_path: Path) -> None:
    file = tmp_path / "damaged.mcap"
    chunk = _middle_chunk(recorded.file)
    file.write_bytes(_flip_bit(recorded.file.read_bytes(), chunk.offset + chunk.length + HEAD_BYTES))
    answers, replayed = cli("info", str(file), "--json").json, cli("replay", str(file), "--json")
    assert (answers["damaged"], answers["replayable"], answers["outcome"]) == (True, True, "success")
    assert answers["ticks"] == recorded.ticks
    assert (replayed.status, replayed.json["bit_equal"]) == (0, True)


damages = st.one_of(
    st.tuples(st.just("cut"), st.floats(0, 1), st.just(0)),
    st.tuples(st.just("flip"), st.floats(0, 1), st.integers(1, 255)),
)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["replay", "evaluate", "info", "compare"])
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(damage=st.lists(damages, min_size=1, max_size=3))
def test_damaged_file_ends_in_a_shorter_recording_or_a_named_error(
    cli: Cli, brief_recording: Path, tmp_path: Path, command: str, damage: list[tuple[str, float, int]]
) -> None:
    file = tmp_path / "damaged.mcap"
    file.write_bytes(_damage(brief_recording.read_bytes(), damage))
    answers = cli(*_arguments(command, file, brief_recording, tmp_path))
    assert answers.status in (0, 1, 2, 3)
    assert "Traceback" not in answers.err
    assert answers.status != 2 or "damaged.mcap" in answers.err
    assert answers.status == 0 or answers.out or answers.err


def _arguments(command: str, file: Path, whole: Path, folder: Path) -> list[str]:
    return {
        "replay": ["replay", str(file)],
        "evaluate": ["replay", str(file), "--app", "mark-green"],
        "info": ["info", str(file), "--csv", str(folder), "--picture", str(folder / "a.png")],
        "compare": ["compare", str(whole), str(file)],
    }[command]


def _middle_chunk(file: Path) -> ChunkLocation:
    """Return the middle chunk of a file. The length of chunks depends on the load of the machine."""
    places = [place for place, _ in ChunkedFile(file).chunks()]
    return places[len(places) // 2]


def _flip_bit(content: bytes, at: int) -> bytes:
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


def _damage(content: bytes, damage: list[tuple[str, float, int]]) -> bytes:
    damaged = bytearray(content)
    for kind, where, bits in damage:
        at = int(where * (len(damaged) - 1)) if damaged else 0
        if kind == "cut":
            del damaged[at:]
        elif damaged:
            damaged[at] ^= bits
    return bytes(damaged)
