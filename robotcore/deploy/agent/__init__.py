"""The robot's side of a deploy, sent there as source with each call. It needs Python's standard library alone.

No module imports anything of robotcore outside this package, so that it works without a release, or with a broken one.
`robotcore.deploy.agent.rpc` answers the calls of the client, which is the user's computer.
systemd starts `robotcore.deploy.agent.service`.
"""

sources: dict[str, str] = {}
"""The sources of this package by path, ``robotcore/deploy/agent/…``, as a call brings them; otherwise empty."""
