#!/usr/bin/env python3
"""Does check_documents.py see mistakes? A small repository is right at first; then one mistake is planted at a time."""
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_documents  # noqa: E402
import generate_references  # noqa: E402  (check_documents has found its folder)

SOURCES = pathlib.Path(__file__).resolve().parents[2]
# A program with one command, "plan --out DIR"; anything else ends with exit code 2.
PROGRAM = r"""#!/bin/sh
case "$*" in
  --help) printf 'Usage: retractor SUBCOMMAND\n\nSubcommands:\n  plan    Plan a case\n' ;;
  "plan --help") printf 'Usage: retractor plan [OPTIONS]\n\nOptions:\n  --out DIR   Folder\n' ;;
  *) exit 2 ;;
esac
"""
README = """# Title

See [the case](docs/user/case-json.md#labels), `planner/case/` and `case_io.cpp`.

```
retractor plan C --out D   # a comment
./run test
```
"""


class CheckDocuments(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve() / "sources"
        self.binaries = pathlib.Path(folder.name).resolve() / "bin"
        self.binaries.mkdir()
        self.write_program(PROGRAM)
        self.write("run", "case x in\n  test)\nesac\n")
        self.write("planner/case/case_io.cpp", next(SOURCES.glob("planner/**/case_io.cpp")).read_text())
        self.write("docs/user/case-json.md", (SOURCES / "docs/user/case-json.md").read_text())
        for linked in ("user/approaches", "user/importing", "user/numbers", "user/planning", "method/meshing",
                       "method/tissue-values"):
            page = self.root / f"docs/{linked}.md"
            page.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCES / f"docs/{linked}.md", page)
            headings = [line for line in page.read_text().splitlines() if line.startswith("#")]
            page.write_text("\n\n".join(headings) + "\n")
        self.write("docs/developer/style.md", "<!-- retired words: -->\n\n| `OldName` | `NewName` | |\n")
        self.write("docs/user/commands.md", generate_references.make_page(self.binaries, "")[0])
        for page in ("docs/user/workstation.md", "docs/method/verification.md", "docs/developer/benchmarks.md"):
            self.write(page, "# Page\n")
        self.write("README.md", README)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def write_program(self, text):
        program = self.binaries / "retractor"
        program.write_text(text)
        program.chmod(0o755)

    def mistakes(self):
        return [f"{place}: {mistake}" for place, mistake in check_documents.check_all(self.root, self.binaries)]

    def expect(self, *mistakes):
        """Exactly these, in this order: each a beginning of what is reported."""
        found = self.mistakes()
        self.assertEqual(len(found), len(mistakes), found)
        for one, beginning in zip(found, mistakes):
            self.assertTrue(one.startswith(beginning), f"{one} does not begin with {beginning}")

    def plant(self, old, new, name="README.md"):
        text = (self.root / name).read_text()
        self.assertIn(old, text)
        self.write(name, text.replace(old, new))

    def test_the_right_repository_has_none(self):
        self.expect()

    def test_another_folder_is_no_repository(self):
        (self.root / "README.md").unlink()
        with self.assertRaises(SystemExit):
            self.mistakes()

    def test_wide_lines(self):
        self.plant("# Title", "# Title\n\n" + "wide " * 21)
        self.expect("README.md:3: is longer than 100 columns")
        self.write("docs/page.md", "word " * 25 + "\n\n| " + "cell " * 30 + "|\n\n```text\n" + "code " * 30 + "\n```\n")
        self.expect("README.md:3", "docs/page.md:1: is longer than 120 columns")

    def test_a_readme_of_many_lines(self):
        self.plant("# Title", "# Title" + "\n" * 120)
        self.expect("README.md: has more than 120 lines")

    def test_links(self):
        self.plant("case-json.md#labels", "case-jason.md")
        self.expect("README.md:3: the link docs/user/case-jason.md leads nowhere")
        self.plant("case-jason.md", "case-json.md#labelz")
        self.expect("README.md:3: the link docs/user/case-json.md#labelz names a heading")

    def test_commands(self):
        self.plant("retractor plan", "retractor plam")
        self.expect("README.md:6: retractor has no command plam")
        self.plant("retractor plam", "retractor plan --into")
        self.expect("README.md:6: retractor plan has no option --into")
        self.plant("retractor plan --into", "retractor-dream")
        self.expect("README.md:6: there is no program retractor-dream")
        self.plant("./run test", "./run toast")
        self.expect("README.md:6", "README.md:7: ./run does not know this")

    def test_a_command_of_two_lines(self):
        self.plant("retractor plan", "retractor plan case.json \\\n  --into")
        self.expect("README.md:6: retractor plan has no option --into")

    def test_a_command_without_help(self):
        self.write_program(PROGRAM.replace('"plan --help")', '"plan --hilfe")'))
        with self.assertRaises(generate_references.HelpError):
            self.mistakes()  # the page of commands cannot be made either

    def test_paths(self):
        self.plant("planner/case/", "planner/cases/")
        self.expect("README.md:3: there is no planner/cases/")
        self.plant("case_io.cpp", "case_oi.cpp")
        self.expect("README.md:3: there is no planner/cases/", "README.md:3: there is no source case_oi.cpp")

    def test_an_example_that_is_not_its_file(self):
        self.write("tests/package/example/main.cpp", "int main() { }\n")
        self.write("docs/page.md", "<!-- the text of tests/package/example/main.cpp -->\n```cpp\nint main() { }\n```\n")
        self.expect()
        self.plant("{ }", "{ return 1; }", "docs/page.md")
        self.expect("docs/page.md:1: the block of code is not the text of tests/package/example/main.cpp")
        self.plant("```cpp\n", "\n", "docs/page.md")
        self.expect("docs/page.md:1: no block of code follows")
        (self.root / "tests/package/example/main.cpp").unlink()
        self.expect("docs/page.md:1: there is no tests/package/example/main.cpp")

    def test_retired_words(self):
        self.plant("# Title", "# Title with an OldName")
        self.expect('README.md:1: the word "OldName" is retired')

    def test_retired_words_in_sources(self):
        self.write("ui/old.h", "// A comment that names OldName.\nint size_of_OldName();\nint NotOldName;\n")
        self.expect('ui/old.h:1: the word "OldName" is retired', 'ui/old.h:2: the word "OldName" is retired')
        self.plant("| |", "| `ui/old.h` |", "docs/developer/style.md")
        self.expect()

    def test_a_key_that_no_page_names(self):
        self.plant("`sha256`", "`checksum`", "docs/user/case-json.md")
        self.expect("docs/user/case-json.md: does not name the key `sha256`")
        self.plant('"sha256"', '"sha257"', "planner/case/case_io.cpp")
        self.expect("docs/user/case-json.md: does not name the key `sha257`")

    def test_a_stale_page_of_commands(self):
        self.write_program(PROGRAM.replace("Plan a case", "Plan one case"))
        self.expect("docs/user/commands.md: is not what the programs print now")


if __name__ == "__main__":
    unittest.main()
