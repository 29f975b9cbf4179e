"""The hardware abstraction layer for apps and drivers: devices, clocks, the drive, the robot and the backend."""
