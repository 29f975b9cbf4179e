"""Whom to reach, by one ssh connection, and how it is told where that fails."""
