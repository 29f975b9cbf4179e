"""The agent: the part of a deploy that runs on the robot. The client sends the agent's source code with each call.

The client is the program on the user's computer. `robotcore.deploy.agent.rpc` answers its calls. systemd starts
`robotcore.deploy.agent.service`.

The agent imports only Python's standard library and itself. So it works on a robot without a working release.
"""

sources: dict[str, str] = {}
"""The source text of each module by its path, ``robotcore/deploy/agent/…``. It is empty outside of a call."""
