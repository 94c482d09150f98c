#!/usr/bin/env python3
"""A manual page of a program and its commands, made of what their parsers print: cmake/man.py NAME SUMMARY MORE PROGRAM... > NAME.1

MORE is a file with what goes behind the options, in roff, or "". An emulator or an interpreter comes before the program.
"""

import os
import pathlib
import re
import subprocess
import sys

UNBROKEN = {**os.environ, "ARGP_HELP_FMT": "rmargin=2000", "COLUMNS": "2000"}
OPTION = re.compile(r"^ {2,6}((?:-[\w?], )?--[\w-]+(?:\[?[= ]\S+)?|-\w(?: \S+)?, --[\w-]+(?: \S+)?)(?: {2,}(.*))?$")
CHOICE = re.compile(r"^  \{([\w,-]+)\}$")  # argparse's line of all commands
COMMAND = re.compile(r"^  ([a-z]+) {2,}\S")  # tribo-sim's of one
TEXT_AT = " " * 18  # where an option too long for its line, or one with more lines than one, has its text
HEADINGS = {"positional arguments:", "options:"}
BOILERPLATE = "Mandatory or optional arguments to long options"
OTHERS = ("tribo-drive", "tribo-link", "tribo-sim")


def help_of(*command):
    return subprocess.run([*command, "--help"], capture_output=True, text=True, check=True, env=UNBROKEN).stdout.splitlines()


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def body(lines):
    """Options, and what has a text beside it, as tagged paragraphs; all else as text."""
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
    """What the help of a program with commands lists; tribo-link's stand in its help with all their options."""
    chosen = [match[1].split(",") for line in lines if (match := CHOICE.match(line))]
    if chosen:
        return chosen[0]
    return [match[1] for line in lines if (match := COMMAND.match(line))] if "COMMAND [" in lines[0] else []


def main():
    name, summary, more, *program = sys.argv[1:]
    lines = help_of(*program)
    page = [f'.TH {name.upper()} 1 "" tribo "User commands"', ".nh", ".ad l",  # an option is not to be broken
            ".SH NAME", f"{name} \\- {roff(summary)}", ".SH SYNOPSIS", *usage(lines), ".SH DESCRIPTION", *body(lines[1:])]
    for command in commands_of(lines):
        lines = help_of(*program, command)
        end = next((i for i, line in enumerate(lines) if line.startswith(("Targets:", "The folders"))), len(lines))  # of all commands
        page += [f".SH {command.upper()}", *usage(lines), *body(lines[1:end])]
    page += [pathlib.Path(more).read_text(encoding="utf-8").rstrip("\n")] if more else []
    others = [other for other in OTHERS if other != name]
    print("\n".join([*page, ".SH SEE ALSO", *(f".BR {other} (1)," for other in others[:-1]), f".BR {others[-1]} (1)"]))


main()
