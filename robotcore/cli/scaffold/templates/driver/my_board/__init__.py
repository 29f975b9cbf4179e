"""A backend of robotcore for robots on my-board."""
