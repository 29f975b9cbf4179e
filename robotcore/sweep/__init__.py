"""One app in many worlds: every backend, world and seed of a sweep, on all cores or on a cluster."""
