"""The ZeroMQ remote API of a simulator: its protocol, and the ``sim`` functions by name."""

from tests.doubles.coppeliasim.zmq.server import ZmqServer

__all__ = ["ZmqServer"]
