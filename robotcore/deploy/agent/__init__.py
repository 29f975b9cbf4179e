"""What works on the robot: Python's standard library alone, sent there as source with each call.

Nothing here imports anything of robotcore's outside this package, so that it works where no release is installed, or a
broken one. `robotcore.deploy.agent.rpc` takes the desk's calls; `robotcore.deploy.agent.service` is what
systemd starts.
"""

sources: dict[str, str] = {}
"""The texts of this package by path, ``robotcore/deploy/agent/…``, as they came with the call; empty elsewhere."""
