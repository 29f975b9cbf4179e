"""Hostile recordings. Each is refused, or read up to its damage."""

from __future__ import annotations

import json
import random
import sys
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from subprocess import run as run_process

import pytest
from mcap.opcode import Opcode
from pydantic import ValidationError

from robotcore.errors import RecordingError, RobotcoreError, WatchdogError
from robotcore.recording import RecordedError, Recording, SampleKey, read
from robotcore.recording.chunks import ChunkedFile
from robotcore.recording.csv_table import write_csv
from robotcore.recording.summary import build_odometry_path, build_true_path, summarise_contents
from robotcore.recording.validation import parse_tick
from robotcore.view.text import format_contents
from tests.robotcore.recording.conftest import record
from tests.robotcore.recording.hostile_files import list_bombs, list_damaged, list_readable, list_refused, mutate
from tests.robotcore.recording.mcap_builder import build_chunk, build_file, build_record, change_json, read_raw

BOMBS, REFUSED, DAMAGED, READABLE = list_bombs(is_small=True), list_refused(), list_damaged(), list_readable()
WHEELS = {"left": 0, "right": 0}
MEMORY_BYTES = 300 * 10**6


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("base") / "run.mcap", app="green-search", timeout_s=0.6).file


def get_error_message(action: Callable[[], object]) -> str:
    """Return the message of an action's RecordingError; empty if it raises none."""
    try:
        action()
    except RecordingError as error:
        return str(error)
    return ""


def read_all(file: Path) -> Recording | None:
    """Read everything in a recording. Return None if it is refused; other errors are raised."""
    if message := get_error_message(lambda: read(file)):
        assert message.isprintable()
        assert file.name in message
        assert len(message) < len(str(file)) + 320
        return None
    recording = read(file)
    for key in recording.samples:
        message = get_error_message(partial(recording.samples.__getitem__, key))
        assert not message or "damaged" in message
    for tick in recording.ticks:
        errors = [read.error for read in tick.reads if read.error] + [tick.error] * (tick.error is not None)
        assert all(error.rebuild().args for error in errors if error)
    summarise_contents(recording)
    format_contents(recording, file)
    build_odometry_path(recording)
    build_true_path(recording)
    write_csv(recording, file.with_suffix(".csv"), "")
    return recording


@pytest.mark.slow
@pytest.mark.parametrize("name", [*BOMBS, *DAMAGED])
def test_hostile_file_is_read_up_to_its_damage(base: Path, file: Path, name: str) -> None:
    {**BOMBS, **DAMAGED}[name](base, file)
    recording = read_all(file)
    assert recording
    assert recording.damage.startswith("byte ")


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=pytest.mark.posix("a FIFO")) if each == "fifo" else each for each in REFUSED]
)
def test_hostile_file_is_refused(base: Path, file: Path, name: str) -> None:
    REFUSED[name](base, file)
    assert read_all(file) is None


@pytest.mark.slow
@pytest.mark.parametrize("name", READABLE)
def test_file_with_odd_values_is_read(base: Path, file: Path, name: str) -> None:
    READABLE[name](base, file)
    recording = read_all(file)
    assert recording
    assert not recording.is_damaged


@pytest.mark.slow
def test_memory_is_limited_for_compression_bombs(base: Path, tmp_path: Path) -> None:
    for name, make in BOMBS.items():
        make(base, tmp_path / f"{name}.mcap")
    command = f"import sys, {__name__} as test; test.main(*sys.argv[1:])"
    run_process([sys.executable, "-c", command, *map(str, tmp_path.iterdir())], check=True)


def main(*files: str) -> None:
    """Read files, and fail if this takes more memory than the bound."""
    for file in files:
        read_all(Path(file))
    status = Path("/proc/self/status").read_text()  # resource's ru_maxrss begins with that of the parent process
    most = int(status.partition("VmHWM:")[2].split()[0]) * 1024
    assert most < MEMORY_BYTES, f"{most} bytes"


@pytest.mark.slow
def test_file_changed_at_random_is_refused_or_read(base: Path, file: Path) -> None:
    chunks = read_raw(base)
    for seed in range(120):
        file.write_bytes(mutate(chunks, random.Random(seed)))
        read_all(file)


@pytest.mark.parametrize("packing", ["zstd", "", "brotli"])
def test_place_of_a_damage_is_the_begin_of_its_chunk(base: Path, file: Path, packing: str) -> None:
    content = base.read_bytes()
    end = content.index(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00", len(content) // 2)
    file.write_bytes(content[:end] + build_chunk(b"", size=7, packing=packing) + content[end:])
    assert read(file).damage.startswith(f"byte {end}, ")


@pytest.mark.parametrize(
    "kind, event",
    [
        ("reads", {"device": "e"}),
        ("asks", {}),
        ("motor_asks", {"device": "m"}),
        ("turned", {}),
        ("interventions", {"time": 0, "cause": "", "asked": WHEELS, "sent": WHEELS}),
        ("shown", {"device": "s"}),
    ],
)
def test_tick_with_too_many_events_is_refused(kind: str, event: dict[str, object]) -> None:
    for count, is_refused in ((10_000, False), (10_001, True)):
        content = json.dumps({"number": 0, "time": 0, "state": "", kind: [event] * count}).encode()
        with pytest.raises(ValidationError, match=kind) if is_refused else nullcontext():
            parse_tick(content, None)


def test_index_of_a_chunk_counts_as_read_bytes(file: Path) -> None:
    file.write_bytes(build_file(build_chunk(b""), build_record(Opcode.MESSAGE_INDEX, bytes(10_000))))
    chunked = ChunkedFile(file)
    assert len(list(chunked.chunks())) == 1
    chunked.allowance.take_values(b"," * (2**16 + 10_000))


@pytest.mark.parametrize(
    "name", ["picture-of-empty-fields", "jpeg-bomb", "jpeg-bomb-behind-a-fill-byte", "jpeg-that-is-a-png"]
)
def test_forged_picture_is_refused_before_it_is_decoded(
    base: Path, file: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    READABLE[name](base, file)
    samples = read(file).samples
    monkeypatch.setattr("cv2.imdecode", lambda *_: pytest.fail("it is decoded"))
    device = "screen" if name.startswith("jpeg") else "eye"
    with pytest.raises(RecordingError) as caught:
        samples[SampleKey(device, 0)]
    assert caught.value.kind == "recording-damaged"


def test_recompressed_result_of_another_version_is_read(base: Path, file: Path) -> None:
    early = ("app", "backend", "robot", "world", "seed", "outcome", "exit_status")
    file.write_bytes(
        change_json(base, "/result", lambda _, event: {name: event[name] for name in early} | {"later": 1})
    )
    whole, again = read(base), read(file)
    assert (again.ticks, again.damage) == (whole.ticks, "")
    assert again.result
    assert (again.result.app, again.result.notes, again.result.dropped_pictures) == ("green-search", [], None)


def test_recorded_error_is_of_a_known_class_and_keeps_its_attributes() -> None:
    for kind in ("signal", "Sequence", "_Portable", "format_exception", "none"):
        assert type(RecordedError(kind, "no echo").rebuild()) is RobotcoreError
    error = RecordedError("WatchdogError", "late", {"exit_status": 0, "cause": "none", "device": "nose"}).rebuild()
    assert isinstance(error, WatchdogError)
    assert (error.exit_status, error.cause) == (4, "watchdog")
