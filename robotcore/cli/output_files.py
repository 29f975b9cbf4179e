"""Check the names of files that a command writes, write its JUnit file, and finish the recording of a run."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from robotcore.cli.options import refuse_without
from robotcore.cli.output import write_failure
from robotcore.errors import RobotcoreError, UsageError
from robotcore.files import require_writable, save_output

if TYPE_CHECKING:
    from robotcore.junit import JUnitSuite
    from robotcore.recording.recorder import Recorder
    from robotcore.runtime.result import RunResult


def require_no_input(option: str, output: Path | None, *inputs: Path | str) -> None:
    """Raise UsageError if an output file is also an input of the command, even under another name.

    option: the option that names the output file.
    """
    if output and any(is_same_file(output, file) for file in inputs):
        raise UsageError(
            f"{option} {output}: the command reads this file. Name another file",
            kind="output-is-input",
            option=option,
            file=str(output),
        )


def require_suffix(option: str, output: Path | None, suffixes: Collection[str]) -> None:
    """Raise UsageError if the output is a file with none of these suffixes. A folder may have any suffix.

    option: the option that names the output.
    """
    if output and not output.is_dir() and output.suffix.lower() not in suffixes:
        kinds = " or ".join(suffixes)
        raise UsageError(
            f"{option} {output}: not a {kinds} file. Name a {kinds} file",
            kind="wrong-suffix",
            option=option,
            file=str(output),
        )


def require_distinct_outputs(**outputs: Path | None) -> None:
    """Raise UsageError if two outputs of a command are the same file, even under another name.

    outputs: the files by the names of their options, with ``_`` in place of ``-``. None is left out.
    """
    found: dict[Path, str] = {}
    for name, file in outputs.items():
        option = f"--{name.replace('_', '-')}"
        if file and (other := found.setdefault(Path(os.path.realpath(file)), option)) != option:
            raise UsageError(
                f"{option} {file}: {other} names the same file. Name two files",
                kind="same-output",
                option=option,
                file=str(file),
            )


def is_same_file(file: Path, other: Path | str) -> bool:
    """Return whether both names refer to the same existing file."""
    try:
        return file.samefile(other)
    except (OSError, ValueError):
        return False


JUNIT = "--junit"
"""The option that names a JUnit file."""


def require_junit_file(file: Path | None) -> None:
    """Raise UsageError if `write_junit` could not write the file. The file itself does not change."""
    if file:
        require_writable(file, JUNIT, ".xml")


def write_junit(suites: Sequence[JUnitSuite], file: Path) -> None:
    """Write test suites as JUnit XML. Raises UsageError if the file cannot be written; the old file is then kept."""
    from robotcore.junit import format_junit

    save_output(format_junit(suites), file, JUNIT)


def write_error_suite(file: Path | None, group: str, name: str, command: str, error: RobotcoreError) -> None:
    """Write a JUnit file with an error, so that a CI server shows it. If the file cannot be written, print that.

    file: the JUnit file; None writes no file.
    group, name: the group and the name of the test case.
    command: the command line that repeats it.
    """
    from robotcore.junit import build_error_suite

    try:
        if file:
            write_junit([build_error_suite(group, name, command, error)], file)
    except UsageError as unwritten:  # the caller reports the first error
        write_failure(str(unwritten))


@contextmanager
def write_error_suite_on_failure(file: Path | None, group: str, name: str, command: str) -> Iterator[None]:
    """Call `write_error_suite` if the ``with`` block raises RobotcoreError."""
    try:
        yield
    except RobotcoreError as error:
        write_error_suite(file, group, name, command, error)
        raise


def build_recorder(
    file: Path | None,
    options: Mapping[str, str],
    *,
    is_forced: bool = False,
    is_jpeg: bool = False,
    limit: int | None = None,
    last_s: float | None = None,
) -> Recorder | None:
    """Return an observer that records the run, or None without a file.

    file: the recording to write; None for no recording.
    options: the backend's options. A file that they name must not be overwritten.
    is_forced: whether to overwrite an existing recording.
    is_jpeg: whether to record the camera as JPEG.
    limit: the file size in bytes at which the recording ends; None for no limit.
    last_s: the time before the end of the run that the recording keeps, in seconds; None for the whole run.

    Raises UsageError if the file cannot be written, or exists and must not be overwritten.
    """
    if file is None:
        given = {
            "force": is_forced,
            "record_jpeg": is_jpeg,
            "record_limit": limit is not None,
            "record_last": last_s is not None,
        }
        refuse_without("a recording", "Add --record FILE.mcap", **given)
        return None
    require_no_input("--record", file, *options.values())
    from robotcore.recording.mcap_file import require_recordable
    from robotcore.recording.recorder import Recorder

    require_recordable(file, is_forced=is_forced)
    if last_s is not None:
        _require_ring_limit(limit)
    return Recorder(file, is_jpeg=is_jpeg, limit=limit, last_s=last_s)


def _require_ring_limit(limit: int | None) -> None:
    from robotcore.recording.ring import MIN_LIMIT_BYTES

    if limit is not None and limit < MIN_LIMIT_BYTES:
        least = f"{MIN_LIMIT_BYTES / 1e6:g}MB"
        raise UsageError(
            f"--record-limit {limit}: with --record-last, the limit is at least {least}. Use --record-limit {least}",
            kind="limit-too-small",
            limit=limit,
            least=MIN_LIMIT_BYTES,
        )


def _is_unfinished(recorder: Recorder) -> bool:
    """Return whether the recording has segments, and its error does not say how to join them."""
    from robotcore.recording.segments import has_segments

    return has_segments(recorder.path) and getattr(recorder.failure, "kind", "") != "segments-not-joined"


def finish_recording(result: RunResult, recorder: Recorder) -> tuple[RunResult, str]:
    """Return the result, and a line that names the recording. If there is no recording, the line is empty.

    If the recording is incomplete, the exit status of the result is at least 1.
    """
    if failure := recorder.failure:
        rest = f". Then finish it: robotcore info {recorder.path}" if _is_unfinished(recorder) else ""
        write_failure(f"the recording is incomplete: {failure}{rest}")
        return replace(result, exit_status=result.exit_status or 1, reason=result.reason or str(failure)), ""
    if not recorder.has_begun:
        return result, ""
    result = recorder.complete(result)
    lost = f", {recorder.dropped} picture(s) dropped, so it cannot be replayed" if recorder.dropped else ""
    cut = ", cut: the disk did not store its end in time" if recorder.is_writing else ""
    if cut and _is_unfinished(recorder):
        cut += f". Finish it: robotcore info {recorder.path}"
    early = f"; {recorder.ended_early}" if recorder.ended_early else ""
    begin = "" if recorder.begins_s is None else f", from {recorder.begins_s:.1f} s to the end of the run"
    return result, f"The recording: {recorder.path}{begin}{lost}{cut}{early}"
