"""Two recordings side by side: the same app in simulation and on the robot, before a change and after it."""

from robotcore.comparison.comparison import Comparison, Parting
from robotcore.comparison.side import Side

__all__ = ["Comparison", "Parting", "Side"]
