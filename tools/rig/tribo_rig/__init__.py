"""From a rig to a tuned force loop, step by step in a folder: plays nothing itself, only writes what to play."""
