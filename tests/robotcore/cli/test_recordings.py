"""``robotcore replay``, ``compare`` and ``info``, on files that ``run --record`` wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robotcore.recording.chunks import ChunkedFile, ChunkLocation
from robotcore.view.canvas import GOOD
from tests.robotcore.cli.conftest import AppFile, Cli, Recorded

COMMANDS = ("replay", "info", "compare")
HEAD_BYTES = 9
"""A record of an MCAP file begins with its kind and its length."""


def test_same_app_is_bit_equal(cli: Cli, recorded: Recorded) -> None:
    told = cli("replay", str(recorded.file))
    assert told.status == 0
    run = f"green-search on kinematic, arena, seed 7\n  {recorded.ticks} ticks, {recorded.time}"
    assert told.out.startswith(f"bit-equal  {run}\n  trace ")
    assert "as recorded" in told.out
    assert told.err == ""


def test_json_is_one_line_with_the_digests(cli: Cli, recorded: Recorded) -> None:
    told = cli("replay", str(recorded.file), "--json").json
    assert (told["bit_equal"], told["deviation"], told["exit_status"]) == (True, None, 0)
    assert told["ticks"] == recorded.ticks
    assert told["trace_sha256"] == told["recorded_sha256"]


def test_another_setting_is_rehearsed_and_drawn(cli: Cli, search: Path, tmp_path: Path) -> None:
    picture = tmp_path / "other.png"
    told = cli("replay", str(search), "--set", "speed_m_s=0.1", "--picture", str(picture))
    assert told.status == 0
    assert "they part in tick" in told.out
    assert "ticks differ" in told.out
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape == (1000, 1600, 3)
    assert not (drawn[:130, :, ::-1] == GOOD).all(axis=2).any()


def test_app_that_needs_another_sensor_is_refused_by_its_name(cli: Cli, brief: Path) -> None:
    told = cli("replay", str(brief), "--app", "green-search")
    assert told.status == 2
    assert "drive" in told.err


def test_lossy_recording_is_refused_and_rehearsed_with_a_warning(cli: Cli, tmp_path: Path) -> None:
    file = str(tmp_path / "lossy.mcap")
    cli("run", "mark-green", "--robot", "lookout", "--timeout", "1", "--record", file, "--record-jpeg")
    refused = cli("replay", file)
    assert refused.status == 2
    assert "JPEG is not what the app saw" in refused.err
    told = cli("replay", file, "--app", "mark-green")
    assert told.status == 0
    assert "JPEG is not what the app saw" in told.out


def test_comparison_of_a_run_with_itself_is_alike(cli: Cli, search: Path, tmp_path: Path) -> None:
    picture = tmp_path / "both.png"
    told = cli("compare", str(search), str(search), "--picture", str(picture))
    assert told.status == 0
    assert told.out.startswith("alike  the same milestones in the same order")
    assert picture.stat().st_size > 10_000


def test_comparison_of_different_runs_has_exit_status_1(cli: Cli, search: Path, brief: Path) -> None:
    told = cli("compare", str(search), str(brief), "--json")
    assert told.status == told.json["exit_status"] == 1
    assert (told.json["first"]["outcome"], told.json["second"]["outcome"]) == ("success", "timeout")


def test_info_tells_the_run_its_devices_and_what_it_is_good_for(cli: Cli, recorded: Recorded) -> None:
    told = cli("info", str(recorded.file))
    assert told.status == 0
    for words in (
        "whole, replayable",
        f"{recorded.ticks} ticks at 20.00 Hz",
        "verified by the simulator",
        "range sensor",
    ):
        assert words in told.out


def test_error_without_words_is_told_without_a_colon(cli: Cli, app_file: AppFile) -> None:
    told = cli("run", app_file("raise ValueError"))
    assert "Odd raised ValueError\n" in told.err


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("content", [None, b"", b"no recording", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x89MCAP0\r\n"])
def test_what_is_no_recording_is_told_by_its_file(cli: Cli, tmp_path: Path, command: str, content: Any) -> None:
    file = tmp_path / "odd.mcap"
    if content is not None:
        file.write_bytes(content)
    told = cli(command, *[str(file)] * (2 if command == "compare" else 1))
    assert (told.status, told.out) == (2, "")
    assert told.err.startswith("error: ")
    assert "odd.mcap" in told.err


@pytest.mark.parametrize("command", COMMANDS)
def test_missing_extra_is_named_with_its_remedy(
    cli: Cli, search: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    monkeypatch.setattr("robotcore.recording.mcap_file.find_spec", lambda _: None)
    told = cli(command, *[str(search)] * (2 if command == "compare" else 1))
    assert told.status == 3
    assert "pip install 'robotcore[record]'" in told.err


def test_damage_is_told_by_its_time_and_what_came_before_is_replayed(cli: Cli, search: Path, tmp_path: Path) -> None:
    file = tmp_path / "damaged.mcap"
    chunk = _middle_chunk(search)
    file.write_bytes(_flipped(search.read_bytes(), chunk.offset + chunk.length // 2))
    info, replayed = cli("info", str(file)), cli("replay", str(file))
    told = cli("info", str(file), "--json").json
    assert (info.status, told["damaged"], told["whole"]) == (0, True, False)
    words = f"the file is damaged at {told['duration_s']:.1f} s: what comes after is not read"
    assert f"damaged  {words}" in info.out
    assert "cut" not in info.out
    assert replayed.status == 0
    assert replayed.out.startswith("bit-equal")
    assert f"the recording ends here: {words}" in replayed.out


def test_damage_between_two_chunks_costs_nothing_of_the_run(cli: Cli, recorded: Recorded, tmp_path: Path) -> None:
    file = tmp_path / "damaged.mcap"
    chunk = _middle_chunk(recorded.file)
    file.write_bytes(_flipped(recorded.file.read_bytes(), chunk.offset + chunk.length + HEAD_BYTES))
    told, replayed = cli("info", str(file), "--json").json, cli("replay", str(file))
    assert (told["damaged"], told["replayable"], told["outcome"]) == (True, True, "success")
    assert told["ticks"] == recorded.ticks
    assert replayed.status == 0
    assert replayed.out.startswith("bit-equal")


damages = st.one_of(
    st.tuples(st.just("cut"), st.floats(0, 1), st.just(0)),
    st.tuples(st.just("flip"), st.floats(0, 1), st.integers(1, 255)),
)


@pytest.mark.parametrize("command", ["replay", "rehearse", "info", "compare"])
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(damage=st.lists(damages, min_size=1, max_size=3))
def test_damaged_file_ends_in_a_shorter_recording_or_a_named_error(
    cli: Cli, brief: Path, tmp_path: Path, command: str, damage: list[tuple[str, float, int]]
) -> None:
    file = tmp_path / "damaged.mcap"
    file.write_bytes(_damaged(brief.read_bytes(), damage))
    told = cli(*_arguments(command, file, brief, tmp_path))
    assert told.status in (0, 1, 2, 3)
    assert "Traceback" not in told.err
    assert told.status != 2 or "damaged.mcap" in told.err
    assert told.status == 0 or told.out or told.err


def _arguments(command: str, file: Path, whole: Path, folder: Path) -> list[str]:
    return {
        "replay": ["replay", str(file)],
        "rehearse": ["replay", str(file), "--app", "mark-green"],
        "info": ["info", str(file), "--csv", str(folder), "--picture", str(folder / "a.png")],
        "compare": ["compare", str(whole), str(file)],
    }[command]


def _middle_chunk(file: Path) -> ChunkLocation:
    """How long chunks are depends on how busy the machine was; between them stands an index."""
    places = [place for place, _ in ChunkedFile(file).chunks()]
    return places[len(places) // 2]


def _flipped(content: bytes, at: int) -> bytes:
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


def _damaged(content: bytes, damage: list[tuple[str, float, int]]) -> bytes:
    damaged = bytearray(content)
    for kind, where, bits in damage:
        at = int(where * (len(damaged) - 1)) if damaged else 0
        if kind == "cut":
            del damaged[at:]
        elif damaged:
            damaged[at] ^= bits
    return bytes(damaged)
