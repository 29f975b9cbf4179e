"""Code that several drivers of simulators use."""
