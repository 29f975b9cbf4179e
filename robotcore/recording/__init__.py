"""Record a run into an MCAP file, and read it back."""

from __future__ import annotations

from pathlib import Path

from robotcore.extras import require_extra
from robotcore.recording.events import (
    DriveCommand,
    GroundTruthSample,
    MotorCommand,
    Read,
    RecordedError,
    SampleKey,
    ShownPicture,
    Tick,
    WheelAngles,
)
from robotcore.recording.recording import Metadata, Recording

__all__ = [
    "DriveCommand",
    "GroundTruthSample",
    "Metadata",
    "MotorCommand",
    "Read",
    "RecordedError",
    "Recording",
    "SampleKey",
    "ShownPicture",
    "Tick",
    "WheelAngles",
    "read",
]


def read(path: Path) -> Recording:
    """Read a recording. Of a file that is cut or damaged, the intact part at its beginning is read.

    If a killed run has left segments of a ring beside the file, they are first joined into the file.

    path: the ``.mcap`` file.

    Raises BackendMissingError if the extra ``record`` is not installed, and RecordingError if the file is not a
    recording.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=1.0), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> recording
    <Recording of avoid-obstacles on kinematic: 21 ticks, timeout>
    >>> last = recording.ticks[-1]
    >>> last.time
    1.0
    >>> [read.device for read in last.reads if read.by is None]
    ['nose']
    """
    require_extra("record", "a recording")
    from robotcore.recording.reader import read_file
    from robotcore.recording.segments import join_segments

    join_segments(path)
    return read_file(path)
