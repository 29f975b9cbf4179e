"""What the present code must still do with the files of each released version, one folder a version."""
