#!/usr/bin/env python3
"""Seeds the one-line faults of tests/mutations.toml, one after the other, and reports those that
the tests do not see:

  scripts/mutation_test.py                        # all of them: an hour or more
  scripts/mutation_test.py --only 'kernels/*'     # those whose name or file matches the pattern
  scripts/mutation_test.py --share commit/50      # a fiftieth, another one at every commit
  scripts/mutation_test.py --check                # only whether the list still fits the sources
  scripts/mutation_test.py -DSKYWAVE_WERROR=ON    # options of CMake, as those of the last build

Each fault is made in a copy of the tree (build/mutations/tree), in which only the programs of its
tests are built; the tree itself is never touched. The tests first have to pass without any fault.
Ends with 1 if a fault survives that the list does not call unseen, if one does not compile, if none
is chosen, without git, or if the list does not fit the sources; with 77 if nothing can be built
here. The tree without faults comes out of ccache if it was built with the same options; a share is
skipped where there is no ccache whose base_dir (CCACHE_BASEDIR) is the tree or above it."""

import argparse
import fcntl
import fnmatch
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent
LIST = SOURCE / "tests" / "mutations.toml"
# A fault may leave a variable without use, which is no reason to refuse it. To Python these lines
# are comments.
QUIET = "".join(f'#pragma GCC diagnostic ignored "-Wunused-{kind}"\n'
                for kind in ("variable", "but-set-variable", "parameter", "function"))
KEYS = {"name", "file", "find", "put", "tests", "why"}
MAY_HAVE = {"within", "unseen"}
# What matters to the nesting of braces; strings, characters and comments are passed over.
CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"\((?:.*?)\)"|"(?:\\.|[^"\\])*"|'
                  r"(?<!\w)'(?:\\.|[^'\\])+'|[{};]", re.S)
PYTHON = "python_"  # how ctest calls the programs of tests/python


def split_test(test):
    """A test is a program of ctest, and after a colon a filter of GoogleTest."""
    program, _, cases = test.partition(":")
    return program, cases


def test_source(program):
    return next(SOURCE.glob(f"tests/*/{program}.cc"), None)


def targets_of(program):
    """What has to be built for a test: a program of its own, or what the test runs."""
    if program.startswith(PYTHON):
        return {"skywave", "skywave_python"}
    return {program if test_source(program) else "skywave"}


def is_known(program):
    """Whether ctest has a test that is no program of GoogleTest."""
    if program.startswith(PYTHON):
        return (SOURCE / f"tests/python/{program.removeprefix(PYTHON)}_test.py").is_file()
    return re.search(rf"(NAME |add_script_test\(){re.escape(program)}\s",
                     (SOURCE / "tests/CMakeLists.txt").read_text())


def file_of(mutation, tree=SOURCE):
    """The file of a fault; one that has moved is found by its name, if no other file has it."""
    path = tree / mutation["file"]
    if path.exists():
        return path
    top = {entry.name for entry in tree.iterdir() if entry.is_dir()} - {".git", "build", "tests"}
    found = [p for folder in sorted(top) for p in (tree / folder).rglob(path.name)]
    return found[0] if len(found) == 1 else None


def end_of_block(text, start):
    """The end of the C++ block whose first brace is the first one from `start` on; None if a
    semicolon comes first, as in a declaration or a call."""
    depth = 0
    for token in CODE.finditer(text, start):
        if token[0] == "{":
            depth += 1
        elif token[0] == "}":
            depth -= 1
            if depth <= 0:
                return token.end()
        elif token[0] == ";" and depth == 0:
            return None
    return None


def functions(text, name, suffix):
    """The ranges of the definitions of `name`: a function ("Film::Add" or "Add"), or "struct X"."""
    if suffix == ".py":
        found = re.finditer(rf"^( *)(?:def|class) {re.escape(name)}\b.*\n(?:\1 .*\n|\s*\n)*", text,
                            re.M)
        return [match.span() for match in found]
    opening = r"\b" if name.startswith(("struct ", "class ")) else r"\s*\("
    ranges = []
    for match in re.finditer(rf"(?<![\w:]){re.escape(name)}{opening}|"
                             rf"(?<=::){re.escape(name)}{opening}", text):
        end = end_of_block(text, match.end())
        # A call in the condition of a block has that block as its range, within its function's.
        if end and not any(a <= match.start() < b for a, b in ranges):
            ranges.append((match.start(), end))
    return ranges


def places(mutation, text, suffix):
    """Where the text of a fault stands. White space counts in Python alone: C++ may be formatted
    otherwise."""
    find = mutation["find"]
    if suffix == ".py":
        pattern = re.escape(find)
    else:
        words = re.findall(r"\w+|[^\w\s]", find)
        pattern = re.escape(words[0])
        for before, word in zip(words, words[1:]):
            pattern += (r"\s+" if re.match(r"\w", before) and re.match(r"\w", word) else r"\s*")
            pattern += re.escape(word)
        pattern = r"\b" * bool(re.match(r"\w", words[0])) + pattern
        pattern += r"\b" * bool(re.match(r"\w", words[-1]))
    within = mutation.get("within")
    ranges = functions(text, within, suffix) if within else [(0, len(text))]
    return [match.span() for match in re.finditer(pattern, text)
            if any(a <= match.start() and match.end() <= b for a, b in ranges)]


def with_fault(mutation, text, suffix):
    (begin, end), = places(mutation, text, suffix)
    return text[:begin] + mutation["put"] + text[end:]


def complaints(mutation, names):
    """What makes an entry of the list useless."""
    if not KEYS <= set(mutation) <= KEYS | MAY_HAVE:
        yield f"needs {', '.join(sorted(KEYS))}"
        return
    if mutation["name"] in names:
        yield "has the name of another entry"
    path = file_of(mutation)
    count = len(places(mutation, path.read_text(), path.suffix)) if path else 0
    if count != 1:
        where = f"{mutation['within']} in " if "within" in mutation else ""
        yield f"{where}{mutation['file']} has its text {count} times instead of once"
    if mutation["find"] == mutation["put"] or not mutation["tests"]:
        yield "changes nothing or names no test"
    for program, cases in map(split_test, mutation["tests"]):
        source = test_source(program)
        if not source:
            if not is_known(program):
                yield f"there is no test {program}"
            elif cases:
                yield f"{program} has no cases that could be filtered"
            continue
        known = "\n".join(
            f"{suite}.{case}" for suite, case in
            re.findall(r"^TEST(?:_[FP])?\((\w+),\s*(\w+)\)", source.read_text(), re.M))
        # Instances and parameters of a case are not in the source, the rest of a pattern is.
        for pattern in filter(None, cases.split(":")):
            if not any(piece in known for piece in re.split(r"[*?/]+", pattern) if piece):
                yield f"{program} has no case {pattern}"


def read_list():
    """The entries, and what is wrong with them, a line each."""
    mutations = tomllib.loads(LIST.read_text())["mutation"]
    problems, names = [], set()
    for mutation in mutations:
        name = mutation.get("name", "an entry without a name")
        problems += [f"{name}: {text}" for text in complaints(mutation, names)]
        names.add(name)
    return mutations, problems


def git(*words):
    """What git says of the tree, which has to be a repository."""
    try:
        return subprocess.run(["git", *words], cwd=SOURCE, check=True, text=True,
                              capture_output=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        why = getattr(error, "stderr", None) or error
        sys.exit(f"git {words[0]} is needed here: {str(why).strip()}")


def choose(mutations, only, share):
    chosen = f"--only {only}" if only else ""
    if only:
        mutations = [m for m in mutations if fnmatch.fnmatch(m["name"], only)
                     or fnmatch.fnmatch(m["file"], only)]
    if share:
        if not (numbers := re.fullmatch(r"(commit|[1-9]\d*)/([1-9]\d*)", share)):
            sys.exit(f"--share {share} is not K/N or commit/N")
        index, count = numbers[1], int(numbers[2])
        if index == "commit":
            commit = git("rev-parse", "HEAD")
            index = 1 + int(commit[:8], 16) % count
            print(f"share {index}/{count}, by the commit {commit[:8]}")
        if int(index) > count:
            sys.exit(f"--share {share}: there are only {count} shares")
        mutations = mutations[int(index) - 1::count]
        chosen = f"{chosen} --share {share}".strip()
    if not mutations:
        sys.exit(f"{chosen} chooses none of the faults")
    return mutations


def copy_tree(tree):
    """Makes `tree` what the sources are, and leaves files alone that have not changed, so that an
    earlier fault is undone and little is compiled again."""
    listed = git("ls-files", "-zco", "--exclude-standard").split("\0")
    files = {name for name in listed if name and (SOURCE / name).is_file()}
    for name in files:
        source, target = SOURCE / name, tree / name
        if not target.exists() or target.read_bytes() != source.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        shutil.copymode(source, target)
    for folder in tree.iterdir():
        if folder.name == "build":
            continue
        for path in [p for p in [folder, *folder.rglob("*")] if not p.is_dir()]:
            if str(path.relative_to(tree)) not in files:
                path.unlink()


def run(command, **options):
    return subprocess.run(command, text=True, errors="replace", stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, **options)


def shares_objects():
    """Whether ccache compares paths below the tree relative to where the compiler runs, so that the
    copy gets what the tree has compiled."""
    if not shutil.which("ccache"):
        return False
    base = os.environ.get("CCACHE_BASEDIR") or run(["ccache", "--get-config", "base_dir"]).stdout
    return bool(base.strip()) and SOURCE.is_relative_to(base.strip())


class Build:
    """The copy of the tree and what is built of it."""

    def __init__(self, folder, jobs):
        # Where a build of the tree itself lies, so that ccache knows the units of that.
        self.tree, self.jobs = folder / "tree", jobs
        self.binaries = self.tree / "build" / "release"
        self.tree.mkdir(parents=True, exist_ok=True)

    def configure(self, mutations, definitions):
        python = any(test.startswith(PYTHON) for m in mutations for test in m["tests"])
        return run(["cmake", "--preset", "release", "-DSKYWAVE_BENCH=OFF",
                    f"-DSKYWAVE_PYTHON={'ON' if python else 'OFF'}",
                    *(f"-D{definition}" for definition in definitions)], cwd=self.tree)

    def make(self, tests):
        targets = set().union(*(targets_of(program) for program, _ in map(split_test, tests)))
        return run(["cmake", "--build", str(self.binaries), f"-j{self.jobs}", "--target",
                    *sorted(targets)])

    def test(self, test):
        """"passed", "failed" or why it says nothing."""
        program, cases = split_test(test)
        environment = dict(os.environ, GTEST_FILTER=cases or "*")
        ended = run(["ctest", "--test-dir", str(self.binaries), "-R", f"^{program}$", "-V",
                     "--no-tests=error", "--timeout", "600"], env=environment)
        if ended.returncode:
            return "failed"
        nothing = "***Skipped" in ended.stdout or "[  PASSED  ] 0 tests" in ended.stdout
        return "skipped" if nothing else "passed"


def without_faults(build, mutations):
    """Builds the tree as it is; returns the tests that do not pass even there."""
    tests = sorted({test for mutation in mutations for test in mutation["tests"]})
    print(f"{len(mutations)} faults, {len(tests)} tests, which pass without them:", flush=True)
    made = build.make(tests)
    if made.returncode:
        sys.exit(made.stdout + "the tree does not build")
    broken = [f"{test}: {outcome}" for test in tests if (outcome := build.test(test)) != "passed"]
    print("  all" if not broken else "\n".join(f"  not {line}" for line in broken), flush=True)
    return {line.rsplit(": ", 1)[0] for line in broken}


def seed(build, mutation, broken):
    """Makes one fault; returns "seen", "survived" or "does not build", and by what."""
    path = file_of(mutation, build.tree)
    text = path.read_text()
    try:
        path.write_text(QUIET + with_fault(mutation, text, path.suffix))
        made = build.make(mutation["tests"])
        if made.returncode:
            return "does not build", "\n" + made.stdout[-3000:]
        for test in mutation["tests"]:
            if test not in broken and build.test(test) == "failed":
                return "seen", f"by {test}"
        return "survived", ""
    finally:
        path.write_text(text)


def main():
    arguments = argparse.ArgumentParser(description=__doc__,
                                        formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--only", metavar="PATTERN", help="faults whose name or file matches")
    arguments.add_argument("--share", metavar="K/N",
                           help="each N-th fault from the K-th on; `commit` as K: by the commit")
    arguments.add_argument("--list", action="store_true", help="print the faults and end")
    arguments.add_argument("--check", action="store_true", help="compare the list with the sources")
    arguments.add_argument("-D", action="append", default=[], dest="definitions",
                           metavar="NAME=VALUE", help="option of CMake")
    arguments.add_argument("--folder", type=Path, default=SOURCE / "build" / "mutations")
    arguments.add_argument("--jobs", type=int, default=os.cpu_count())
    given = arguments.parse_args()

    mutations, problems = read_list()
    for problem in problems:
        print(f"{LIST.relative_to(SOURCE)}: {problem}")
    if given.check or problems:
        print(f"{len(mutations)} faults, {len(problems)} that the sources do not have")
        return 1 if problems else 0
    mutations = choose(mutations, given.only, given.share)
    if given.list:
        for mutation in mutations:
            print(f"{mutation['name']}  [{mutation['file']}]\n    {mutation['why']}\n    seen by "
                  + ", ".join(mutation["tests"]))
        return 0

    if given.share and not shares_objects():
        print("skipped: without ccache and its base_dir the whole tree would be compiled again")
        return 77
    build = Build(given.folder, given.jobs)
    lock = open(given.folder / "lock", "w")
    fcntl.flock(lock, fcntl.LOCK_EX)
    copy_tree(build.tree)
    configured = build.configure(mutations, given.definitions)
    if configured.returncode:
        print(configured.stdout + "skipped: the tests cannot be configured here")
        return 77
    broken = without_faults(build, mutations)
    outcomes = {"seen": [], "survived": [], "does not build": []}
    for mutation in mutations:
        start = time.monotonic()
        outcome, detail = seed(build, mutation, broken)
        outcomes[outcome].append(mutation)
        seconds = time.monotonic() - start
        print(f"{outcome:9} {seconds:4.0f} s  {mutation['name']}  {detail}", flush=True)
    for mutation in outcomes["survived"]:
        print(f"survived: {mutation['name']} [{mutation['file']}]: {mutation['why']}"
              + (f" Known: {mutation['unseen']}" if "unseen" in mutation else ""))
    share = 100 * len(outcomes["seen"]) / max(1, len(mutations))
    print(f"{len(outcomes['seen'])} of {len(mutations)} faults are seen: {share:.0f} %")
    surprising = [m for m in outcomes["survived"] if "unseen" not in m]
    return 1 if surprising or outcomes["does not build"] or broken else 0


if __name__ == "__main__":
    sys.exit(main())
