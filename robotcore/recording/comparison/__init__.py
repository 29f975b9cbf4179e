"""Two recordings side by side: the same app in simulation and on the robot, before a change and after it."""

from robotcore.recording.comparison.comparison import Comparison, Parting
from robotcore.recording.comparison.side import Side

__all__ = ["Comparison", "Parting", "Side"]
