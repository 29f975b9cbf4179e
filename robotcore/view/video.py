"""Write the pictures of a recording as a video, at the pace of the run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from robotcore.canvas import INK, PAPER, Canvas
from robotcore.errors import RecordingError, UnknownNameError, UsageError
from robotcore.files import replace_file
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from robotcore.recording import Recording, SampleKey
from robotcore.recording.mcap_file import build_unwritable_error
from robotcore.text import pluralize

WIDTH = 640
_MAX_HEIGHT = 1280

_MAX_REPEATS = 100
"""The greatest average number of pictures per tick. Ticks of a damaged recording may be years apart."""

_MAX_PICTURES = 100_000
"""The greatest number of pictures in a video: 83 minutes at 20 Hz."""

_STRIP = 36
"""The height of the strip with the state and the time, in pixels."""

TickPicture = tuple[float, str, SampleKey]
"""The time of a tick in seconds, its state, and the key of the picture to show."""


def write_video(recording: Recording, file: Path, device: str | None = None) -> None:
    """Write the pictures of a camera or a display as an ``.mp4`` file, with the time and the state below each.

    recording: the recording.
    file: the file to write.
    device: the name of a camera or a display; None for the first display with a picture, else the first camera.

    Raises UsageError if there is no such device or no picture. Raises RecordingError if the file cannot be written or
    the video would be too long.
    """
    known = _list_cameras_and_displays(recording)
    if device and device not in known:
        raise UnknownNameError("camera or display of the recording", device, known)
    name = device or _choose_device(recording)
    pictures = list(_list_tick_pictures(recording, name))
    if not pictures:
        raise UsageError(
            f"--video: the recording has no picture of {name}. To list its devices: robotcore info FILE",
            kind="no-picture",
            device=name,
        )
    rate = recording.metadata.request.rate_hz
    count = round((pictures[-1][0] - pictures[0][0]) * rate) + 1
    if count > min(_MAX_PICTURES, _MAX_REPEATS * len(pictures)):
        duration = f"{pictures[-1][0] - pictures[0][0]:.0f} s"
        problem = f"the recording lasts {duration} in {pluralize(len(pictures), 'tick')}, which is too long for a video"
        raise RecordingError(
            "--video", problem, "Write a picture or a table instead: --picture, --csv", kind="video-too-long"
        )
    try:
        with replace_file(file) as part:
            _write(part, file, recording, pictures, count)
    except OSError as error:
        raise build_unwritable_error(file, error) from error


def _write(part: Path, file: Path, recording: Recording, pictures: Sequence[TickPicture], count: int) -> None:
    """Write the video to ``part``, a temporary file that will replace ``file``. Errors name ``file``."""
    rate = recording.metadata.request.rate_hz
    size = _compute_size(_read_picture(recording, pictures[0][2]))
    writer = cv2.VideoWriter(str(part), cv2.VideoWriter.fourcc(*"mp4v"), rate, (size[0], size[1] + _STRIP))
    try:
        if not writer.isOpened():
            raise RecordingError(
                file, "the video cannot be written", "Name an .mp4 file that can be written", kind="file-not-writable"
            )
        for picture in _draw_pictures(recording, pictures, count, size):
            writer.write(picture)
    finally:
        writer.release()


def _choose_device(recording: Recording) -> str:
    """Return the name of the first display with a picture, else the name of the first camera."""
    shown = (each.device for tick in recording.ticks for each in tick.shown if each.key)
    for name in (*islice(shown, 1), *_list_cameras_and_displays(recording)):
        return name
    raise UsageError(
        "--video: the run opened no camera and no display. Choose a recording with one of them", kind="no-picture"
    )


def _list_cameras_and_displays(recording: Recording) -> list[str]:
    opened = [each for each in recording.metadata.description.devices if each.name in recording.metadata.devices]
    return [each.name for kind in ("camera", "display") for each in opened if each.kind == kind]


def _list_tick_pictures(recording: Recording, device: str) -> Iterator[TickPicture]:
    """Yield each tick from the first picture on. A tick without a new picture has the previous one."""
    last: SampleKey | None = None
    for tick in recording.ticks:
        keys = [*(each.key for each in reversed(tick.shown)), *(each.key for each in reversed(tick.reads))]
        last = next((key for key in keys if key and key.device == device and key in recording.samples), last)
        if last:
            yield tick.time, tick.state, last


def _draw_pictures(
    recording: Recording, pictures: Sequence[TickPicture], count: int, size: tuple[int, int]
) -> Iterator[Image]:
    """Yield the pictures of the video at the rate of the run. Each is repeated until the time of the next tick."""
    at, rate = 0, recording.metadata.request.rate_hz
    for index in range(count):
        now = pictures[0][0] + index / rate
        while at + 1 < len(pictures) and pictures[at + 1][0] <= now + 0.5 / rate:
            at += 1
        yield _annotate(_read_picture(recording, pictures[at][2]), pictures[at], size)


def _read_picture(recording: Recording, key: SampleKey) -> Image:
    frame = recording.samples[key]
    assert isinstance(frame, Frame), "cameras and displays have frames"
    return frame.image


def _compute_size(image: Image) -> tuple[int, int]:
    """Return the even width and height of a picture in the video. A higher picture is squeezed to `_MAX_HEIGHT`."""
    height, width = image.shape[:2]
    return WIDTH, 2 * max(1, round(min(WIDTH * height / width, _MAX_HEIGHT) / 2))


def _annotate(image: Image, picture: TickPicture, size: tuple[int, int]) -> Image:
    colour = image if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    time, state, _ = picture
    strip = Canvas(size[0], _STRIP, PAPER)
    strip.write_text((12, 25), f"{time:.2f} s  {state}", INK, 13)
    return np.vstack((cv2.resize(colour, size, interpolation=cv2.INTER_LINEAR), strip.render()))
