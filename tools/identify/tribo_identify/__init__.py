"""Finds friction parameters from logs of a rig."""
