"""Measure the cost of a robot's cycle over the remote APIs, and of a picture over the legacy API.

    python -m benchmarks.remote_cycle
    python -m benchmarks.remote_cycle --coppeliasim 127.0.0.1:23000

A cycle has two motor commands, a time step, a range and a picture of 320 × 240. The devices of the backend are compared
with plain calls of CoppeliaSim's own client, or with single messages of the legacy API. Both use the same server in
turn: a test double in its own process, or the real server of the options. A real CoppeliaSim needs an empty scene, a
real V-REP one with the rover's objects. The benchmark counts the round trips, and compares their requests. The exit
status is 1 if a bound is broken. The bound of a picture is for the double.
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
from benchmarks.remote.baseline_cycles import open_client_cycle, open_message_cycle
from benchmarks.remote.cycles import (
    DEVICES,
    Cycle,
    open_backend_cycle,
    open_blocking_picture_cycle,
    open_stepped_picture_cycle,
)
from benchmarks.remote.doubles import DoubleProcess
from benchmarks.remote.round_trip_proxy import RoundTripProxy, list_calls, list_commands
from benchmarks.report import at_least_one, machine, print_table
from robotcore.description import draw_world, load_robot, load_world
from robotcore.hal.backend import Setup

RATE_HZ, SEED = 20.0, 1
RATIO_BOUND, PICTURE_BOUND = 1.1, 4.0
WARMING = 5

Way = Callable[[Setup], AbstractContextManager[Cycle]]


class Api(NamedTuple):
    """A remote API: its backend, its cycle by hand, the decoder of its requests, and the robot of its double."""

    backend: str
    by_hand: Way
    words: Callable[[bytes], str]
    robot: str | None


APIS = (
    Api("coppeliasim", open_client_cycle, list_calls, None),
    Api("vrep", open_message_cycle, list_commands, "rover"),
)


class Server(NamedTuple):
    """The address of a server."""

    host: str
    port: int


def main() -> int:
    """Measure both APIs, or those whose real servers the options name, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=at_least_one, default=20)
    parser.add_argument("--cycles", type=at_least_one, default=50, help="the number of cycles in each half of a pair")
    parser.add_argument("--apis", default="coppeliasim,vrep", help="the APIs whose doubles are measured")
    for api in APIS:
        parser.add_argument(f"--{api.backend}", metavar="HOST:PORT", type=_server, help="a real server")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    named = {api.backend: server for api in APIS if (server := getattr(options, api.backend))}
    with ExitStack() as stack:
        servers = named or {
            api.backend: _start_double(api, stack) for api in APIS if api.backend in options.apis.split(",")
        }
        print(machine())
        apis = [api for api in APIS if api.backend in servers]
        results = [_compare_cycles(api, servers[api.backend], options.pairs, options.cycles) for api in apis]
        if "vrep" in servers:
            results.append(_compare_pictures(servers["vrep"], options.pairs, options.cycles, is_double=not named))
    return int(not all(results))


def _server(text: str) -> Server:
    host, _, port = text.rpartition(":")
    return Server(host, int(port))


def _start_double(api: Api, stack: ExitStack) -> Server:
    double = stack.enter_context(DoubleProcess(api.robot, seed=SEED))
    return Server("127.0.0.1", double.legacy_port if api.robot else double.zmq_port)


def _setup(server: Server) -> Setup:
    robot = load_robot("rover")
    world = draw_world(load_world("arena"), robot, SEED)
    return Setup(robot, world, frozenset(DEVICES), RATE_HZ, SEED, options=server._asdict())


def _compare_cycles(api: Api, server: Server, pairs: int, cycles: int) -> bool:
    """Print the times of the backend and of the cycle by hand.

    Return whether their ratio meets the bound, and their requests are equal.
    """
    ways: tuple[Way, Way] = partial(open_backend_cycle, api.backend), api.by_hand
    requests = [_list_requests(way, api, server) for way in ways]
    times: tuple[list[float], list[float]] = ([], [])
    first, second = (partial(_time_cycles, way, server, cycles, noted) for way, noted in zip(ways, times, strict=True))
    ratio, low, high = paired_ratios(first, second, pairs)
    names = f"{api.backend}, the robot's devices", "by hand"
    rows = [
        (name, str(len(each)), *_format_ms(noted)) for name, each, noted in zip(names, requests, times, strict=True)
    ]
    print()
    print_table((f"a cycle, {pairs} × {cycles}", "round trips", "ms, median", "95 % interval"), rows)
    print(f"\nratio {ratio:.3f}, 95 % interval {low:.3f} to {high:.3f}, bound {RATIO_BOUND:g}")
    print("requests: " + " | ".join(requests[0]))
    if requests[0] != requests[1]:
        print("by hand: " + " | ".join(requests[1]))
    return ratio <= RATIO_BOUND and requests[0] == requests[1]


def _list_requests(way: Way, api: Api, server: Server) -> list[str]:
    with RoundTripProxy(*server, api.words) as line, way(_setup(Server("127.0.0.1", line.port))) as cycle:
        for _ in range(WARMING):
            cycle()
        before = len(line.requests)
        cycle()
        return line.requests[before:]


def _time_cycles(way: Way, server: Server, cycles: int, noted: list[float]) -> float:
    times = _time_each(way, server, cycles)
    noted += times
    return statistics.median(times)


def _compare_pictures(server: Server, pairs: int, cycles: int, *, is_double: bool) -> bool:
    ways: dict[str, Way] = {
        "simxGetVisionSensorImage, blocking": open_blocking_picture_cycle,
        "a time step, and our camera": open_stepped_picture_cycle,
    }
    rows, is_soon = [], True
    for name, way in ways.items():
        times, by_hand = list[float](), list[float]()
        first, second = (
            partial(_time_cycles, way, server, cycles, times),
            partial(_time_cycles, open_message_cycle, server, cycles, by_hand),
        )
        ratio, low, high = paired_ratios(first, second, pairs)
        is_soon &= ratio <= PICTURE_BOUND
        bound = f"{PICTURE_BOUND:g}" if is_double else ""
        rows.append((name, *_format_ms(times), f"{ratio:.2f}", f"{low:.2f} to {high:.2f}", bound))
    print()
    columns = ("ms, median", "95 % interval", "in cycles by hand", "95 % interval", "bound")
    print_table((f"a picture over the legacy API, {pairs} × {cycles}", *columns), rows)
    return is_soon or not is_double


def _time_each(way: Way, server: Server, count: int) -> list[float]:
    times = []
    with way(_setup(server)) as cycle:
        for _ in range(WARMING):
            cycle()
        for _ in range(count):
            start = perf_counter()
            cycle()
            times.append(perf_counter() - start)
    return times


def _format_ms(times: list[float]) -> tuple[str, str]:
    median, low, high = (1e3 * time for time in median_with_interval(times))
    return f"{median:.2f}", f"{low:.2f} to {high:.2f}"


if __name__ == "__main__":
    sys.exit(main())
