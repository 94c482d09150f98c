"""From a rig to a tuned force loop, step by step in a folder. It plays nothing itself; it writes the files to play."""
