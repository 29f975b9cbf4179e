"""A run that is recorded until a test ends the process: ``python -m tests.robotcore.recording.recording_run FILE``.

Prints the time of each tick. A second argument limits the size of files, in bytes.
"""

from __future__ import annotations

import resource
import sys
from pathlib import Path

from robotcore.recording.recorder import Recorder
from robotcore.runtime.session import Run, RunRequest, RunResult, run
from robotcore.runtime.trace import TickRecord


class TimePrinter:
    """Prints the time of each tick and the outcome."""

    def begin(self, run: Run) -> None: ...

    def tick(self, record: TickRecord) -> None:
        print_line(repr(record.time))

    def end(self, result: RunResult) -> None:
        print_line(result.outcome.value)


def print_line(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main(file: str, limit: str | None = None) -> None:
    if limit:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), int(limit)))
    recorder = Recorder(Path(file))
    settings = {"duration_s": 2 if limit else 60}
    request = RunRequest("avoid-obstacles", robot="rover", settings=settings, realtime=not limit)
    run(request, [recorder, TimePrinter()], [recorder.layer])
    print_line(str(recorder.failure))


if __name__ == "__main__":
    main(*sys.argv[1:])
