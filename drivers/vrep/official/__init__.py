"""The official binding in the place of ours, for users who have one and want to keep it."""
