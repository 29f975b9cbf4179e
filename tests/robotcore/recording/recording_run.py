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


class Teller:
    """An observer that prints."""

    def begin(self, run: Run) -> None: ...

    def tick(self, record: TickRecord) -> None:
        say(repr(record.time))

    def end(self, result: RunResult) -> None:
        say(result.outcome.value)


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main(file: str, limit: str | None = None) -> None:
    if limit:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), int(limit)))
    recorder = Recorder(Path(file))
    settings = {"duration_s": 2 if limit else 60}
    request = RunRequest("avoid-obstacles", robot="rover", settings=settings, realtime=not limit)
    run(request, [recorder, Teller()], [recorder.layer])
    say(str(recorder.failure))


if __name__ == "__main__":
    main(*sys.argv[1:])
