"""The beginning of the script that the robot's Python reads from stdin. It imports the agent and answers one call.

`robotcore.deploy.rpc` sends this module as text, followed by a call of `answer_call`. Every Python 3 must be able to
parse this module, so that a Python that is too old answers with an error message.
"""

import json
import os
import select
import signal
import sys
import threading
from importlib.abc import ExecutionLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader

MIN_PYTHON = (3, 10)

INTERRUPT_PERIOD_S = 3.0
"""The time between two interrupts of a call whose client has disconnected, in s."""


class MemoryImporter(MetaPathFinder, ExecutionLoader):
    """Imports the agent's modules from memory, so that a call works even if the robot's disk is full."""

    def __init__(self, sources: "dict[str, str]") -> None:
        self._sources = sources

    def find_spec(self, name: str, path: object = None, target: object = None) -> "ModuleSpec | None":
        return spec_from_loader(name, self) if self.get_filename(name) in self._sources else None

    def is_package(self, name: str) -> bool:
        return name.replace(".", "/") + "/__init__.py" in self._sources

    def get_filename(self, name: str) -> str:
        return name.replace(".", "/") + ("/__init__.py" if self.is_package(name) else ".py")

    def get_source(self, name: str) -> str:
        return self._sources[self.get_filename(name)]


def answer_call(sources: str, action: str, parameters: str) -> int:
    """Run one action of the agent, send its answer to the client, and return the exit status.

    sources: the source text of each module of the agent by its path, in JSON.
    action: the name of the action in the protocol.
    parameters: the action's parameters by name, in JSON.
    """
    _write({"begun": action})
    if sys.version_info < MIN_PYTHON:
        _write({"refused": _too_old(sys.version.split()[0])})
        return 1
    _watch_connection()
    modules = json.loads(sources)
    sys.meta_path.insert(0, MemoryImporter(modules))
    from robotcore.deploy import agent
    from robotcore.deploy.agent.rpc import answer_call as answer

    agent.sources.update(modules)
    return answer(action, json.loads(parameters))


def _too_old(version: str) -> "dict[str, str]":
    oldest = ".".join(map(str, MIN_PYTHON))
    return {
        "problem": "its Python is " + version + ", robotcore needs " + oldest + " or newer",
        "remedy": "Raspberry Pi OS 12 (Bookworm) and newer have it",
        "kind": "python",
    }


def _write(message: object) -> None:
    sys.stdout.write("\x1e" + json.dumps(message) + "\n")
    sys.stdout.flush()


def _watch_connection() -> None:
    """Start a thread that interrupts this process and its children when the client closes the connection."""
    if os.getpgrp() != os.getpid():
        os.setpgid(0, 0)
    threading.Thread(target=_interrupt_when_closed, daemon=True).start()


def _interrupt_when_closed() -> None:
    poll = select.poll()
    poll.register(sys.stdout.fileno(), 0)
    poll.poll()
    while True:  # repeated, because a wait that begins just after an interrupt goes on
        os.killpg(0, signal.SIGINT)
        threading.Event().wait(INTERRUPT_PERIOD_S)
