"""A run that is recorded until a test ends the process: ``python -m tests.robotcore.recording.recording_run FILE``.

Prints the time of each tick.
"""

from __future__ import annotations

import sys
from pathlib import Path

from robotcore.recording.recorder import Recorder
from robotcore.runtime.session import RunRequest, run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.runs import Watcher


class TimePrinter(Watcher):
    """Prints the time of each tick."""

    def tick(self, record: TickRecord) -> None:
        sys.stdout.write(f"{record.time!r}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    recorder = Recorder(Path(sys.argv[1]))
    request = RunRequest("avoid-obstacles", robot="rover", settings={"duration_s": 60}, realtime=True)
    run(request, [recorder, TimePrinter()], [recorder.layer])
