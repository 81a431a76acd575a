"""The metrics that come with swarmcensus, a file each."""
