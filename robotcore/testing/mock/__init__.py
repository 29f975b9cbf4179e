"""A robot for unit tests of apps: scripted readings, recorded commands, a clock that the test steps."""
