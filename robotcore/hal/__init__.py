"""What apps and drivers are written against: devices, clocks, the drive, the robot and the backend."""
