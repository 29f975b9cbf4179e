"""The disturbances of runs that are recorded and replayed."""
