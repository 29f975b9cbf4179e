"""How long an image of 320 × 240 takes over V-REP's legacy remote API, from a double on loopback.

    python -m benchmarks.legacy_image

By the client that the backend uses, as an array, and by the functions that scripts know, as the list of signed numbers
that those return: most of its time goes into making 230400 objects. Exit status 1 where the client takes more than
5 ms; the official binding took 81 ms from a real server.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable
from time import perf_counter

from benchmarks.report import machine, print_table
from drivers.vrep import simx
from drivers.vrep.connection import Connection
from drivers.vrep.wire import requests
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import VisionSensor
from tests.doubles.coppeliasim.scene.simulator import Simulator

BOUND_MS = 5.0
TIMES = 200


def median_ms(call: Callable[[], object]) -> float:
    times = []
    for _ in range(TIMES):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
    return statistics.median(times) * 1000


def main() -> int:
    print(machine(), end="\n\n")
    graph = Graph()
    sensor = graph.add(VisionSensor("v0", width=320, height=240, takes_external_pictures=True)).handle
    with LegacyServer(Simulator(graph)) as server:
        with Connection.to("127.0.0.1", server.port) as connection:
            connection.call(requests.set_colour_image(sensor, bytes(range(256)) * 900))
            array_ms = median_ms(lambda: connection.call(requests.colour_image(sensor)))
        client = simx.simxStart("127.0.0.1", server.port, True, True, 5000, 5)
        list_ms = median_ms(lambda: simx.simxGetVisionSensorImage(client, sensor, 0, simx.simx_opmode_blocking))
        simx.simxFinish(client)
    print_table(
        ["320 × 240, colour", "median"],
        [["client, array", f"{array_ms:.1f} ms"], ["simxGetVisionSensorImage, list", f"{list_ms:.1f} ms"]],
    )
    return int(array_ms > BOUND_MS)


if __name__ == "__main__":
    sys.exit(main())
