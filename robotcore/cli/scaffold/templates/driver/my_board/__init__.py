"""A backend for robotcore: robots whose motors and sensors are on my-board."""
