"""The first code that the robot's Python reads from stdin: import the agent from memory and answer one call.

`robotcore.deploy.rpc` sends it as text, followed by a call of `answer_call`. Any Python 3 must be able to
parse it, so that an old one can refuse the call with a message.
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

OLDEST = (3, 10)

AGAIN_S = 3.0
"""So much later a call that has not ended is interrupted again."""


class InMemory(MetaPathFinder, ExecutionLoader):
    """Modules of which only the source is there, by its file: no disk need have room for them."""

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


def answer_call(sources: str, action: str, told: str) -> int:
    """Take modules aboard and answer the desk's call: their sources and what it is told in JSON; return the status."""
    _write({"begun": action})
    if sys.version_info < OLDEST:
        _write({"refused": _too_old(sys.version.split()[0])})
        return 1
    _end_with_the_desk()
    taken = json.loads(sources)
    sys.meta_path.insert(0, InMemory(taken))
    from robotcore.deploy import agent
    from robotcore.deploy.agent.rpc import answer_call as answer

    agent.sources.update(taken)
    return answer(action, json.loads(told))


def _too_old(version: str) -> "dict[str, str]":
    oldest = ".".join(map(str, OLDEST))
    return {
        "fault": "its Python is " + version + ", robotcore needs " + oldest + " or newer",
        "remedy": "Raspberry Pi OS 12 (Bookworm) and newer have it",
        "kind": "python",
    }


def _write(told: object) -> None:
    sys.stdout.write("\x1e" + json.dumps(told) + "\n")
    sys.stdout.flush()


def _end_with_the_desk() -> None:
    """Interrupt whatever this call has started as soon as nobody reads what it writes: the desk has gone."""
    if os.getpgrp() != os.getpid():
        os.setpgid(0, 0)
    threading.Thread(target=_interrupt_when_alone, daemon=True).start()


def _interrupt_when_alone() -> None:
    poll = select.poll()
    poll.register(sys.stdout.fileno(), 0)
    poll.poll()
    while True:  # one that comes just before a wait begins is not heard in it
        os.killpg(0, signal.SIGINT)
        threading.Event().wait(AGAIN_S)
