"""A service as ``simRemoteApi.start`` makes it in a scene's script, like 19999: it dies when the simulation stops."""

from __future__ import annotations

import threading

from tests.doubles.coppeliasim.legacy.codec import PACKET_SIZE
from tests.doubles.coppeliasim.legacy.service import Service
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State

LAST_WORD_S = 0.2
"""Who has a question on the way when the simulation stops is answered, if it comes within this time."""


class TemporaryService(Service):
    """A service that ends with the run it was started in, or with the next one if none is under way."""

    def __init__(self, simulator: Simulator, port: int = 0, packet_size: int = PACKET_SIZE) -> None:
        super().__init__(simulator, port, packet_size)
        self._watcher = threading.Thread(target=self._end_with_the_run, name=f"end of {self.port}", daemon=True)
        self._watcher.start()

    def close(self) -> None:
        super().close()
        with self._simulator.lock:
            self._simulator.changed.notify_all()
        if self._watcher is not threading.current_thread():
            self._watcher.join()

    def _end_with_the_run(self) -> None:
        with self._simulator.lock:
            self._simulator.changed.wait_for(lambda: self._is_over or self._simulator.state is not State.STOPPED)
            self._simulator.changed.wait_for(lambda: self._is_over or self._simulator.state is State.STOPPED)
        self._is_over = True
        self._stop_listening()
        self._thread.join(LAST_WORD_S)
        self.close()
