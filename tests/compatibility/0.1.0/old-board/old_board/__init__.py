"""A backend of robotcore for robots on old-board."""
