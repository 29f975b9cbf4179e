"""OpenGL without a screen, whichever kind of it works here."""

from drivers.mujoco.opengl.choosing import named_to_mujoco, open_context
from drivers.mujoco.opengl.context import Context, NoOpenGL

__all__ = ["Context", "NoOpenGL", "named_to_mujoco", "open_context"]
