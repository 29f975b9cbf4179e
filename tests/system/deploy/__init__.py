"""System checks of a deploy: a Debian that systemd boots, as the robot."""
