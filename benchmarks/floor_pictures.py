"""Measure what lines, a pattern and a picture on the floor cost in a tick, against a plain floor.

    python -m benchmarks.floor_pictures

The robot turns on the spot between the lines of the world track, reads its camera in each tick, and looks for a ball.
Blocks of ticks on both floors are timed in turn, in one process. So other load on the machine affects both. The exit
status is 1 if a ratio exceeds the bound of its simulator.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from benchmarks.loop import make_framework_block, make_timer
from benchmarks.report import measure_ratio, parse_options, print_table
from robotcore.description import Texture, WorldDescription, load_robot, load_world
from robotcore.simulation.floor_sheet import draw_floor_sheet

BOUNDS = {"kinematic": 5.0, "mujoco": 2.0, "pybullet": 2.0}
"""The greatest ratio on each simulator."""

COURSE = """
name = "course"

[floor]
length_m = 3.0
width_m = 2.2
colour = "white"
image = { file = "course.png", length_m = 3.0 }
"""


def main() -> int:
    """Time the floors of each simulator in pairs, and print the ratios."""
    options = parse_options(__doc__, pairs=20, ticks=40)
    cv2.setNumThreads(1)
    robot, floors = load_robot("rover"), _build_floors()
    plain, *others = floors
    rows, is_met = [], True
    for backend, bound in BOUNDS.items():
        timers = {
            name: make_timer(make_framework_block(backend, robot, world), options.ticks)
            for name, world in floors.items()
        }
        for name in others:
            ratio = measure_ratio(timers[name], timers[plain], options.pairs)
            rows.append((backend, name, *ratio.format_cells(".2f"), f"≤ {bound:g}"))
            is_met &= ratio.median <= bound
    columns = (f"tick on {plain}, {options.pairs} pairs", "floor", "ratio, median", "95 % interval of it", "bound")
    print_table(columns, rows)
    return int(not is_met)


def _build_floors() -> dict[str, WorldDescription]:
    """Return worlds that differ in the floor only, by the names of their floors. The first floor is plain."""
    track = load_world("track")
    bare = track.model_copy(update={"lines": ()})
    sheet = draw_floor_sheet(track)
    assert sheet
    with TemporaryDirectory() as folder:
        cv2.imwrite(str(Path(folder, "course.png")), sheet.pixels[::-1, :, ::-1])
        Path(folder, "course.toml").write_text(COURSE)
        floor = load_world(str(Path(folder, "course.toml"))).floor
    checker = bare.floor.model_copy(update={"texture": Texture(pattern="checker")})
    return {
        "a plain floor": bare,
        "a pattern": bare.model_copy(update={"floor": checker}),
        "lines": track,
        "a picture": bare.model_copy(update={"floor": floor}),
    }


if __name__ == "__main__":
    sys.exit(main())
