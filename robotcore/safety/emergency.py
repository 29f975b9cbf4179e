"""The e-stop."""

from __future__ import annotations

from robotcore.errors import EmergencyStopError
from robotcore.safety.latch import Latch


class EmergencyStop:
    """A big red button: whoever holds it can press it, from any thread, and no app can undo it.

    >>> latch = Latch()
    >>> EmergencyStop(latch).press("the button on the bench was pressed")
    >>> str(latch.error)
    'e-stop: the button on the bench was pressed'
    """

    def __init__(self, latch: Latch) -> None:
        self._latch = latch

    def press(self, how: str) -> None:
        """Stop every motor at once, for good; the run ends as stopped, with ``how`` it came to that."""
        self._latch.set(EmergencyStopError(how))
