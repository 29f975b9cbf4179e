"""What is right and what is wrong with this machine, before a robot is to move: findings, each with its remedy."""

from robotcore.doctor.checks import Check, findings_of
from robotcore.doctor.finding import Finding, Level

__all__ = ["Check", "Finding", "Level", "findings_of"]
