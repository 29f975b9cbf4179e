"""What the desk can ask of a robot: a module each, named in `robotcore.deploy.agent.calls`."""
