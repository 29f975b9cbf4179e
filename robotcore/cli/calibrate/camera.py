"""``robotcore calibrate camera`` measures a camera's lens, noise and delay, and the colour of an object before it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.calibrate.camera_parts import COLOUR, DELAY, INTRINSICS, NOISE, PARTS, CameraParts
from robotcore.cli.options import FolderType
from robotcore.cli.robot_session import BENCH, MeasuringCommand, RobotSession, robot_session_options
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from robotcore.calibration.camera.board import Board
    from robotcore.hal.robot import Role
    from robotcore.interactive.live_robot import LiveRobot
    from robotcore.kinds.camera import Camera

RATE_HZ = 50.0
"""The number of ticks in a second. No camera of a robot is faster."""


@click.command("camera", cls=MeasuringCommand, short_help="Measure a camera: lens, noise, delay, colour.")
@robot_session_options(BENCH)
@click.option("--camera", "name", metavar="NAME", help="The name of the camera. Default: the first one.")
@click.option("--only", "parts", type=click.Choice(PARTS), multiple=True, help="Measure only this part. Repeatable.")
@click.option("--board", metavar="COLUMNSxROWS", default="9x6", show_default=True, help="The board's inner corners.")
@click.option("--square", metavar="METRES", type=float, default=0.025, show_default=True, help="The side of a square.")
@click.option("--pictures", metavar="FOLDER", type=FolderType(), help="Take the pictures of the board from a folder.")
@click.option(
    "--recording",
    metavar="FILE.mcap",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="Take the pictures of the board from a recording.",
)
@click.option(
    "--colour",
    default="green",
    show_default=True,
    help="The approximate colour of the object: a name, or a hue in degrees.",
)
def command(
    name: str | None,
    parts: tuple[str, ...],
    board: str,
    square: float,
    pictures: Path | None,
    recording: Path | None,
    colour: str,
    **values: Any,
) -> int:
    """Measure a camera: its lens, its noise, its delay, and the colour of an object in the present light.

    noise: the noise of the pixels, while the robot stands.

    colour: the hue and the tolerance for apps, of a ball or another object before the camera.

    intrinsics: the field of view, the optical axis and the distortion, by a printed chessboard that you move before the
    camera. It must be flat. Its size is the number of inner corners: 9x6 for a board of 10 by 7 squares. In a
    simulator, the command renders pictures of the board as the simulated camera sees it.

    delay: the time from the capture of a picture until the app gets it. The robot turns to and fro on the spot.

    Without --only, all parts run that can. An e-stop, Ctrl-C or an error ends the command. The results of the parts
    before are then still shown and written. Exit status: 0 success, 1 a part had no result that is good enough.
    """
    from robotcore.calibration.camera.board import Board

    chessboard = Board.parse(board, square)
    session = RobotSession(**values)
    if pictures and recording:
        raise UsageError("give --pictures or --recording, not both", kind="two-sources")
    measurement = CameraParts(session, session.find_device("camera", name))
    reasons = _find_reasons(session, has_files=bool(pictures or recording))
    for part in parts:
        if reason := reasons.get(part):
            raise UsageError(f"--only {part}: {reason}", kind="part-not-possible", part=part)
    chosen = [part for part in PARTS if part in (parts or PARTS) and part not in reasons]
    measurement.skipped = {part: reasons[part] for part in PARTS if part in reasons and not parts}
    if pictures or recording:
        work = partial(measurement.run, INTRINSICS, partial(measurement.measure_files, chessboard, pictures, recording))
    else:
        work = partial(_measure_live, session, measurement, chessboard, colour, chosen)
    session.measure(work)
    if session.error and not (measurement.values or measurement.failures):
        raise session.error
    status = 1 if measurement.failures else 0
    is_right = bool(measurement.values) and not status
    return session.finish(
        f"The camera {measurement.camera.name}",
        measurement.to_dict(),
        measurement.write,
        status=status,
        is_right=is_right,
    )


def _find_reasons(session: RobotSession, *, has_files: bool) -> dict[str, str]:
    """Return the reason for each part that cannot run."""
    if has_files:
        return {part: "pictures of a board give only the intrinsics" for part in PARTS if part != INTRINSICS}
    reasons = {}
    if session.is_simulated and not session.simulates_file:
        reasons[INTRINSICS] = "the scene of the simulator has no board. Give pictures with --pictures or --recording"
    description, drive = session.description, session.description.drive
    if drive is None:
        reasons[DELAY] = "the robot has no drive to turn with"
    elif description.min_turn_radius_m:
        reasons[DELAY] = "the robot steers, so it cannot turn on the spot"
    elif not (drive.encoders or description.all_of("imu")):
        reasons[DELAY] = "the robot has neither encoders nor an IMU to compare with"
    return reasons


def _measure_live(
    session: RobotSession, measurement: CameraParts, board: Board, colour: str, parts: Sequence[str]
) -> None:
    """Open the robot, and measure parts one after the other. The person prepares each of them."""
    from robotcore.calibration.camera.measuring import require_content, take_pictures
    from robotcore.hal.robot import Role
    from robotcore.kinds.imu import Imu

    measures: dict[str, tuple[str, Callable[[LiveRobot, Camera], None]]] = {
        NOISE: ("", measurement.measure_noise),
        COLOUR: (f"Hold the {colour} object before the camera", partial(measurement.measure_colour, colour)),
        INTRINSICS: (
            "Take the chessboard, and hold it before the camera",
            partial(measurement.render_board if session.is_simulated else measurement.measure_board, board),
        ),
        DELAY: (
            "Put the robot on the floor with free space around it: it turns to and fro for 12 s",
            partial(measurement.measure_delay, RATE_HZ),
        ),
    }
    camera = measurement.camera.name
    wants: frozenset[Role | type[Imu]] = frozenset({Role.DRIVE, Imu}) if DELAY in parts else frozenset()
    with session.open(rate_hz=RATE_HZ, needs={camera}, wants=wants) as live:
        device: Any = live[camera]
        require_content(live.run(take_pictures(device, 2)))
        for part in parts:
            instruction, measure = measures[part]
            if instruction:
                session.prepare(instruction)
            measurement.run(part, partial(measure, live, device))
