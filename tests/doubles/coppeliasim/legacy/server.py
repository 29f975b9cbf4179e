"""The legacy server as a whole: continuous services that live as long as it, temporary ones that die with a stop."""

from __future__ import annotations

from contextlib import ExitStack
from types import TracebackType

from tests.doubles.coppeliasim.legacy.service import Service
from tests.doubles.coppeliasim.legacy.temporary import TemporaryService
from tests.doubles.coppeliasim.scene.pacing import Pacer
from tests.doubles.coppeliasim.scene.simulator import Simulator


class LegacyServer:
    """Serves a simulator over the legacy remote API; a context manager. ``port`` 0 takes a free one.

    The service it begins with is continuous, like 19997 of an installation. Time passes by itself while nobody steps;
    where somebody else sees to that, ``paces`` is False.

    >>> with LegacyServer(Simulator()) as server:
    ...     server.port > 0
    True
    """

    def __init__(self, simulator: Simulator, port: int = 0, *, paces: bool = True) -> None:
        self._simulator, self._asked_port = simulator, port
        self._paces = paces
        self._open = ExitStack()

    def __enter__(self) -> LegacyServer:
        if self._paces:
            self._open.enter_context(Pacer(self._simulator))
        self.service = Service(self._simulator, self._asked_port)
        self._open.callback(self._close_service)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    @property
    def port(self) -> int:
        """The port of the continuous service."""
        return self.service.port

    def close(self) -> None:
        """End every service."""
        self._open.close()

    def restart(self) -> None:
        """Be a new process on the same port: the client of the old one is cut off."""
        self.service.close()
        self.service = Service(self._simulator, self.port)

    def _close_service(self) -> None:
        self.service.close()

    def start_temporary(self, port: int = 0) -> TemporaryService:
        """Start a service in the simulation that runs, as a script of its scene does."""
        service = TemporaryService(self._simulator, port)
        self._open.callback(service.close)
        return service
