#!/usr/bin/env python3
"""Writes docs/user/commands.md from the programs' own --help.

  python3 docs/generate_references.py --binaries build/release/bin           writes the page
  python3 docs/generate_references.py --binaries build/release/bin --check   exit 1 when the page is not what they print

A program that is not in the folder keeps the section it has: a build without the window can still write the page.
"""
import argparse
import difflib
import pathlib
import re
import subprocess
import sys
import textwrap

COLUMNS = 120  # of the documents
PROGRAMS = {
    "retractor": "The command line.",
    "retractor-workstation": "The window; see [the workstation](workstation.md).",
    "retractor-verify": "Problems with known answers; see [verification](../method/verification.md).",
    "retractor-bench": "Measurements of speed and quality; see [benchmarks](../developer/benchmarks.md).",
}
HEAD = """# Commands

This page is generated from the programs' own `--help` by `docs/generate_references.py`; do not edit it by hand.

Options that every command of `retractor` has: `--json` prints one JSON document to standard output and nothing else
there, `--profile` lists the parts built with time and memory, `--threads N` limits the threads. They may stand before
or after the command. Progress goes to standard error: one line on a terminal, at most one line every half
minute in a log.

Exit codes: 0 done, 1 it failed or the answer is a refusal, 2 wrong usage or bad input.
"""


class HelpError(Exception):
    """A program that does not print its help."""


def help_of(program, words):
    """What `program words... --help` prints. Raises HelpError on another exit code than 0."""
    run = subprocess.run([str(program), *words, "--help"], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                         check=False, timeout=120)
    if run.returncode != 0:
        raise HelpError(f"{program.name} {' '.join(words)} --help: exit code {run.returncode}: {run.stderr.strip()}")
    return run.stdout


def subcommands_of(text):
    """Names below "Subcommands:" in a help text, in its order."""
    names = []
    inside = False
    for line in text.splitlines():
        if re.match(r"^\S.*:$", line):
            inside = line in ("Subcommands:", "SUBCOMMANDS:")
        elif inside and (match := re.match(r"^  ([a-z][a-z0-9-]*)(\s|$)", line)):
            names.append(match.group(1))
    return names


def wrapped(line):
    """The line in lines of at most COLUMNS, the later ones below the description of an option."""
    described = re.match(r"^ *\S.*? {2,}(?=\S)", line)
    indent = described.end() if described else len(line) - len(line.lstrip())
    return textwrap.wrap(line, COLUMNS, subsequent_indent=" " * indent, break_long_words=False,
                         break_on_hyphens=False) or [""]


def command_sections(program, words=()):
    """Markdown of a command and of those below it."""
    text = help_of(program, words)
    text = text.replace(str(program), program.name)
    tidy = "\n".join(part for line in text.strip().splitlines() for part in wrapped(line.rstrip()))
    parts = [f"```text\n{tidy}\n```\n"]
    for name in subcommands_of(text):
        path = (*words, name)
        parts.append(f"{'#' * (2 + len(path))} {program.name} {' '.join(path)}\n")
        parts += command_sections(program, path)
    return parts


def sections_of(page):
    """Text per program of a page written before."""
    found = {}
    for block in re.split(r"^(?=## )", page, flags=re.M)[1:]:
        found[block.split("\n", 1)[0][3:].strip()] = block.rstrip("\n") + "\n"
    return found


def make_page(binaries, old_page):
    """The page, and the programs whose section could only be kept."""
    old = sections_of(old_page)
    kept = []
    parts = [HEAD]
    for name, about in PROGRAMS.items():
        program = binaries / name
        if program.exists():
            parts.append("\n".join([f"## {name}\n\n{about}\n", *command_sections(program)]))
        else:
            kept.append(name)
            if name in old:
                parts.append(old[name])
    return "\n".join(parts), kept


def main():
    parser = argparse.ArgumentParser(description="Writes docs/user/commands.md from the programs' own --help.")
    parser.add_argument("--binaries", type=pathlib.Path, required=True, help="folder with the programs")
    parser.add_argument("--page", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parent / "user" / "commands.md")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when the page would change")
    options = parser.parse_args()
    if not (options.binaries / "retractor").exists():
        parser.error(f"there is no retractor in {options.binaries}")
    old = options.page.read_text() if options.page.exists() else ""
    try:
        page, kept = make_page(options.binaries.resolve(), old)
    except HelpError as error:
        sys.exit(f"generate_references.py: {error}")
    for name in kept:
        print(f"{name} is not in {options.binaries}: its section is kept", file=sys.stderr)
    if not options.check:
        options.page.write_text(page)
    elif page != old:
        sys.stdout.writelines(difflib.unified_diff(old.splitlines(True), page.splitlines(True), str(options.page),
                                                   "what the programs print now", n=1))
        sys.exit(1)


if __name__ == "__main__":
    main()
