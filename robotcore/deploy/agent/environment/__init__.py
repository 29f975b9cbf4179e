"""What pip installs for a release, and how its failures are told."""
