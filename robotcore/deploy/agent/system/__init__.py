"""The robot's own system, with nothing of a release in it: its disk, processes, users, and what it must have."""
