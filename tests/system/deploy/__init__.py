"""A Debian that systemd boots, as the robot that projects are deployed to."""
