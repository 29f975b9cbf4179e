"""What a release needs besides the code."""
