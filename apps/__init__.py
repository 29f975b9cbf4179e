"""Behaviours; each knows robotcore only."""
