#!/usr/bin/env python3
"""Finds rings of units: sets of units that include each other.

    scripts/unit_cycles.py [FOLDER]     default: the tree that the script is in

A unit is NAME.h, NAME-inl.h and NAME.cc of a folder. Prints each ring with the includes that close
it and exits with 1 if there is one.
"""

import pathlib
import re
import sys

FOLDERS = ["base", "kernels", "image", "lights", "scene", "wavefront", "job", "bench/measure", "api",
           "cli"]
INCLUDE = re.compile(r'^\s*#include "([^"]+)"', re.MULTILINE)


def unit_of(name):
    return re.sub(r"(-inl)?\.(h|cc)$", "", str(name))


def read_units(root):
    """For each unit the units that it includes."""
    files = {str(path.relative_to(root)): path for folder in FOLDERS
             for path in (root / folder).rglob("*") if path.suffix in (".h", ".cc")}
    units = {}
    for name, path in files.items():
        included = units.setdefault(unit_of(name), set())
        included |= {unit_of(i) for i in INCLUDE.findall(path.read_text()) if i in files}
    for unit, included in units.items():
        included.discard(unit)
    return units


def rings(units):
    """The strongly connected components of more than one unit (Tarjan 1972)."""
    index, low, stack, found = {}, {}, [], []

    def visit(unit):
        index[unit] = low[unit] = len(index)
        stack.append(unit)
        for other in units[unit]:
            if other not in index:
                visit(other)
                low[unit] = min(low[unit], low[other])
            elif other in stack:
                low[unit] = min(low[unit], index[other])
        if low[unit] == index[unit]:
            ring = stack[stack.index(unit):]
            del stack[stack.index(unit):]
            if len(ring) > 1:
                found.append(sorted(ring))

    for unit in sorted(units):
        if unit not in index:
            visit(unit)
    return found


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    units = read_units(root if root.is_dir() else root.parent.parent)
    found = rings(units)
    for ring in found:
        print("ring of units:")
        for unit in ring:
            print(f"  {unit} includes {', '.join(sorted(units[unit] & set(ring)))}")
    print(f"{len(units)} units, {len(found)} rings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
