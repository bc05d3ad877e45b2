#!/usr/bin/env python3
"""Tests the profile for the Phoronix Test Suite in bench/phoronix: its elements are those of the
suite's schemas, in their order, with values of their types; install.sh makes the program that the
profile names; and the suite's way to read results finds the figures in what that program prints.

    phoronix_test.py PROGRAM
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROFILE = ROOT / "bench/phoronix"

# What the schemas of OpenBenchmarking.org (Phoronix Test Suite 10.8) ask of the elements that the
# profile has. Elements of a group come in the order of the schema, which these lists keep.
TEXT = r"(?s).+"
LIST = r"[^,]+(, [^,]+)*"
NUMBER, COUNT = r"\d+(\.\d+)?", r"[1-9]\d*"
DEFINITION = {
    "TestInformation": [
        ("Title", r".{2,50}"), ("AppVersion", TEXT), ("Description", r".{0,2048}"),
        ("ResultScale", TEXT), ("Proportion", r"LIB|HIB|ABSTRACT"),
        ("ResultQuantifier", r"AVG|MIN|MAX"), ("SubTitle", TEXT), ("Executable", TEXT),
        ("TimesToRun", COUNT)],
    "TestProfile": [
        ("Version", r"\d\.\d{1,2}\.\d{1,2}"), ("SupportedPlatforms", r".{0,95}"),
        ("SoftwareType",
         r"BaseTestProfile|Utility|Simulator|Scientific|Benchmark|Application|Game"),
        ("TestType", r"System|Processor|Disk|Graphics|Memory|Network|OS|Other"),
        ("License", r"Free|Non-Free|Retail|Restricted"),
        ("Status", r"Verified|Unverified|Private|Broken|Experimental|Deprecated"),
        ("SupportedArchitectures", LIST), ("ExternalDependencies", LIST),
        ("EnvironmentSize", NUMBER), ("ProjectURL", r"https?://.{5,}"),
        ("InternalTags", LIST), ("Maintainer", TEXT), ("SystemDependencies", LIST)],
    "TestSettings": [
        ("Default", [("Arguments", TEXT), ("PostArguments", TEXT)]),
        ("Option", [("DisplayName", TEXT), ("Identifier", TEXT), ("ArgumentPrefix", TEXT),
                    ("Menu", [("Entry", [("Name", TEXT), ("Value", TEXT)])])])]}
# Of these the suite says TEST_REQUIRES; the schema itself requires Version alone.
REQUIRED = ["Title", "Description", "ResultScale", "Proportion", "Version", "SupportedPlatforms",
            "SoftwareType", "TestType", "License", "Status", "Maintainer"]
RESULTS = {
    "ResultsParser": [
        ("OutputTemplate", TEXT), ("MatchToTestArguments", TEXT), ("ResultKey", TEXT),
        ("LineHint", TEXT), ("ResultScale", TEXT), ("ResultProportion", TEXT),
        ("AppendToArgumentsDescription", TEXT), ("Importance", r"Secondary")]}
DOWNLOADS = {
    "Downloads": [("Package", [("URL", r"https?://.+"), ("MD5", r"[0-9a-f]{32}"),
                               ("SHA256", r"[0-9a-f]{64}"), ("FileName", TEXT),
                               ("FileSize", COUNT)])]}
NAMES_OF_DEPENDENCIES = {"build-utilities", "cmake", "libpng-development", "jpeg-development",
                         "zlib-development", "openexr", "git", "fftw3-development"}


def problems_of(element, allowed):
    """Yields what is wrong with the children of an element, each (name, pattern or children)."""
    names = [name for name, _ in allowed]
    places = []
    for child in element:
        if child.tag not in names:
            yield f"{element.tag} has no {child.tag}"
            continue
        places.append(names.index(child.tag))
        value = allowed[places[-1]][1]
        if isinstance(value, list):
            yield from problems_of(child, value)
        elif not re.fullmatch(value, child.text or ""):
            yield f"{child.tag}: {child.text!r} is not {value}"
    if places != sorted(places):
        yield f"the children of {element.tag} are not in the order of the schema"


def problems_of_file(text, groups):
    root = xml.etree.ElementTree.fromstring(text)
    if root.tag != "PhoronixTestSuite":
        yield f"the root is {root.tag}"
    yield from problems_of(root, list(groups.items()))


def tokens(line):
    """Returns the words of a line as the suite cuts it."""
    return re.sub(r"[()\t]", " ", line.replace("=", " = ")).split()


def parse_result(parser, output):
    """Returns the number that the suite finds: in the last line with the hint, the word at the
    place that #_RESULT_# has in the template. None if there is none."""
    template = parser.findtext("OutputTemplate")
    hint = parser.findtext("LineHint")
    lines = [line for line in output.split("\n") if hint in line]
    assert hint in template
    place = tokens(template).index("#_RESULT_#")
    words = tokens(lines[-1]) if lines else []
    try:
        return float(words[place])
    except (IndexError, ValueError):
        return None


def read(name):
    return (PROFILE / name).read_text(encoding="utf-8")


class PhoronixProfile(unittest.TestCase):
    def assert_fits(self, text, groups):
        self.assertEqual(list(problems_of_file(text, groups)), [])

    def test_there_are_the_four_files_and_no_others(self):
        self.assertEqual(sorted(path.name for path in PROFILE.iterdir()),
                         ["downloads.xml", "install.sh", "results-definition.xml",
                          "test-definition.xml"])

    def test_the_files_fit_the_schemas(self):
        self.assert_fits(read("test-definition.xml"), DEFINITION)
        self.assert_fits(read("results-definition.xml"), RESULTS)
        self.assert_fits(read("downloads.xml"), DOWNLOADS)
        root = xml.etree.ElementTree.fromstring(read("test-definition.xml"))
        for name in REQUIRED:
            self.assertEqual(len(root.findall(f".//{name}")), 1, name)
        dependencies = root.findtext(".//ExternalDependencies").split(", ")
        self.assertLessEqual(set(dependencies), NAMES_OF_DEPENDENCIES)
        results = xml.etree.ElementTree.fromstring(read("results-definition.xml"))
        self.assertTrue(results.findall("ResultsParser/OutputTemplate"))

    def test_a_file_that_does_not_fit_is_seen(self):
        text = read("test-definition.xml")
        for old, new in (("<Proportion>HIB", "<Proportion>MORE"), ("<License>Free", "<License>MIT"),
                         ("TestType>", "TestKind>"), ("<Version>1.0.0", "<Version>1"),
                         ("<TestSettings>", "<TestSettings><Frob>1</Frob>")):
            self.assertIn(old, text)
            self.assertTrue(list(problems_of_file(text.replace(old, new), DEFINITION)), new)
        moved = re.sub(r"(<Title>.*?</Title>)(.*?)(<TimesToRun>.*?</TimesToRun>)", r"\3\2\1", text,
                       flags=re.S)
        self.assertTrue(list(problems_of_file(moved, DEFINITION)))

    def test_versions_are_those_of_the_program(self):
        said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True)
        version = said.stdout.split()[1]
        self.assertIn(f"<AppVersion>{version}</AppVersion>", read("test-definition.xml"))
        self.assertIn(f"<FileName>skywave-{version}.tar.gz</FileName>", read("downloads.xml"))
        self.assertIn(f"tar -xzf skywave-{version}.tar.gz", read("install.sh"))

    def test_the_installed_program_prints_results_that_the_suite_finds(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            # Building takes minutes: this stands for cmake, and lays the program where that does.
            stand_in = folder / "bin/cmake"
            stand_in.parent.mkdir()
            stand_in.write_text("#!/bin/sh\n"
                                f"case $1 in --build) cp '{PROGRAM}' build/skywave ;;\n"
                                "*) mkdir -p build ;; esac\n")
            stand_in.chmod(0o755)
            (folder / "bin/tar").write_text("#!/bin/sh\n")
            (folder / "bin/tar").chmod(0o755)
            shutil.copy(PROFILE / "install.sh", folder)
            environment = {"PATH": f"{folder}/bin:/usr/bin:/bin", "HOME": str(folder),
                           "NUM_CPU_CORES": "2", "LOG_FILE": str(folder / "log")}
            subprocess.run(["sh", "install.sh"], cwd=folder, env=environment, check=True)
            self.assertEqual((folder / "install-exit-status").read_text().strip(), "0")
            definition = xml.etree.ElementTree.fromstring(read("test-definition.xml"))
            arguments = (definition.findtext(".//Default/Arguments") + " " +
                         definition.findtext(".//Entry/Value"))
            arguments = arguments.replace("--repetitions 5", "--repetitions 1").split()
            command = folder / definition.findtext(".//Executable")
            subprocess.run([command, *arguments], cwd="/", env=environment, check=True)
            self.assertEqual((folder / "test-exit-status").read_text().strip(), "0")
            output = (folder / "log").read_text()
        printed = dict(re.findall(r"(\w+)=([\d.]+)",
                                  next(line for line in output.split("\n")
                                       if line.startswith("SUMMARY"))))
        parsers = xml.etree.ElementTree.fromstring(read("results-definition.xml"))
        found = [parse_result(parser, output) for parser in parsers]
        self.assertEqual(found, [float(printed["msamples_per_s"]), float(printed["mrays_per_s"])])
        self.assertIsNone(parse_result(parsers[0], "no score\n"))


if __name__ == "__main__":
    unittest.main()
