"""A run of an app: behaviour, request and plan, session, loop, and result."""
