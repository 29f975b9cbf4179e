"""What a cycle of a robot costs over the remote APIs, against the same by hand, and a picture over the legacy one.

    python -m benchmarks.remote_cycle
    python -m benchmarks.remote_cycle --coppeliasim 127.0.0.1:23000

A cycle is two motors, a time step, a range and a picture of 320 × 240: once by the backend's devices, once by plain
calls of CoppeliaSim's own client, or by messages of the legacy API one by one. Both are measured in turn on the same
server: the tests' doubles, each a process, unless real ones are named (one with an empty scene, and for V-REP one with
the rover's objects). Round trips are counted on the line, and what is asked in them is compared. Exit status 1 where a
bound is broken; that of a picture is for the double.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from time import perf_counter
from typing import NamedTuple

import cv2

from benchmarks.pairs import median_with_interval, paired_ratios
from benchmarks.remote.by_hand import plain_calls, raw_messages
from benchmarks.remote.cycles import DEVICES, Cycle, blocking_pictures, framed, stepped_pictures
from benchmarks.remote.doubles import Double
from benchmarks.remote.line import Line, calls_in, messages_in
from benchmarks.report import at_least_one, machine, print_table
from robotcore.description import draw_world, load_robot, load_world
from robotcore.hal.backend import Setup

RATE_HZ, SEED = 20.0, 1
RATIO_BOUND, PICTURE_BOUND = 1.1, 4.0
WARMING = 5

Way = Callable[[Setup], AbstractContextManager[Cycle]]


class Api(NamedTuple):
    """A backend, the same by hand, how its requests are read, and the robot that its double has in the scene."""

    backend: str
    by_hand: Way
    words: Callable[[bytes], str]
    robot: str | None


APIS = (
    Api("coppeliasim", plain_calls, calls_in, None),
    Api("vrep", raw_messages, messages_in, "rover"),
)


class Server(NamedTuple):
    """Where one listens."""

    host: str
    port: int


def main() -> int:
    """Measure both APIs, or those whose real servers are named, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=at_least_one, default=20)
    parser.add_argument("--cycles", type=at_least_one, default=50, help="in each half of a pair, whose median counts")
    parser.add_argument("--apis", default="coppeliasim,vrep", help="whose doubles are measured")
    for api in APIS:
        parser.add_argument(f"--{api.backend}", metavar="HOST:PORT", type=_server, help="a real server")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    named = {api.backend: server for api in APIS if (server := getattr(asked, api.backend))}
    with ExitStack() as stack:
        servers = named or {api.backend: _doubled(api, stack) for api in APIS if api.backend in asked.apis.split(",")}
        print(machine())
        apis = [api for api in APIS if api.backend in servers]
        results = [_compared(api, servers[api.backend], asked.pairs, asked.cycles) for api in apis]
        if "vrep" in servers:
            results.append(_pictured(servers["vrep"], asked.pairs, asked.cycles, is_double=not named))
    return int(not all(results))


def _server(text: str) -> Server:
    host, _, port = text.rpartition(":")
    return Server(host, int(port))


def _doubled(api: Api, stack: ExitStack) -> Server:
    double = stack.enter_context(Double(api.robot, seed=SEED))
    return Server("127.0.0.1", double.legacy_port if api.robot else double.zmq_port)


def _setup(server: Server) -> Setup:
    robot = load_robot("rover")
    world = draw_world(load_world("arena"), robot, SEED)
    return Setup(robot, world, frozenset(DEVICES), RATE_HZ, SEED, options=server._asdict())


def _compared(api: Api, server: Server, pairs: int, cycles: int) -> bool:
    """Print what a cycle takes both ways; return whether that is within the bound, and the same was asked."""
    ways: tuple[Way, Way] = partial(framed, api.backend), api.by_hand
    asked = [_asked(way, api, server) for way in ways]
    times: tuple[list[float], list[float]] = ([], [])
    first, second = (partial(_timed, way, server, cycles, noted) for way, noted in zip(ways, times, strict=True))
    ratio, low, high = paired_ratios(first, second, pairs)
    names = f"{api.backend}, the robot's devices", "by hand"
    rows = [(name, str(len(words)), *_ms(noted)) for name, words, noted in zip(names, asked, times, strict=True)]
    print()
    print_table((f"a cycle, {pairs} × {cycles}", "round trips", "ms, median", "95 % interval"), rows)
    print(f"\nratio {ratio:.3f}, 95 % interval {low:.3f} to {high:.3f}, bound {RATIO_BOUND:g}")
    print("asked: " + " | ".join(asked[0]))
    if asked[0] != asked[1]:
        print("by hand: " + " | ".join(asked[1]))
    return ratio <= RATIO_BOUND and asked[0] == asked[1]


def _asked(way: Way, api: Api, server: Server) -> list[str]:
    """Return what is asked in one cycle, a request each."""
    with Line(*server, api.words) as line, way(_setup(Server("127.0.0.1", line.port))) as cycle:
        for _ in range(WARMING):
            cycle()
        before = len(line.requests)
        cycle()
        return line.requests[before:]


def _timed(way: Way, server: Server, cycles: int, noted: list[float]) -> float:
    """Return how long a cycle takes, in seconds, the median of many in a row; note each."""
    times = _each(way, server, cycles)
    noted += times
    return statistics.median(times)


def _pictured(server: Server, pairs: int, cycles: int, *, is_double: bool) -> bool:
    """Print how long pictures take, in turn with whole cycles by hand; return whether that is within the bound."""
    ways: dict[str, Way] = {
        "simxGetVisionSensorImage, blocking": blocking_pictures,
        "a time step, and our camera": stepped_pictures,
    }
    rows, is_soon = [], True
    for name, way in ways.items():
        times, by_hand = list[float](), list[float]()
        first, second = (
            partial(_timed, way, server, cycles, times),
            partial(_timed, raw_messages, server, cycles, by_hand),
        )
        ratio, low, high = paired_ratios(first, second, pairs)
        is_soon &= ratio <= PICTURE_BOUND
        bound = f"{PICTURE_BOUND:g}" if is_double else ""
        rows.append((name, *_ms(times), f"{ratio:.2f}", f"{low:.2f} to {high:.2f}", bound))
    print()
    columns = ("ms, median", "95 % interval", "in cycles by hand", "95 % interval", "bound")
    print_table((f"a picture over the legacy API, {pairs} × {cycles}", *columns), rows)
    return is_soon or not is_double


def _each(way: Way, server: Server, count: int) -> list[float]:
    """Return how long each of so many cycles took, in seconds."""
    times = []
    with way(_setup(server)) as cycle:
        for _ in range(WARMING):
            cycle()
        for _ in range(count):
            start = perf_counter()
            cycle()
            times.append(perf_counter() - start)
    return times


def _ms(times: list[float]) -> tuple[str, str]:
    median, low, high = (1e3 * time for time in median_with_interval(times))
    return f"{median:.2f}", f"{low:.2f} to {high:.2f}"


if __name__ == "__main__":
    sys.exit(main())
