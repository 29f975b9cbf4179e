"""A server with scripted answers, and robots for existing scenes."""

from __future__ import annotations

import threading
from collections.abc import Callable

import zmq

from robotcore.description import RobotDescription, load_robot
from robotcore.kinds.display import DisplayDescription


class ScriptedServer:
    """A ZeroMQ server, as a context manager. It answers each message with the result of the function ``reply``."""

    def __init__(self, reply: Callable[[bytes], bytes]) -> None:
        self.reply = reply
        self._is_closing = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="scripted server", daemon=True)

    def __enter__(self) -> ScriptedServer:
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.linger = 0
        self.port = self._socket.bind_to_random_port("tcp://127.0.0.1")
        self._thread.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._is_closing.set()
        self._thread.join()
        self._socket.close()
        self._context.term()

    def _serve(self) -> None:
        while not self._is_closing.is_set():
            if self._socket.poll(20):
                *route, message = self._socket.recv_multipart()
                self._socket.send_multipart([*route, self.reply(message)])


def load_joined_robot(name: str) -> RobotDescription:
    """Load a shipped robot for a scene of the double, in which each object has the name of its device."""
    robot = load_robot(name)
    devices = [device.name for device in robot.devices if not isinstance(device, DisplayDescription)]
    section = {device: {"path": f"/{name}/{device.replace('encoder', 'motor')}"} for device in devices}
    return robot.model_copy(update={"backends": {"coppeliasim": section}})
