"""What a way to OpenGL has to offer."""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import ClassVar


class NoOpenGL(Exception):  # noqa: N818  the fact, which its catcher makes an error of
    """This way to OpenGL is not to be had on this machine; the message says what is missing."""


class Context(ABC):
    """OpenGL that draws into memory. A constructor raises NoOpenGL where there is none.

    Between two uses it belongs to no thread, so that any thread may have the next. ``name`` is what MuJoCo calls its
    kind, in the environment variable MUJOCO_GL; ``packages`` of Debian's bring it.
    """

    name: ClassVar[str]
    packages: ClassVar[str]

    @classmethod
    def refusal(cls, why: str) -> NoOpenGL:
        """Return why it does not draw, and what to do where it is not the only OpenGL of the program."""
        beside = f"Where the program has a window or a renderer of its own, set MUJOCO_GL={cls.name}"
        return NoOpenGL(f"{why}. {beside}")

    @abstractmethod
    def current(self) -> AbstractContextManager[None]:
        """Let this thread draw here; what it drew to before is given back to it. Raises NoOpenGL."""

    @abstractmethod
    def address_of(self, function: str) -> int | None:
        """Return where one of OpenGL's functions is."""

    @abstractmethod
    def close(self) -> None:
        """Let it go. May be called again."""


def loaded(names: Sequence[str]) -> ctypes.CDLL:
    """Return the first of these libraries that is there, all of whose functions MuJoCo finds too."""
    for name in names:
        try:
            return ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
        except OSError:  # noqa: PERF203  the next may be there
            continue
    raise NoOpenGL(f"{names[0]} is not installed")
