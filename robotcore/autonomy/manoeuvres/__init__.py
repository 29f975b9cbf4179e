"""Manoeuvres: routines that drive a robot by a distance, an angle or to a place, and end when it stands there."""

from robotcore.autonomy.manoeuvres.absolute import face, follow_path, go_to
from robotcore.autonomy.manoeuvres.relative import arc, straight, turn
from robotcore.autonomy.manoeuvres.velocity import move

__all__ = ["arc", "face", "follow_path", "go_to", "move", "straight", "turn"]
