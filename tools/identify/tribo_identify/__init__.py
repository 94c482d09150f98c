"""From logs of a rig to friction parameters."""
