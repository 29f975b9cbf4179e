"""A complete double: a simulator whose time advances by itself, and its servers."""

from __future__ import annotations

from contextlib import ExitStack

from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.zmq import ZmqServer


class Double:
    """Serves a simulator over both protocols until it is closed; a context manager.

    simulator: the simulator.
    zmq_port, legacy_port: the ports; 0 takes a free one.

    ``legacy`` is the server of the legacy protocol. Its ``service`` can be made to fail, and it restarts on its port.

    >>> with Double(Simulator()) as double:
    ...     double.zmq_port != double.legacy_port
    True
    """

    def __init__(self, simulator: Simulator, zmq_port: int = 0, legacy_port: int = 0) -> None:
        self.simulator = simulator
        self.legacy = LegacyServer(simulator, legacy_port)
        self._zmq = ZmqServer(simulator, zmq_port)
        self._open = ExitStack()

    def __enter__(self) -> Double:
        with ExitStack() as opening:
            opening.enter_context(self._zmq)
            opening.enter_context(self.legacy)
            self._open = opening.pop_all()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._open.close()

    @property
    def zmq_port(self) -> int:
        return self._zmq.port

    @property
    def legacy_port(self) -> int:
        return self.legacy.port
