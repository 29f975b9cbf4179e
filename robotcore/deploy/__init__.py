"""Put a project on a robot by ssh and keep it running there.

``agent`` is the part that runs on the robot. The other modules are the client: they run on the user's computer.
"""
