"""Recorded sessions of a real server, played to a double: where its replies differ."""
