"""The kinds of devices. Each module holds one kind; other packages register theirs as entry points."""
