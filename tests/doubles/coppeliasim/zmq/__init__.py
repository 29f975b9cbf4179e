"""The ZeroMQ remote API of a simulator: its protocol and its ``sim`` functions."""

from tests.doubles.coppeliasim.zmq.server import ZmqServer

__all__ = ["ZmqServer"]
