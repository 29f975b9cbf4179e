"""A robot for unit tests of apps: its sensors return scripted readings, and its motors record their commands."""
