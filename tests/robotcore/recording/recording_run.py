"""A run that is recorded until a test ends the process: ``python -m tests.robotcore.recording.recording_run FILE [S]``.

With S, the recording keeps the last S seconds. Prints the time of each tick.
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
    recorder = Recorder(Path(sys.argv[1]), last_s=float(sys.argv[2]) if len(sys.argv) > 2 else None)
    request = RunRequest("avoid-obstacles", robot="rover", settings={"duration_s": 600}, timeout_s=600, realtime=True)
    run(request, [recorder, TimePrinter()], [recorder.layer])
