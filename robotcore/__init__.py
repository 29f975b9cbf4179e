"""Write a robot's behaviour once, prove it in simulation, run the same file on the robot."""
