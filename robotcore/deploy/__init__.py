"""A project put on a robot by ssh and kept running there: from the desk (this package), and on the robot (aboard)."""
