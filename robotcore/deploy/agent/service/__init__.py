"""How the app of the release in place is kept running: by systemd, from the robot's start on."""
