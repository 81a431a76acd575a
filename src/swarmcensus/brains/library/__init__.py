"""The brains that come with swarmcensus, a file each."""
