"""Measure how many wrong wirings and mountings `robotcore test-devices` finds and corrects.

    python -m benchmarks.device_test

A seed draws mistakes in the file of a robot with a device of each kind: swapped sides, reversed motors and encoders,
mirrored pictures, wrong colours, other pulses of a servo, and more. The backend virtualpi simulates the true robot. The
command writes the corrected file. The file is right if each driver has the same effect as that of the true robot. The
exit status is 1 if a file is wrong, or if the command finds no mistake in the true file or one that is not there.
"""

from __future__ import annotations

import random
import sys
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import tomlkit

from benchmarks.report import parse_options, print_table
from robotcore.cli.main import execute
from tests.robotcore.device_test.miswiring import BACKEND, MISTAKES, build_true_robot, draw_mistakes, find_differences


def main() -> int:
    options = parse_options(__doc__ or "", robots=60, seed=0, simulator="kinematic")
    drawn: Counter[str] = Counter()
    wrong: Counter[str] = Counter()
    failures = 0
    begin = process_time()
    with TemporaryDirectory() as folder:
        true, user = Path(folder, "true.toml"), Path(folder, "user.toml")
        true.write_text(tomlkit.dumps(build_true_robot()))
        for number in range(options.robots):
            content, words = draw_mistakes(build_true_robot(), random.Random(f"{options.seed}:{number}"))
            if number == 0:
                content, words = build_true_robot(), []
            user.write_text(tomlkit.dumps(content))
            before = user.read_text()
            status = _test(user, true, options.simulator)
            differences = find_differences(str(user), str(true))
            drawn.update(words)
            is_right = not differences and status == 0 and (bool(words) or user.read_text() == before)
            failures += not is_right
            wrong.update(words if not is_right else [])
            if not is_right:
                print(f"robot {number}: {', '.join(words)}; still wrong: {', '.join(differences)}; status {status}")
    rows = [(word, str(drawn[word]), str(wrong[word])) for word in MISTAKES]
    print_table(("mistake", "robots with it", "of them not corrected"), rows)
    seconds = (process_time() - begin) / options.robots
    print(f"\n{options.robots - failures} of {options.robots} files are right, {seconds:.1f} s of CPU each.")
    return int(failures > 0)


def _test(user: Path, true: Path, simulator: str) -> int:
    arguments = ["test-devices", "--robot", str(user), "--backend", BACKEND, "--write"]
    arguments += ["--option", f"truth={true}", "--option", f"simulator={simulator}"]
    with Path(user.with_suffix(".log")).open("w") as log, redirect_stdout(log), redirect_stderr(log):
        return execute(arguments)


if __name__ == "__main__":
    sys.exit(main())
