"""synthetic.py puts the tools on the path; each run of tribo-sim is in a folder of its own."""

import synthetic  # noqa: F401
