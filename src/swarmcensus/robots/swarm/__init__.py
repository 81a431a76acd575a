"""A swarm of real processes that talk over sockets: started, disturbed, watched and ended.

In: a setting of a study, and what is to happen to its robots.
Out: a folder with each robot's log, and what the swarm was.
Must not know: how its logs are read and lived again.
"""
