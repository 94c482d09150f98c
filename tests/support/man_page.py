"""A manual page has all that the parsers of its program tell."""

import re
import subprocess

OPTION = re.compile(r"^ {2,6}(?:-[\w?](?: \S+)?, )?(--[\w-]+)", re.M)
LISTED = re.compile(r"^ {2,4}((?:[a-z]+, )*[a-z][\w-]*)\b.*? {2}\S", re.M)  # a command, or several, and what it does
WITH_COMMANDS = {"tribo-design", "tribo-identify", "tribo-link", "tribo-sim"}


def help_of(program, *command):
    done = subprocess.run([str(program), *command, "--help"], capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 0, f"{program} {command}: {done.stdout}{done.stderr}"
    return done.stdout


def check(program, page):
    """`program` is its path, `page` that of its page: each option and each command, and each command's own options in its section."""
    text = page.read_text(encoding="utf-8").replace("\\-", "-")
    name = program.name
    assert text.startswith(f".TH {name.upper()} 1 ") and f".SH NAME\n{name} - " in text, text[:200]
    sections = {part.partition("\n")[0]: part for part in text.split("\n.SH ")}
    whole = help_of(program)
    assert_options(page, whole, sections["DESCRIPTION"])
    commands = {command for listed in LISTED.findall(whole.partition("\noptions:")[0]) for command in listed.split(", ")}
    assert bool(commands) == (name in WITH_COMMANDS) and (OPTION.search(whole) or commands), (name, commands)
    for command in commands:
        assert re.search(rf"^\.B (?:\w+, )*{command}\b", sections["DESCRIPTION"], re.M), f"{page}: no {command}"
        own = help_of(program, command)
        assert OPTION.search(own), own
        section = sections.get(command.upper()) if name != "tribo-link" else sections["DESCRIPTION"]  # which has all options together
        assert section, f"{page}: {command} has no section"
        assert_options(f"{page}: {command}", own, section)
    for word in re.findall(r"^  ([A-Z][\w.|]*)\b", whole, re.M):
        assert f".B {word}" in sections["DESCRIPTION"], f"{page}: no {word}"


def assert_options(where, told, section):
    options = OPTION.findall(told)
    missing = [option for option in options if not re.search(rf"^\.B (?:-\S+ )?{option}(?![\w-])", section.replace(", --", " --"), re.M)]
    assert not missing, f"{where}: no {missing}"
