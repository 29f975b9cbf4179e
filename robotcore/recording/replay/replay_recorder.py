"""Record a replay, so that its logged values and prints can be read like those of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from robotcore.recording.recorder import Recorder
from robotcore.recording.recording import Metadata, Recording, build_metadata
from robotcore.recording.writer import Entry
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord


class ReplayRecorder(Recorder):
    """Records a replay. The robot, the world and the true poses are those of the recorded run.

    path: the ``.mcap`` file, which is overwritten.
    recording: the recording that is replayed.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> from robotcore.recording.replay import replay
    >>> with TemporaryDirectory() as folder:
    ...     first, second = Path(folder, "run.mcap"), Path(folder, "replay.mcap")
    ...     recorder = Recorder(first)
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(first)
    ...     result = replay(recording, recorder=ReplayRecorder(second, recording))
    ...     read(second)
    <Recording of avoid-obstacles on kinematic: 11 ticks, timeout>
    """

    def __init__(self, path: Path, recording: Recording) -> None:
        super().__init__(path)
        self._recording = recording
        self._truth = {sample.tick: sample for sample in recording.truth}

    def end(self, result: RunResult) -> None:
        """Write the result of the replay with the backend, the world, the seed and the faults of the recorded run."""
        recorded = self._recording.metadata
        request, world = recorded.request, recorded.world.name if recorded.world else None
        super().end(
            replace(result, backend=request.backend, world=world, seed=request.seed, faults=list(request.faults))
        )

    def _build_metadata(self, run: RunContext) -> Metadata:
        recorded, replayed = self._recording.metadata, build_metadata(run)
        request = replace(recorded.request, app=run.request.app, settings=run.request.settings)
        return replace(
            replayed,
            request=request,
            description=recorded.description,
            is_stepped=recorded.is_stepped,
            world=recorded.world,
            started=recorded.started,
        )

    def _collect(self, record: TickRecord) -> Entry:
        return super()._collect(record)._replace(truth=self._truth.get(record.tick))
