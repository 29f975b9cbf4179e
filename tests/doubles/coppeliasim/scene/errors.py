"""What a scene refuses, in the words of the real server."""

from __future__ import annotations


class SceneError(Exception):
    """A call that the simulator refuses; its text is what a client is told."""


class NoObjectError(SceneError, LookupError):
    """There is no object with that handle."""

    def __init__(self, what: str = "object does not exist.") -> None:
        super().__init__(what)
