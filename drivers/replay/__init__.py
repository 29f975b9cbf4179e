"""The backend that replays a recorded run as a robot."""
