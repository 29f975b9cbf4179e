"""The part of a deploy that runs on the robot. The client sends its source code with each call.

The client is the user's computer. `robotcore.deploy.agent.rpc` answers its calls. systemd starts
`robotcore.deploy.agent.service`.

This package imports only Python's standard library and itself. So it works on a robot that has no release, or a broken
one.
"""

sources: dict[str, str] = {}
"""The source text of each module by its path, ``robotcore/deploy/agent/…``. Empty unless a call sent the sources."""
