"""The live page of a run: a web page that shows the robot, stops it and drives it."""
