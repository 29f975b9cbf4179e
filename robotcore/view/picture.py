"""A run in one picture: what is kept of it while it lasts, and the file it becomes."""

from __future__ import annotations

from pathlib import Path

import cv2

from robotcore.errors import UsageError
from robotcore.files import replace_file, require_replaceable
from robotcore.hal.devices import Image
from robotcore.hal.robot import Robot
from robotcore.runtime.layers.devices import LayeredCamera, LayeredDisplay
from robotcore.runtime.outcome import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.view.sheet import Story, draw
from robotcore.view.track import Footstep, Track


class PictureRecorder:
    """An observer: the true path where the simulator tells it, and the last picture that the app saw."""

    def __init__(self) -> None:
        self._run: Run | None = None
        self._track = Track()
        self._story: Story | None = None

    def begin(self, run: Run) -> None:
        self._run = run

    def tick(self, record: TickRecord) -> None:
        if self._run and self._run.truth:
            self._track.steps.append(Footstep(record.time, record.state, self._run.truth.pose))

    def end(self, result: RunResult) -> None:
        if run := self._run:
            self._story = Story(run.description, run.world, self._track, last_seen(run.robot), result)

    def png(self) -> bytes | None:
        """Draw the run; return the PNG, or None where no run began."""
        return None if self._story is None else png_of(self._story)

    def save(self, file: Path) -> bool:
        """Draw the run as a PNG; return whether one began. UsageError says why it cannot be written."""
        content = self.png()
        if content is None:
            return False
        save_png(content, file)
        return True


def png_of(story: Story) -> bytes:
    """Draw a run; return the PNG."""
    return encoded(draw(story))


def encoded(image: Image) -> bytes:
    """Return a picture as PNG."""
    _, png = cv2.imencode(".png", image)
    return png.tobytes()


def save_png(content: bytes, file: Path) -> None:
    """Write a picture. UsageError says why it cannot be written; no half of it is left behind."""
    try:
        with replace_file(file) as part:
            part.write_bytes(content)
    except OSError as error:
        raise _unwritable(file, error) from error


def last_seen(robot: Robot) -> Image | None:
    """Return the picture that was shown last, else the one that was read last. Looking at it reads nothing."""
    devices = robot.devices.values()
    shown = [each.latest for each in devices if isinstance(each, LayeredDisplay)]
    read = [each.latest.image for each in devices if isinstance(each, LayeredCamera) and each.latest]
    return next((image for image in (*shown, *read) if image is not None), None)


def require_writable(file: Path) -> None:
    """Raise UsageError if a picture could not be written; the content of the file stays."""
    if file.suffix.lower() != ".png":
        raise UsageError(f"--picture {file}: a picture is a .png file; give it that ending")
    try:
        require_replaceable(file)
    except OSError as error:
        raise _unwritable(file, error) from error


def _unwritable(file: Path, error: OSError) -> UsageError:
    return UsageError(f"--picture {file}: {error.strerror}. Name a file that can be written, where there is room")
