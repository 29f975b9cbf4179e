"""Files that a command writes: they differ from its inputs, and the recording of a run."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from robotcore.cli.output import write_failure
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.recording.recorder import Recorder
    from robotcore.runtime.result import RunResult


def require_apart(option: str, output: Path | None, *inputs: Path | str) -> None:
    """Raise UsageError where an output is a file that the command reads, by whatever name or link."""
    if output and any(is_same(output, file) for file in inputs):
        raise UsageError(f"{option} {output}: this is the file that is read. Name another one")


def require_ending(option: str, output: Path | None, endings: Collection[str]) -> None:
    """Raise UsageError where an output is to be written under an ending of another kind of file; a folder has none."""
    if output and not output.is_dir() and output.suffix.lower() not in endings:
        raise UsageError(f"{option} {output}: it is written as {' or '.join(endings)}. Give it that ending")


def is_same(file: Path, named: Path | str) -> bool:
    """Return whether both are there, and one file."""
    try:
        return file.samefile(named)
    except (OSError, ValueError):
        return False


def make_recorder(
    file: Path | None, options: Mapping[str, str], *, is_jpeg: bool, limit: int | None = None
) -> Recorder | None:
    """Return what records the run into a file; refuse now one that could not be written then.

    So is one that an option of the backend names: a replay would be recorded over what it reads.
    """
    if file is None:
        for option, is_given in (("--record-jpeg", is_jpeg), ("--record-limit", limit)):
            if is_given:
                raise UsageError(f"{option} says how to record, and nothing is recorded. Add --record FILE.mcap")
        return None
    if any(is_same(file, value) for value in options.values()):
        raise UsageError(f"--record {file}: the backend reads this file. Name another one")
    from robotcore.recording.mcap_file import require_recordable
    from robotcore.recording.recorder import Recorder

    require_recordable(file)
    return Recorder(file, is_jpeg=is_jpeg, limit=limit)


def finish_recording(result: RunResult, recorder: Recorder) -> tuple[RunResult, str]:
    """Return the result, and a line on the recording if there is one.

    A run whose recording is not whole has not done all that was asked of it.
    """
    if fault := recorder.fault:
        write_failure(f"the recording is not whole: {fault}")
        return replace(result, exit_status=result.exit_status or 1, reason=result.reason or str(fault)), ""
    if not recorder.has_begun:
        return result, ""
    result = recorder.completed(result)
    lost = f", {recorder.dropped} picture(s) dropped: it cannot be replayed" if recorder.dropped else ""
    cut = ", cut: its end was not awaited" if recorder.is_writing else ""
    early = f"; {recorder.ended_early}" if recorder.ended_early else ""
    return result, f"The recording: {recorder.path}{lost}{cut}{early}"
