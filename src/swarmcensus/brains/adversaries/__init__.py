"""The adversaries that come with swarmcensus, a file each: what they say in place of what their brain would say."""
