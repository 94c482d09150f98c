"""The version that every program of the project names: that of the library's headers."""

import pathlib
import re

VERSION = re.search(r'TRIBO_VERSION_STRING "(.*)"', (pathlib.Path(__file__).parents[2] / "lib/include/tribo/status.h").read_text(encoding="utf-8"))[1]
