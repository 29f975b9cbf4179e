"""Check that runs give the same results, bit for bit, after a change of the code.

    python -m benchmarks.digests record FOLDER
    python -m benchmarks.digests compare FOLDER

`record` executes runs, and writes the digest of each trace, the exit status and the outcome to FOLDER/digests.json.
Some runs are recorded to FOLDER/recordings, with a digest of each channel. `compare` executes the same runs again,
replays every recording, and prints the differences. The exit status is 1 if anything differs or is missing.

The benchmark uses the command line only, so that the code may change between both. The machine and the installed
libraries must be the same.
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from hashlib import sha256
from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import make_reader

from benchmarks.report import parse_whole, print_machine, print_table

SIMULATORS = ("kinematic", "mujoco", "pybullet", "virtualpi")
WORLDS = ("arena", "clutter", "occluded", "open")
LONG = {"kinematic": (8, 40), "mujoco": (4, 30), "pybullet": (2, 15), "virtualpi": (5, 40)}
"""For each simulator: the number of seeds of a whole search, and its time limit in simulated seconds."""

SEEING, HEARING = "green-search --world open --seed 1", "avoid-obstacles --world arena --seed 3"
"""Runs that soon see the ball, or have obstacles in range, so that a fault has an effect."""

FAULTS = (
    *(f"{SEEING} --fault 'camera {fault}'" for fault in ("delay=0.2", "drop=0.4", "freeze after=0.5 lasts=0.8")),
    *(f"{SEEING} --fault '{fault}'" for fault in ("camera noise=40", "connection lost=1 after=2", "encoders slip=0.1")),
    *(f"{SEEING} --fault '{fault}'" for fault in ("left_motor weak=0.6", "loop stall=0.3 after=1 every=2")),
    *(f"{HEARING} --fault 'range {fault}'" for fault in ("delay=0.2", "no_echo=0.5", "noise=0.05", "spikes=0.1")),
    *(f"{HEARING} --fault '{fault}'" for fault in ("range stuck=1.5 after=1", "right_motor weak=0.5")),
)
STOPS = (
    *(f"{SEEING} --fault '{fault}'" for fault in ("right_motor dead after=1", "camera freeze after=1")),
    *(f"{HEARING} --fault '{fault} after=1'" for fault in ("left_motor reversed", "range freeze", "encoders freeze")),
)
"""Runs with a fault that makes the safety stage stop the robot."""

EVERY = 19
"""``--quick`` takes each nineteenth command. This is a prime number, so that all backends and kinds are included."""

LIMIT_S = 900
"""The time limit of a command, in seconds."""

STOPPED = 4
"""The exit status of a run that the safety stage stopped."""

FIELDS = (
    *("backend", "trace_sha256", "exit_status", "outcome", "verified", "sim_time_s", "ticks", "contacts"),
    *("distance_to_target_m", "interventions", "milestones", "conditions"),
)
"""The fields of ``--json`` that are compared. The others contain texts, or times of this machine."""

TEXT_CHANNELS = {"/run", "/result", "/log"}
"""The channels of a recording that are not compared, because they contain texts or times of this machine."""

ERROR_TEXT = re.compile(rb'"message":"(?:[^"\\]|\\.)*",?')
"""The text of an error in a tick, which may change. Its class and its fields are compared."""

Digest = dict[str, Any]


def main() -> int:
    """Record or compare the digests, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=("record", "compare"))
    parser.add_argument("folder", type=Path, help="the folder of the digests and the recordings")
    parser.add_argument("--jobs", type=partial(parse_whole, 1), default=2, help="the number of parallel commands")
    parser.add_argument("--quick", action="store_true", help="only a twentieth of the commands")
    parser.add_argument(
        "--only", metavar="WORDS", default="", help="only the commands that contain these words in this order"
    )
    options = parser.parse_args()
    file, recordings = options.folder / "digests.json", options.folder / "recordings"
    if file.exists() != (options.action == "compare"):
        parser.error(f"{file} {'exists already' if file.exists() else 'does not exist'}. Name another folder")
    known: dict[str, Digest] = json.loads(file.read_text()) if file.exists() else {}
    every = dict.fromkeys(map(_get_command, known)) if known else _list_commands()
    commands = [command for command in every if options.only in command][
        2 * options.quick :: EVERY if options.quick else 1
    ]
    if not commands:
        parser.error(f"no command contains the words {options.only!r}")
    print_machine()
    with ThreadPoolExecutor(options.jobs) as pool:
        if known:
            chosen = {key: digest for key, digest in known.items() if _get_command(key) in commands}
            return int(not _is_equal(chosen, commands, recordings, pool))
        recordings.mkdir(parents=True, exist_ok=True)
        tables = list(pool.map(lambda command: _compute_digests(command, recordings), commands))
    digests = {key: digest for table in tables for key, digest in table.items()}
    file.write_text(json.dumps(digests, indent=1))
    _print_kinds(digests)
    return int(not all(tables))


def _list_commands() -> Iterator[str]:
    """Yield the commands, the longest first. Each `run` command also makes a recording."""
    yield from _list_sweeps()
    for backend in (*SIMULATORS, "mock"):
        for seed, world in enumerate((*WORLDS, "arena"), 1):
            yield f"run avoid-obstacles --backend {backend} --world {world} --seed {seed} --timeout 6"
        for seed, world in enumerate(WORLDS, 1):
            yield f"run green-search --backend {backend} --world {world} --seed {seed} --timeout 6"
            if backend != "mock":
                yield f"run green-search --randomise --backend {backend} --world {world} --seed {seed} --timeout 6"
        yield f"run mark-green --robot lookout --backend {backend} --world open --seed 1 --timeout 3"
        if backend != "virtualpi":  # the bubblerob has no pins
            yield f"run green-search --robot bubblerob --backend {backend} --world open --seed 1 --timeout 5"
        if backend != "mock":
            yield f"run avoid-obstacles --randomise --backend {backend} --world clutter --seed 5 --timeout 6"
        for stop in STOPS:
            yield f"run {stop} --backend {backend} --timeout 6"
    for fault, other in zip(FAULTS, cycle(SIMULATORS[1:])):
        for backend in ("kinematic", other, "mock"):
            yield f"run {fault} --backend {backend} --timeout 6"


def _list_sweeps() -> Iterator[str]:
    everywhere = f"--world {','.join(WORLDS)}"
    for backend, (seeds, timeout_s) in LONG.items():
        yield f"sweep green-search --backend {backend} {everywhere} --seeds 1-{seeds} --timeout {timeout_s}"
        randomised = f"{everywhere} --seeds 11,{10 + seeds} --randomise --timeout {timeout_s}"
        yield f"sweep green-search --backend {backend} {randomised}"
        yield f"sweep avoid-obstacles --backend {backend} {everywhere} --seeds 1-6 --timeout 12"
        yield f"sweep mark-green --robot lookout --backend {backend} {everywhere} --seeds 1,2 --timeout 4"
        yield f"sweep green-search --rate 10 --set speed_m_s=0.15 --backend {backend} --seeds 1,2 --timeout 12"
        stuck = "--fault 'range stuck=1.5 after=3' --set duration_s=20"  # the robot hits obstacles
        yield f"sweep avoid-obstacles --backend {backend} {stuck} --seeds 1-4 --timeout 20"
        if backend != "virtualpi":
            yield f"sweep avoid-obstacles --robot bubblerob --backend {backend} {everywhere} --seeds 1,2 --timeout 8"
            yield f"sweep green-search --robot bubblerob --backend {backend} --world open --seeds 1-3 --timeout 12"
    yield "sweep green-search --option lost_echoes=0.2 --backend virtualpi --seeds 1,2 --timeout 20"
    yield "sweep avoid-obstacles --judge green-search --backend kinematic --seeds 1,2 --timeout 12"


def _compute_digests(command: str, recordings: Path) -> dict[str, Digest]:
    """Return the digest of each run of a command. If the command fails, print its error and return an empty dict."""
    words, recording, digests = shlex.split(command), recordings / _get_recording_name(command), dict[str, Digest]()
    with TemporaryDirectory() as folder:
        if is_sweep := words[0] == "sweep":
            answer = _run_robotcore(*words, "--jobs", "1", "--out", f"{folder}/sweep")
            file = Path(folder, "sweep", "results.jsonl")
            results = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
        else:
            recording.unlink(missing_ok=True)  # of an interrupted call
            results = [answer := _run_robotcore(*words, "--record", str(recording))]
    for result in results:
        if result.get("trace_sha256"):
            key = f"{command}: {result['world']}, seed {result['seed']}" if is_sweep else command
            digests[key] = {field: result.get(field) for field in FIELDS} | _digest_channels(recording)
    if not digests:
        print(f"no results: robotcore {command}\n  {answer.get('error', answer)}")
    return digests


def _digest_channels(recording: Path) -> Digest:
    digests: dict[str, Any] = defaultdict(sha256)
    try:
        with recording.open("rb") as stream:
            for _, channel, message in make_reader(stream).iter_messages():
                data = ERROR_TEXT.sub(b"", message.data) if channel.topic == "/ticks" else message.data
                digests[channel.topic].update(b"%d %b" % (message.log_time, data))
    except FileNotFoundError:
        return {}
    except McapError as error:
        return {"recording": str(error)}
    return {topic: digest.hexdigest()[:16] for topic, digest in sorted(digests.items()) if topic not in TEXT_CHANNELS}


def _run_robotcore(*words: str) -> dict[str, Any]:
    command = [sys.executable, "-m", "robotcore", *words, "--json"]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LIMIT_S)  # noqa: S603  our own
        result: dict[str, Any] = json.loads(ran.stdout)
    except subprocess.TimeoutExpired:
        return {"exit_status": None, "error": f"it takes longer than {LIMIT_S} s"}
    except ValueError:
        return {"exit_status": ran.returncode, "error": ran.stdout + ran.stderr}
    return result | {"exit_status": ran.returncode}


def _is_equal(known: dict[str, Digest], commands: Sequence[str], recordings: Path, pool: Executor) -> bool:
    """Execute the runs and the replays, print the differences and the counts, and return whether all are equal."""
    with TemporaryDirectory() as folder:
        tables = list(pool.map(lambda command: _compute_digests(command, Path(folder)), commands))
    now = {key: digest for table in tables for key, digest in table.items()}
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for key, digest in known.items():
        other = now.get(key, {})
        differing = [field for field in digest | other if digest.get(field) != other.get(field)]
        verdict = "different" if other and differing else "equal" if other else "missing"
        counts[digest["backend"]][verdict] += 1
        if verdict != "equal":
            print(f"{verdict}: robotcore {key}  # {', '.join(differing)}")
    recorded = [key for key in known if key.startswith("run ")]
    replays = pool.map(
        lambda key: _compare_replay(recordings / _get_recording_name(key), known[key]["trace_sha256"]), recorded
    )
    for key, verdict in zip(recorded, replays, strict=True):
        counts[f"{known[key]['backend']}, replayed"][verdict] += 1
        if verdict != "equal":
            print(f"{verdict}: robotcore replay {recordings / _get_recording_name(key)}")
    verdicts = ("equal", "different", "missing")
    rows = sorted((backend, *(str(count[verdict]) for verdict in verdicts)) for backend, count in counts.items())
    print_table(("backend", *verdicts), rows)
    return all(set(count) == {"equal"} for count in counts.values())


def _compare_replay(recording: Path, trace: str) -> str:
    if not recording.exists():
        return "missing"
    answer = _run_robotcore("replay", str(recording))
    is_equal = answer["exit_status"] == 0 and answer.get("bit_equal") and answer.get("trace_sha256") == trace
    return "equal" if is_equal else "different"


def _get_command(key: str) -> str:
    return key.partition(": ")[0]


def _get_recording_name(command: str) -> str:
    return re.sub(r"[^\w.]+", "-", command.removeprefix("run ")) + ".mcap"


def _print_kinds(digests: dict[str, Digest]) -> None:
    runs, recordings = Counter[str](), Counter[str]()
    for key, digest in digests.items():
        kinds = {
            "with pictures": " avoid-obstacles " not in key,
            "with faults": "--fault" in key,
            "randomised": "--randomise" in key,
            "safety stop": digest["exit_status"] == STOPPED,
        }
        matching = [kind for kind, is_matching in kinds.items() if is_matching] or ["plain"]
        for kind in ("all", digest["backend"], *matching):
            runs[kind] += 1
            recordings[kind] += key.startswith("run ")
    rows = [(kind, str(runs[kind]), str(recordings[kind])) for kind in sorted(runs)]
    print_table(("backend or kind", "runs", "recorded"), rows)


if __name__ == "__main__":
    sys.exit(main())
