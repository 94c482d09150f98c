"""From logs of a rig to friction parameters."""

__version__ = "0.1.0"
