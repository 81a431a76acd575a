"""The shipped brains, one file each."""
