"""Takes the pictures and the headings of a calibration from an open robot, or pictures from a folder or a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np

from robotcore.autonomy.routines import Routine
from robotcore.calibration.camera.board import Board, ViewSelection
from robotcore.calibration.camera.delay import Heading, TurnRecord, list_turn_rates
from robotcore.calibration.camera.intrinsics import MIN_VIEWS, fit_intrinsics
from robotcore.errors import CalibrationError, UsageError
from robotcore.geometry import wrap_angle
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.camera import Camera
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.imu import Imu
from robotcore.optics import Image
from robotcore.recording import read
from robotcore.text import pluralize

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
"""The suffixes of the picture files that a folder may have."""

TURN_S = 12.0
"""The time for which the robot turns to and fro, in seconds."""

MAX_TURN_RAD_S = 1.2
"""The greatest turn rate of the robot, in rad/s. A faster turn blurs the pictures."""

TURN_SHARE = 0.5
"""The robot turns with at most this share of its greatest turn rate, so that the wheels follow."""

ENOUGH_VIEWS, MOST_VIEWS = 15, 40
"""Taking pictures ends with this number of views if they reach all regions of the picture, or with the greater one."""

MIN_CONTRAST_LEVELS = 2.0
"""A picture whose grey levels have a smaller standard deviation shows nothing."""


def take_pictures(camera: Camera, count: int) -> Routine[list[Image]]:
    """Wait for the next pictures of a camera, and return them."""
    frames = [camera.read()]
    while len(frames) < count:
        yield
        frame = camera.read()
        if frame.sequence != frames[-1].sequence:
            frames.append(frame)
    return [frame.image for frame in frames]


def require_content(pictures: list[Image]) -> None:
    """Raise CalibrationError if all pictures are of one colour, such as those of a covered camera."""
    spread = max(float(picture.std()) for picture in pictures)
    if spread < MIN_CONTRAST_LEVELS:
        level = float(np.mean(pictures[-1]))
        raise CalibrationError(
            f"all pictures are nearly of one grey level, {level:.0f} of 255. Remove the cover of the camera, give it "
            "light, and test it: robotcore test-devices",
            kind="empty-pictures",
        )


def read_folder(folder: Path) -> Iterator[Image]:
    """Yield the grey pictures in a folder, in the order of their names. Raises UsageError if there are none."""
    if not folder.is_dir():
        text = f"there is no folder {folder}. Name a folder with pictures of the board"
        raise UsageError(text, kind="no-folder", folder=str(folder))
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)
    if not files:
        text = f"{folder} has no pictures. Name a folder with files such as 01.png or 01.jpg"
        raise UsageError(text, kind="no-pictures", folder=str(folder))
    for file in files:
        content = np.frombuffer(file.read_bytes(), np.uint8)  # cv2.imread refuses some paths on Windows
        picture = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE) if content.size else None
        if picture is None:
            text = f"{file} is no picture that OpenCV can read. Remove it, or save it as PNG"
            raise UsageError(text, kind="unreadable-picture", file=str(file))
        yield np.asarray(picture, np.uint8)


def read_recording(file: Path, camera: str) -> Iterator[Image]:
    """Yield the grey pictures of a camera in a recording. Raises the errors of reading a recording."""
    samples = read(file).samples
    for key in sorted(key for key in samples if key.device == camera):
        frame = samples[key]
        yield frame.grey  # type: ignore[attr-defined]  # the samples of a camera are frames


class BoardViewCollector:
    """Collects views of a board from live pictures, and describes what is missing.

    camera: the camera. The caller lets time pass between two calls of `look`.
    """

    def __init__(self, camera: Camera, board: Board) -> None:
        self._camera, self._board, self._sequence = camera, board, -1
        intrinsics = camera.intrinsics
        self.selection = ViewSelection((intrinsics.width, intrinsics.height))
        self.without: list[Image] = []
        """A few pictures that do not show the board."""
        self.pictures = 0

    @property
    def is_complete(self) -> bool:
        """Whether there are enough views in all regions of the picture."""
        count = len(self.selection.views)
        return count >= MOST_VIEWS or (count >= ENOUGH_VIEWS and not self.selection.uncovered)

    def look(self) -> bool:
        """Search the newest picture for the board. Return whether a view was added."""
        frame = self._camera.read()
        if frame.sequence == self._sequence:
            return False
        self._sequence = frame.sequence
        self.pictures += 1
        corners = self._board.find(frame.grey)
        if corners is None and len(self.without) < MIN_VIEWS:
            self.without.append(frame.grey)
        return self.selection.add_still(corners)

    def describe(self) -> str:
        """Return the number of views and what is missing, for the person who moves the board."""
        parts = [pluralize(len(self.selection.views), "view")]
        if len(self.selection.views) >= MIN_VIEWS:
            parts.append(self._describe_fit())
        if uncovered := self.selection.uncovered:
            parts.append(f"not yet covered: {', '.join(uncovered)}")
        return "; ".join(parts)

    def _describe_fit(self) -> str:
        try:
            fit = fit_intrinsics(self.selection, self._board)
        except CalibrationError as error:
            return str(error).partition(". ")[2] or str(error)
        return f"focal length known to {fit.deviations[0] / fit.focal_length_px:.2%}"


def record_turn(robot: Robot, camera: Camera, rate_hz: float) -> Routine[TurnRecord]:
    """Turn to and fro on the spot, and return the pictures and the headings.

    rate_hz: the number of ticks in a second.
    """
    record, sense = TurnRecord(), _find_heading_sensor(robot)
    limit = min(MAX_TURN_RAD_S, TURN_SHARE * robot.drive.max_angular)
    rates = [*list_turn_rates(round(TURN_S * rate_hz), 1 / rate_hz, limit), *[0.0] * round(rate_hz)]
    for rate in rates:
        robot.drive.set_velocity(0.0, rate)
        record.add_heading(sense())
        record.add_frame(camera.read(), robot.clock.now())
        yield
    return record


def find_heading_source(robot: Robot) -> str:
    """Return the name of the sensor that measures turns: an IMU, or else an encoder; ``""`` if there is none."""
    if not robot.has(Role.DRIVE):
        return ""
    names = [*(imu.name for imu in robot.all(Imu)), *(encoder.name for encoder in robot.all(Encoder))]
    return names[0] if names else ""


def _find_heading_sensor(robot: Robot) -> Callable[[], Heading]:
    """Return a function that returns the newest heading, of the IMU or else of the odometry."""
    for imu in robot.all(Imu):
        angle, last = 0.0, imu.read().heading

        def read_imu(imu: Imu = imu) -> Heading:
            nonlocal angle, last
            sample = imu.read()
            angle, last = angle + wrap_angle(sample.heading - last), sample.heading
            return Heading(sample.time, angle)

        return read_imu
    # The odometry adds the commands since the samples of the encoders, so its heading is that of now.
    return lambda: Heading(robot.clock.now(), robot.drive.pose.heading)
