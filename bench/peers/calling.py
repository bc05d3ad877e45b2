"""Shared by the calls of all programs: jobs, sessions, how a program is found, run and read."""

import os
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable


class Failed(Exception):
    """A program refused, or printed something that is not understood."""


def as_text(data):
    """Decodes what a program prints; a line that it has drawn over becomes lines."""
    return data.decode(errors="replace").replace("\r", "\n")


def run_for_bytes(command, folder=None, variables=None, errors=subprocess.PIPE):
    """Returns the output of a command; STDOUT as `errors` adds its errors."""
    result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=errors,
                            stdin=subprocess.DEVNULL, cwd=folder,
                            env={**os.environ, **(variables or {})})
    if result.returncode:
        said = as_text(result.stdout if result.stderr is None else result.stderr).split("\n")
        said = [line for line in said if line.strip()]
        raise Failed(f"{Path(command[0]).name}: "
                     + (said[-1].strip() if said else f"exit code {result.returncode}"))
    return result.stdout


def run(command, folder=None, variables=None):
    """Returns output and errors of a command together."""
    return as_text(run_for_bytes(command, folder, variables, subprocess.STDOUT))


def found(pattern, text, what):
    match = re.search(pattern, text)
    if not match:
        raise Failed(f"{what} is not in the program's output")
    return match.groups()


def seconds_by_difference(one, whole, samples):
    """Returns the time of all samples from that of one and of all, preparation included in both."""
    seconds = (whole - one) * samples / (samples - 1)
    if seconds <= 0:
        raise Failed("the samples take too little time to be separated from the rest: take more")
    return seconds


@dataclass
class Job:
    """Work that several programs do alike."""
    name: str
    title: str
    scene: str
    integrator: str
    samples: int    # per pixel
    depth: int      # surfaces per path
    lights: int     # directional, all used at every hit; 0: the map itself


@dataclass
class Session:
    """Files and settings that all programs share."""
    program: Path       # skywave
    folder: Path
    environment: Path   # of bench/peers/setup.sh
    size: tuple
    threads: int
    scenes: dict        # name: scene.Scene
    map_widths: dict    # name: texels
    lights: list = field(default_factory=list)
    # {"direction": [right, forward, up], "irradiance": [r, g, b]}
    hashes: dict = field(default_factory=dict)  # name of a scene: of its files, map and program
    made: set = field(default_factory=set)      # names of the files that `make` has made

    def file(self, name):
        return self.folder / name

    def make(self, name, write):
        """Returns the file `name`, which write(file) makes once.

        One that an earlier session has left is made anew, because it may be of other data.
        """
        file = self.file(name)
        if name not in self.made:
            write(file)
            self.made.add(name)
        return file


def on_path(executable):
    """Returns a finder of a program of the system."""
    return lambda environment: shutil.which(executable)


def in_environment(folder):
    """Returns a finder of the Python of one of setup.sh's environments."""
    def find(environment):
        python = environment / folder / "bin" / "python"
        return str(python) if python.is_file() else None
    return find


def debian_version(package):
    def version(environment):
        if not shutil.which("dpkg-query"):
            return ""
        result = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package],
                                capture_output=True, text=True)
        return result.stdout.strip() if result.returncode == 0 else ""
    return version


def package_version(folder, package):
    """Returns a finder of the version of a Python package in one of setup.sh's environments."""
    def version(environment):
        found_here = (environment / folder).glob(f"lib/python*/site-packages/{package}-*.dist-info")
        return next((path.name.split("-")[1].removesuffix(".dist") for path in found_here), "")
    return version


@dataclass
class Program:
    name: str
    find: Callable             # environment -> executable, or nothing if it is not installed
    absent: str                # what is said then
    version: Callable          # environment -> version, or nothing
    jobs: tuple                # names of the jobs that it supports
    measure: Callable          # session, job, seed -> seconds, picture and further figures
    timing: str                # how its time is measured
    settings: str              # settings that differ from the others, or were chosen for it
    has_seeds: bool = True     # whether repeats are independent
    share: float = 1           # of the samples, for programs that would take too long
