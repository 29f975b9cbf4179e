"""Which way to OpenGL is taken: the first that works, or the one that the user names."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import AbstractContextManager

from drivers.mujoco.opengl.context import Context, NoOpenGL
from drivers.mujoco.opengl.egl import EglContext
from drivers.mujoco.opengl.environment import told
from drivers.mujoco.opengl.osmesa import OsmesaContext

VARIABLE = "MUJOCO_GL"
"""By which MuJoCo itself is told; MuJoCo's C library reads it too."""

WAYS: Mapping[str, type[Context]] = {way.name: way for way in (EglContext, OsmesaContext)}


def open_context() -> Context:
    """Return OpenGL that needs no screen; raises NoOpenGL, with the remedy, where there is none.

    The user may name a way by the environment variable MUJOCO_GL; then no other is tried.
    """
    named = os.environ.get(VARIABLE, "").strip().lower()
    if named and named not in WAYS:
        raise NoOpenGL(
            f"{VARIABLE} is {named!r}, which draws nothing without a window. Unset it, or set it to {' or '.join(WAYS)}"
        )
    ways = (WAYS[named],) if named else tuple(WAYS.values())
    failures = []
    for way in ways:
        try:
            return way()
        except NoOpenGL as failure:  # noqa: PERF203  every way that fails is to be told
            failures.append(str(failure))
    what = f"{VARIABLE} is {named!r}, which does not work" if named else "there is no OpenGL without a screen"
    remedy = f"On Debian: sudo apt install {', or '.join(way.packages for way in ways)}"
    raise NoOpenGL(f"{what}: {'; '.join(failures)}. {remedy}")


def named_to_mujoco(context: Context) -> AbstractContextManager[None]:
    """Let MuJoCo's C library look for OpenGL's functions where this context has them, as it does once in a process."""
    return told(VARIABLE, context.name)
