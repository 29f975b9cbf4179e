"""What a project imports: brought from the desk, or installed by pip on the robot."""
