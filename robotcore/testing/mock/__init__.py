"""A robot for unit tests of apps. It plays scripted readings, records commands, and its clock advances by ticks."""
