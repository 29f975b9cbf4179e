"""The live page of a run: a web page that shows the robot and stops it."""
