"""What is put on the robot: being sent, in place, on the way out, and what is known of each."""
