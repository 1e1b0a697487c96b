#!/usr/bin/env python3
"""Checks the structure of the sources: which way includes point, circles among modules, the size of folders,
and which folders see which library.

    check_structure.py ROOT      checks the sources below ROOT; exit status 1 and one line for each fault
    check_structure.py --plant   plants each fault in a small tree and checks that it is found

A module is a header with its source. Four rules hold, and docs/developer/architecture.md gives their reasons:
1. an include points to the same floor or to a lower one;
2. no modules include each other in a circle;
3. a folder holds at most 20 modules;
4. the headers of a library are included only where FORBIDDEN allows them.
"""
import os
import re
import sys
import tempfile
from pathlib import Path

# From the ground up. A folder belongs to the longest name that it begins with; the same number means the same floor,
# and folders of one floor may include each other unless SEPARATE says otherwise.
FLOORS = {
    "mesh/base": 0,
    "mesh": 1,
    "fem": 2,
    "datasets": 2,
    "haptics": 3,
    "planner": 4,
    "planner/session": 5,
    "ui/scene": 6,
    "ui/scene/vtk": 7,
    "ui": 8,
    "ui/cli/framework": 9,
    "ui/cli": 10,
    "ui/workstation": 10,
    "tests": 11,
}
# Folders of one floor that must not see each other.
SEPARATE = [("fem", "datasets"), ("ui/cli", "ui/workstation")]
MAX_MODULES = 20
PRODUCT = ("mesh", "fem", "datasets", "haptics", "planner", "ui")
# In the product, not in its tests: headers that a folder must not include, as (folder, pattern of the header's path,
# allowed places). "" is every folder; a place is a folder, or a module without its ending.
FORBIDDEN = [
    ("", r"Q[A-Z]\w*", ["ui/workstation"]),
    ("", r"itk\w+\.h", ["datasets"]),
    ("", r"CGAL/.*", ["mesh/generation"]),
    ("", r"vtk\w+\.h", ["datasets", "mesh/base/vtk_errors", "mesh/surface/label_surface", "mesh/tetrahedra/mesh_io",
                       "ui/scene/vtk", "ui/workstation/view"]),
    ("fem", r"mesh/tetrahedra/mesh_io\.h", []),
    ("mesh", r"mesh/tetrahedra/mesh_io\.h", ["mesh/tetrahedra/mesh_io"]),
    ("planner/session", r"mesh/tetrahedra/mesh_io\.h", []),
]
ANY_INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', re.MULTILINE)
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def sources(root):
    """Paths relative to root of all headers and sources in the product's folders and in tests."""
    found = []
    for top in PRODUCT + ("tests",):
        for folder, _, names in os.walk(root / top):
            found += [Path(folder, name).relative_to(root) for name in names if name.endswith((".h", ".cpp"))]
    return sorted(found)


def module(path):
    return str(Path(path).with_suffix(""))


def room(path):
    """The entry of FLOORS that a file belongs to."""
    folders = str(Path(path).parent).split("/")
    for length in range(len(folders), 0, -1):
        name = "/".join(folders[:length])
        if name in FLOORS:
            return name
    raise SystemExit(f"{path}: no floor is known for its folder")


def is_upward(includer, included):
    above, below = room(includer), room(included)
    if FLOORS[below] > FLOORS[above]:
        return True
    return any({above.split("/session")[0], below} == set(pair) for pair in SEPARATE)


def lies_in(path, place):
    return place == "" or module(path) == place or str(path).startswith(place + "/")


def is_forbidden(includer, included):
    """Whether FORBIDDEN keeps this header out of this file."""
    if str(includer).split("/", 1)[0] not in PRODUCT:
        return False
    return any(lies_in(includer, folder) and re.fullmatch(pattern, included)
               and not any(lies_in(includer, place) for place in allowed) for folder, pattern, allowed in FORBIDDEN)


def circles(arrows):
    """Strongly connected sets of more than one module, by Tarjan's algorithm (SIAM J. Comput. 1:146, 1972)."""
    number, low, stack, on_stack, found = {}, {}, [], set(), []

    def visit(node):
        number[node] = low[node] = len(number)
        stack.append(node)
        on_stack.add(node)
        for other in sorted(arrows.get(node, ())):
            if other not in number:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on_stack:
                low[node] = min(low[node], number[other])
        if low[node] == number[node]:
            members = []
            while True:
                members.append(stack.pop())
                on_stack.discard(members[-1])
                if members[-1] == node:
                    break
            if len(members) > 1:
                found.append(sorted(members))

    sys.setrecursionlimit(10000)
    for node in sorted(arrows):
        if node not in number:
            visit(node)
    return found


def faults(root):
    root = Path(root)
    files = sources(root)
    known = {str(f) for f in files}
    arrows, found, folders = {}, [], {}
    for file in files:
        arrows.setdefault(module(file), set())
        folders.setdefault(str(file.parent), set()).add(file.stem)
        text = (root / file).read_text()
        for included in ANY_INCLUDE.findall(text):
            if is_forbidden(file, included):
                found.append(f"{file}: includes {included}, which is forbidden here")
        for included in INCLUDE.findall(text):
            if included not in known:
                found.append(f'{file}: includes "{included}", which is no file of this tree')
                continue
            if module(included) != module(file):
                arrows[module(file)].add(module(included))
            if is_upward(file, included):
                found.append(f'{file}: includes "{included}", which lies on a higher or separate floor')
    for circle in circles(arrows):
        found.append("circle of includes: " + ", ".join(circle))
    for folder, modules in sorted(folders.items()):
        if len(modules) > MAX_MODULES:
            found.append(f"{folder}: {len(modules)} modules, at most {MAX_MODULES} are allowed")
    return found


def check_that_faults_are_found():
    """Plants one fault at a time in a tree without faults; each must be named."""
    def write(root, path, text):
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)

    plants = {
        "higher or separate floor": {"mesh/base/low.h": '#include "fem/other.h"\n'},
        "between separate folders": {"datasets/io/reader.h": '#include "fem/high.h"\n'},
        "circle of includes": {"fem/high.h": '#include "fem/other.h"\n', "fem/other.cpp": '#include "fem/high.h"\n'},
        "at most 20": {f"fem/many/m{i}.h": "" for i in range(21)},
        "vtkPolyData.h, which is forbidden": {"fem/high.h": "#include <vtkPolyData.h>\n"},
        "QWidget, which is forbidden": {"planner/session/worker.h": "#include <QWidget>\n"},
        "mesh_io.h, which is forbidden": {
            "mesh/tetrahedra/mesh_io.h": "",
            "planner/session/worker.cpp": '#include "mesh/tetrahedra/mesh_io.h"\n'},
        "no file of this tree": {"fem/high.h": '#include "fem/gone.h"\n'},
    }
    for name, plant in plants.items():
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for path in ("mesh/base/low.h", "fem/other.h"):
                write(root, path, "")
            write(root, "fem/high.h", '#include "mesh/base/low.h"\n')
            if faults(root):
                raise SystemExit(f"a tree without faults is refused: {faults(root)}")
            for path, text in plant.items():
                write(root, path, text)
            expected = "higher or separate floor" if name == "between separate folders" else name
            found = faults(root)
            if len(found) != 1 or expected not in found[0]:
                raise SystemExit(f"planted '{name}', found {found}")
    print(f"{len(plants)} planted faults found")


def main():
    if sys.argv[1:] == ["--plant"]:
        check_that_faults_are_found()
        return
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    found = faults(sys.argv[1])
    good = "includes point down, no circles, no folder is too large, and no header is forbidden"
    print("\n".join(found) if found else good)
    sys.exit(1 if found else 0)


main()
