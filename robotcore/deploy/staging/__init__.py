"""What of a project is sent, put together at the desk."""
