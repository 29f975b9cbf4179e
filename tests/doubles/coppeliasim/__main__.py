"""The double as a process: a CoppeliaSim without a window, with both of its remote APIs.

python -m tests.doubles.coppeliasim --robot rover --world arena --seed 7
"""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Sequence

from robotcore.description import draw_world, load_robot, load_world
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene, described_scene, relay_scene

SCENES = {"default": default_scene, "bubblerob": bubblerob_scene, "relay": relay_scene}


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve until SIGTERM or SIGINT. The first line of the output names the ports."""
    signals = {signal.SIGTERM, signal.SIGINT}
    signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    options = _create_parser().parse_args(arguments)
    with Double(_create_scene(options), options.zmq_port, options.legacy_port) as double:
        sys.stdout.write(f"coppeliasim double: zmq {double.zmq_port}, legacy {double.legacy_port}\n")
        sys.stdout.flush()
        signal.sigwait(signals)


def _create_scene(options: argparse.Namespace) -> Simulator:
    if options.robot is None:
        return SCENES[options.scene]()
    robot, world = load_robot(options.robot), load_world(options.world)
    return described_scene(robot, world if options.seed is None else draw_world(world, robot, options.seed))


def _create_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m tests.doubles.coppeliasim",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--zmq-port", type=int, default=23000, help="the port; 0 for any free port")
    parser.add_argument("--legacy-port", type=int, default=19997, help="the port; 0 for any free port")
    parser.add_argument("--scene", choices=SCENES, default="default", help="a scene")
    parser.add_argument("--robot", help="the name or file of a robot; its scene replaces --scene")
    parser.add_argument("--world", default="arena", help="the world around this robot")
    parser.add_argument("--seed", type=int, help="the seed of the world; None for its file")
    return parser


if __name__ == "__main__":
    main()
