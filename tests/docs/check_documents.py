#!/usr/bin/env python3
"""Checks the documents (README.md, docs/, and the README of every folder), and the sources for retired words.

  python3 tests/docs/check_documents.py --root . [--binaries build/release/bin]

Without --binaries, the commands that pages show are not run. Prints one line per mistake, and exits with 1 when there
is any. docs/developer/testing.md says what is checked.
"""
import argparse
import os
import pathlib
import re
import shlex
import sys

sys.dont_write_bytecode = True  # the sources' folder stays clean
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "docs"))
import generate_references  # noqa: E402  (found by the line above)

MOST_COLUMNS = 120
README_LINES, README_COLUMNS = 120, 100
FOLDERS_WITHOUT_DOCUMENTS = {"build", "demo", "shared"}
SOURCE_FOLDERS = ("mesh", "fem", "datasets", "haptics", "planner", "ui", "tests")
TOP = (*SOURCE_FOLDERS, "docs", "cmake")
STYLE, GLOSSARY = "docs/developer/style.md", "docs/developer/glossary.md"
CASE_PAGE, COMMANDS_PAGE = "docs/user/case-json.md", "docs/user/commands.md"
RETIRED_MARK = "<!-- retired words:"
EXAMPLE_MARK = re.compile(r"<!-- the text of (\S+) -->")  # the line before a block of code


def documents(root):
    """All Markdown files, sorted; hidden folders and build folders are left alone."""
    found = []
    for folder, inside, files in os.walk(root):
        inside[:] = [d for d in inside if not d.startswith(".") and d != "node_modules"
                     and not (pathlib.Path(folder) == root and d in FOLDERS_WITHOUT_DOCUMENTS)]
        found += [pathlib.Path(folder, name) for name in files if name.endswith(".md")]
    return sorted(found)


def parts_of(text):
    """(line number, line, language of the code fence that the line is in or None), the fences' own lines left out."""
    language = None
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            language = None if language is not None else line.strip()[3:].strip()
        else:
            yield number, line, language


def without_code(line):
    return re.sub(r"`[^`]*`", "", line)


def anchors_of(text):
    """The anchors that a page's headings get, as GitHub makes them."""
    anchors = set()
    for _, line, language in parts_of(text):
        if language is None and (match := re.match(r"^#{1,6} (.+)$", line)):
            words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match.group(1)).strip().lower()
            slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
            anchors.add(next(s for s in (slug, *(f"{slug}-{n}" for n in range(1, 100))) if s not in anchors))
    return anchors


def check_widths(name, text):
    is_readme = name == "README.md"
    if is_readme and len(text.splitlines()) > README_LINES:
        yield 0, f"has more than {README_LINES} lines"
    for number, line in enumerate(text.splitlines(), 1):
        if is_readme and len(line) > README_COLUMNS:
            yield number, f"is longer than {README_COLUMNS} columns"
    for number, line, language in parts_of(text):
        if language is None and not line.startswith("|") and len(line) > MOST_COLUMNS:
            yield number, f"is longer than {MOST_COLUMNS} columns"


def check_links(root, page, text):
    for number, line, language in parts_of(text):
        if language is not None:
            continue
        for link in re.findall(r"\]\(([^)\s]+)\)", without_code(line)):
            if re.match(r"^[a-z]+:", link):
                continue
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            if not target.is_relative_to(root) or not target.exists():
                yield number, f"the link {link} leads nowhere"
            elif anchor and target.suffix == ".md" and anchor not in anchors_of(target.read_text()):
                yield number, f"the link {link} names a heading that is not there"


def check_paths(root, text, sources):
    for number, line, language in parts_of(text):
        if language is not None:
            continue
        for code in re.findall(r"`([^`]+)`", line):
            if re.fullmatch(r"[A-Za-z0-9_.-]+/[A-Za-z0-9_./-]*", code) and code.split("/")[0] in TOP:
                path = root / code
                if not path.exists() or (code.endswith("/") and not path.is_dir()):
                    yield number, f"there is no {code}"
            elif re.fullmatch(r"[a-z0-9_]+\.(h|cpp|cmake|py)", code) and code not in sources:
                yield number, f"there is no source {code}"


def check_examples(root, text):
    """A block of code below the mark of an example must be the file that the mark names, which a test builds."""
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if not (match := EXAMPLE_MARK.fullmatch(line)):
            continue
        file = root / match.group(1)
        fences = [n for n, other in enumerate(lines[number:], number) if other.startswith("```")][:2]
        if not file.is_file():
            yield number, f"there is no {match.group(1)}"
        elif len(fences) < 2 or fences[0] != number:
            yield number, "no block of code follows"
        elif lines[number + 1:fences[1]] != file.read_text().splitlines():
            yield number, f"the block of code is not the text of {match.group(1)}"


def retired_words(root):
    """(word, pages that may hold it) from the table in style.md."""
    lines = (root / STYLE).read_text().splitlines()
    start = next((n for n, line in enumerate(lines) if line.startswith(RETIRED_MARK)), None)
    if start is None:
        sys.exit(f"{STYLE}: the table of retired words has lost its mark \"{RETIRED_MARK}\"")
    words = []
    for line in lines[start:]:
        cells = re.split(r"(?<!\\)\|", line)
        if len(cells) == 5:
            words += [(word, re.findall(r"`([^`]+)`", cells[3])) for word in re.findall(r"`([^`]+)`", cells[1])]
    if not words:
        sys.exit(f"{STYLE}: the table of retired words is empty")
    return words


def check_words(name, text, words):
    if name in (STYLE, GLOSSARY):
        return
    # One search for all words: most lines have none of them.
    any_word = re.compile("(?<![A-Za-z])(?:" + "|".join(re.escape(word) for word, _ in words) + ")")
    if not any_word.search(text):
        return
    for number, line in enumerate(text.splitlines(), 1):
        if not any_word.search(line):
            continue
        for word, allowed in words:
            if name not in allowed and re.search(rf"(?<![A-Za-z]){re.escape(word)}", line):
                yield number, f"the word \"{word}\" is retired (see {STYLE})"


def check_sources(root, words):
    """Retired words in the comments, names and strings of the C++ sources."""
    pages = (page for folder in SOURCE_FOLDERS for page in sorted((root / folder).rglob("*")))
    for page in pages:
        if page.suffix in (".h", ".cpp"):
            name = page.relative_to(root).as_posix()
            for number, mistake in check_words(name, page.read_text(), words):
                yield f"{name}:{number}", mistake


def case_keys(root):
    """The keys that the reader of case.json names: string literals of its fields, of lookups and of lists of keys."""
    readers = sorted(root.glob("planner/**/case_io.cpp"))
    if len(readers) != 1:
        sys.exit(f"there must be one planner/**/case_io.cpp, and there are {len(readers)}")
    text = re.sub(r"//[^\n]*", "", readers[0].read_text())
    fields = re.search(r"struct Fields \{.*?\n    \};\n", text, re.S)
    keys = set(re.findall(r"\"(\w+)\"", fields.group())) if fields else set()
    keys |= set(re.findall(r"(?:\[|\bhas\(|_number\(|read_direction\()\"(\w+)\"", text))
    for call in re.findall(r"\.object\(([^;]*?)\);", text, re.S):
        keys |= set(re.findall(r"\"(\w+)\"", call))
    return keys


def check_case_page(root):
    keys = case_keys(root)
    if len(keys) < 50:  # there are about 90: fewer means that they are no longer found by their form
        yield 0, f"only {len(keys)} keys were found in case_io.cpp: this check must learn their new form"
    named = set(re.findall(r"\b\w+\b", " ".join(re.findall(r"`([^`]+)`", (root / CASE_PAGE).read_text()))))
    for key in sorted(keys - named):
        yield 0, f"does not name the key `{key}`, which case_io.cpp reads"


class Programs:
    """The programs' own help, asked once per command."""

    def __init__(self, binaries):
        self.binaries, self.known = binaries, {}

    def help_of(self, program, words):
        key = (program, *words)
        if key not in self.known:
            self.known[key] = generate_references.help_of(self.binaries / program, words)
        return self.known[key]

    def problem_of(self, line):
        """Why a command line that a page shows is wrong; None: it is not."""
        tokens = shlex.split(line, comments=True)
        program, rest = tokens[0], tokens[1:]
        if not (self.binaries / program).exists():
            # A build without the window has no workstation; any other name must be a program.
            return None if program == "retractor-workstation" else f"there is no program {program}"
        words = []
        try:
            text = self.help_of(program, ())
            texts = [text]
            while rest and rest[0] in generate_references.subcommands_of(text):
                words.append(rest.pop(0))
                text = self.help_of(program, tuple(words))
                texts.append(text)
        except generate_references.HelpError as error:
            return str(error)
        if generate_references.subcommands_of(text) and not (rest and rest[0].startswith("-")):
            return f"{' '.join([program, *words])} has no command {rest[0] if rest else '(none is given)'}"
        for option in (token.partition("=")[0] for token in rest if token.startswith("--")):
            if not any(re.search(rf"(?<![\w-]){option}(?![\w-])", known) for known in texts):
                return f"{' '.join([program, *words])} has no option {option}"
        return None


def commands_of(text):
    """(line number, command) in blocks of code; a backslash at the end of a line joins it with the next one."""
    begun, first = "", 0
    for number, line, language in parts_of(text):
        if language not in ("", "sh", "bash"):
            continue
        if not begun:
            first = number
        if line.endswith("\\"):
            begun += line[:-1]
            continue
        yield first, begun + line
        begun = ""


def check_commands(root, text, programs):
    actions = set(re.findall(r"^  (\w+)\)", (root / "run").read_text(), re.M))
    for number, line in commands_of(text):
        if line.startswith("./run") and (line.split() + [""])[1] not in actions:
            yield number, f"./run does not know this: {line}"
        if line.startswith("retractor") and programs and (problem := programs.problem_of(line)):
            yield number, problem


def check_all(root, binaries):
    """(place, mistake) of every mistake in the documents below root."""
    if not (root / "README.md").exists():
        sys.exit(f"there is no README.md in {root}: --root is the top folder of the repository")
    words = retired_words(root)
    programs = Programs(binaries) if binaries else None
    sources = {path.name for folder in TOP for path in (root / folder).rglob("*") if path.is_file()}
    for page in documents(root):
        name, text = page.relative_to(root).as_posix(), page.read_text()
        checks = [check_widths(name, text), check_links(root, page, text), check_examples(root, text),
                  check_words(name, text, words)]
        if name != COMMANDS_PAGE:
            checks += [check_paths(root, text, sources), check_commands(root, text, programs)]
        for check in checks:
            for number, mistake in check:
                yield f"{name}:{number}" if number else name, mistake
    yield from check_sources(root, words)
    for _, mistake in check_case_page(root):
        yield CASE_PAGE, mistake
    if binaries:
        old = (root / COMMANDS_PAGE).read_text()
        if generate_references.make_page(binaries, old)[0] != old:
            yield COMMANDS_PAGE, ("is not what the programs print now: "
                                  "python3 docs/generate_references.py --binaries FOLDER")


def main():
    parser = argparse.ArgumentParser(description="Checks the documents.")
    parser.add_argument("--root", type=pathlib.Path, required=True, help="top folder of the repository")
    parser.add_argument("--binaries", type=pathlib.Path, help="folder with the built programs")
    options = parser.parse_args()
    binaries = options.binaries.resolve() if options.binaries else None
    if binaries and not (binaries / "retractor").exists():
        parser.error(f"there is no retractor in {binaries}")
    mistakes = list(check_all(options.root.resolve(), binaries))
    for place, mistake in mistakes:
        print(f"{place}: {mistake}")
    print(f"{len(mistakes)} mistake(s)")
    sys.exit(1 if mistakes else 0)


if __name__ == "__main__":
    main()
