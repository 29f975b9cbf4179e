from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.listings import list_listings, write_files

PAGE = (Path(__file__).parents[2] / "docs" / "calibration.md").read_text()
SECTION = PAGE.partition("## Practise without a robot\n")[2].partition("\n## ")[0]


@pytest.mark.slow
def test_the_robot_of_the_page_drives_a_curve_until_its_motors_are_calibrated(tmp_path: Path) -> None:
    listings = list_listings(SECTION)
    write_files(listings, tmp_path)
    make_robots, drives = (each.text for each in listings if each.language == "sh")
    commands = make_robots + "\n".join(line for line in drives.splitlines() if "calibrate drive" not in line)
    commands, _, _ = commands.partition("robotcore run green-search")
    places = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    environment = {**os.environ, "PATH": places}
    answer = subprocess.run(
        ["/bin/sh", "-e", "-c", commands], check=False, cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert answer.returncode == 0, answer.stderr
    asides = [float(each) for each in re.findall(r"([\d.]+) cm beside the line", answer.stdout)]
    promised = [float(each) for each in re.findall(r"`([\d.]+) cm beside the line`", SECTION)]
    assert asides == pytest.approx(promised, rel=0.05, abs=0.2)
    (table,) = (each.text for each in listings if each.language == "text")
    properties = re.findall(r"^left_motor +([a-z]+ ?[a-z]*), \S+ .*$", table, re.MULTILINE)
    assert properties == re.findall(r"^left_motor +([a-z]+ ?[a-z]*), \S+ .*$", answer.stdout, re.MULTILINE)
    assert "+lag_s = 0.07998" in answer.stdout
