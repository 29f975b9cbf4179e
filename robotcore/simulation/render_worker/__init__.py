"""A process that renders pictures on another core, from their capture until they are read."""

from robotcore.simulation.render_worker.client import RenderWorker, has_free_core
from robotcore.simulation.render_worker.picture_queue import PictureQueue

__all__ = ["PictureQueue", "RenderWorker", "has_free_core"]
