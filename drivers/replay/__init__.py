"""A recorded run as a robot."""
