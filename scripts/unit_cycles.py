#!/usr/bin/env python3
"""Finds rings of includes, and includes that the table of rooms in docs/design.md does not allow.

    scripts/unit_cycles.py [FOLDER]     default: the tree that the script is in

A unit is NAME.h, NAME-inl.h and NAME.cc of a folder, a room a folder within another one together
with all that lies in it; a file that lies beside rooms is a room of its own. Prints rings of units,
rings of rooms and forbidden includes, and exits with 1 if there is one.
"""

import pathlib
import re
import sys

FOLDERS = ["base", "kernels", "image", "lights", "scene", "wavefront", "job", "bench/measure",
           "api", "cli"]
INCLUDE = re.compile(r'^\s*#include "([^"]+)"', re.MULTILINE)
# | `wavefront/paths/` | what lives there | `stages/`, `film/` |
ROOM = re.compile(r"^\| `((?:kernels|lights|scene|wavefront)/\w+)/` \|.*\|(.*)\|$", re.MULTILINE)


def unit_of(name):
    return re.sub(r"(-inl)?\.(h|cc)$", "", name)


def room_of(name):
    return "/".join(name.split("/")[:2]) if name.count("/") > 1 else unit_of(name)


def read_includes(root):
    """For each file the files of the tree that it includes."""
    files = {str(path.relative_to(root)): path for folder in FOLDERS
             for path in (root / folder).rglob("*") if path.suffix in (".h", ".cc")}
    return {name: [i for i in INCLUDE.findall(path.read_text()) if i in files]
            for name, path in files.items()}


def graph(includes, node_of):
    """For each node the other nodes that its files include."""
    nodes = {}
    for name, included in includes.items():
        node = node_of(name)
        nodes.setdefault(node, set()).update({node_of(i) for i in included} - {node})
    return nodes


def rings(nodes):
    """The strongly connected components of more than one node (Tarjan 1972)."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(nodes[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            ring = stack[stack.index(node):]
            del stack[stack.index(node):]
            if len(ring) > 1:
                found.append(sorted(ring))

    for node in sorted(nodes):
        if node not in index:
            visit(node)
    return found


def forbidden(includes, design):
    """Includes of rooms that the table does not allow, and rooms that it does not have."""
    allowed = {room: set(re.findall(r"`(\w+)/`", may)) for room, may in ROOM.findall(design)}
    found = []
    for name in sorted(includes):
        room = room_of(name)
        if room.split("/")[0] not in ("kernels", "lights", "scene", "wavefront"):
            continue
        if name.count("/") > 1 and room not in allowed:
            found.append(f"{name}: docs/design.md has no line for {room}/")
            continue
        for other in includes[name]:
            same_folder = other.split("/")[0] == name.split("/")[0] and other.count("/") > 1
            if room in allowed and same_folder and room_of(other) != room and \
                    other.split("/")[1] not in allowed[room]:
                found.append(f"{name} includes {other}, which docs/design.md does not allow")
    return found


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    root = root if root.is_dir() else root.parent.parent
    includes = read_includes(root)
    failed = 0
    for kind, node_of in (("units", unit_of), ("rooms", room_of)):
        nodes = graph(includes, node_of)
        found = rings(nodes)
        for ring in found:
            print(f"ring of {kind}:")
            for node in ring:
                print(f"  {node} includes {', '.join(sorted(nodes[node] & set(ring)))}")
        print(f"{len(nodes)} {kind}, {len(found)} rings")
        failed += len(found)
    found = forbidden(includes, (root / "docs/design.md").read_text())
    print("\n".join(found + [f"{len(found)} includes that the table of rooms forbids"]))
    return 1 if failed or found else 0


if __name__ == "__main__":
    sys.exit(main())
