"""The shipped adversaries, one file each: what they say instead of what their brain would say."""
