#!/usr/bin/env python3
"""A manual page of a program and its commands, made of what their parsers print: cmake/man.py SUMMARY PROGRAM... > NAME.1"""

import os
import pathlib
import re
import subprocess
import sys

UNBROKEN = {**os.environ, "ARGP_HELP_FMT": "rmargin=2000"}
OPTION = re.compile(r"^ {2,6}((?:-\w, )?--[\w-]+(?:=\S+)?|-\w(?:, --[\w-]+)?)(?: {2,}(.*))?$")


def help_of(*command):
    return subprocess.run([*command, "--help"], capture_output=True, text=True, check=True, env=UNBROKEN).stdout.splitlines()


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def body(lines):
    """Options as tagged paragraphs, what is indented as it is, all else as text."""
    out, after_option, is_text = [], False, False
    for line in lines:
        option = OPTION.match(line)
        if option:
            out += [".TP", f".B {roff(option[1])}", *([roff(option[2])] if option[2] else [])]
        elif after_option and line.startswith(" " * 20):
            out.append(roff(line.strip()))  # of an option too long to have its text beside it
        elif line.startswith("  "):
            name, _, text = line.strip().partition("  ")
            out += [".TP", f".B {roff(name)}", roff(text.strip())] if text else [".PP", roff(name)]
        elif line.strip():
            out += ([] if is_text else [".PP"]) + [roff(line)]
        is_text = bool(line.strip()) and not line.startswith(" ")
        after_option = bool(option) or (after_option and line.startswith(" " * 20))
    return out


def usage(lines):
    return [roff(lines[0].removeprefix("Usage: "))]


def main():
    summary, *program = sys.argv[1:]  # an emulator comes before the program
    name = pathlib.Path(program[-1]).name
    lines = help_of(*program)
    commands = [line.split()[0] for line in lines if re.match(r"^  [a-z]+ {2,}\S", line)] if "COMMAND [" in lines[0] else []
    page = [f'.TH {name.upper()} 1 "" tribo "User commands"',
            ".SH NAME", f"{name} \\- {roff(summary)}", ".SH SYNOPSIS", *usage(lines), ".SH DESCRIPTION", *body(lines[1:])]
    for command in commands:
        lines = help_of(*program, command)
        end = next(i for i, line in enumerate(lines) if line.startswith(("Targets:", "The folders")))
        page += [f".SH {command.upper()}", *usage(lines), *body(lines[1:end])]
    print("\n".join([*page, ".SH SEE ALSO", *(f".BR {other} (1)" for other in ("tribo-drive", "tribo-link", "tribo-sim") if other != name)]))


main()
