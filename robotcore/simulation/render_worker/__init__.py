"""A process that renders pictures on another core, from their capture until they are read."""

from robotcore.simulation.render_worker.client import PictureQueue, RenderWorker, has_free_core

__all__ = ["PictureQueue", "RenderWorker", "has_free_core"]
