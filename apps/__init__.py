"""The apps that come with robotcore. Each imports robotcore only."""
