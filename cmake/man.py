#!/usr/bin/env python3
"""Makes a manual page of a program and its commands from the help of their parsers: cmake/man.py NAME SUMMARY MORE PROGRAM... > NAME.1

MORE is a roff file that follows the options, or "". An emulator or an interpreter goes before the program.
"""

import os
import pathlib
import re
import subprocess
import sys

UNBROKEN = {**os.environ, "ARGP_HELP_FMT": "rmargin=2000", "COLUMNS": "2000"}
OPTION = re.compile(r"^ {2,6}((?:-[\w?], )?--[\w-]+(?:\[?[= ]\S+)?|-\w(?: \S+)?, --[\w-]+(?: \S+)?)(?: {2,}(.*))?$")
CHOICE = re.compile(r"^  \{([\w,-]+)\}$")  # the line in which argparse lists the commands
COMMAND = re.compile(r"^  ([a-z]+) {2,}\S")  # the line in which tribo-sim lists one command
TEXT_AT = " " * 18  # indent of the text of an option that is too long for its line, or that has several lines
HEADINGS = {"positional arguments:", "options:"}
BOILERPLATE = "Mandatory or optional arguments to long options"
OTHERS = ("tribo-drive", "tribo-link", "tribo-sim")


def help_of(*command):
    return subprocess.run([*command, "--help"], capture_output=True, text=True, check=True, env=UNBROKEN).stdout.splitlines()


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def body(lines):
    """Formats options, and other words with a text, as tagged paragraphs, and other lines as text."""
    out, is_tagged, is_text = [], False, False
    for line in lines:
        option = OPTION.match(line)
        if option:
            out += [".TP", f".B {roff(option[1])}", *([roff(option[2])] if option[2] else [])]
        elif is_tagged and line.startswith(TEXT_AT):
            out.append(roff(line.strip()))
        elif line.startswith("  ") and not CHOICE.match(line):
            name, _, text = line.strip().partition("  ")
            out += [".TP", f".B {roff(name)}", *([roff(text.strip())] if text else [])]
        elif line.strip() and not line.startswith((" ", BOILERPLATE)) and line not in HEADINGS:
            out += ([] if is_text else [".PP"]) + [roff(line)]
        is_text = bool(line.strip()) and not line.startswith(" ")
        is_tagged = line.startswith("  ")
    return out


def usage(lines):
    return [roff(lines[0].partition(": ")[2])]


def commands_of(lines):
    """Returns the commands that a program's help lists. Not for tribo-link, whose help has its commands with all their options."""
    chosen = [match[1].split(",") for line in lines if (match := CHOICE.match(line))]
    if chosen:
        return chosen[0]
    return [match[1] for line in lines if (match := COMMAND.match(line))] if "COMMAND [" in lines[0] else []


def main():
    name, summary, more, *program = sys.argv[1:]
    lines = help_of(*program)
    page = [f'.TH {name.upper()} 1 "" tribo "User commands"', ".nh", ".ad l",  # does not break options
            ".SH NAME", f"{name} \\- {roff(summary)}", ".SH SYNOPSIS", *usage(lines), ".SH DESCRIPTION", *body(lines[1:])]
    for command in commands_of(lines):
        lines = help_of(*program, command)
        end = next((i for i, line in enumerate(lines) if line.startswith(("Targets:", "The folders"))), len(lines))  # the part that all commands share
        page += [f".SH {command.upper()}", *usage(lines), *body(lines[1:end])]
    page += [pathlib.Path(more).read_text(encoding="utf-8").rstrip("\n")] if more else []
    others = [other for other in OTHERS if other != name]
    print("\n".join([*page, ".SH SEE ALSO", *(f".BR {other} (1)," for other in others[:-1]), f".BR {others[-1]} (1)"]))


main()
