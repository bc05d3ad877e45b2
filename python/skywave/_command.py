"""The command `skywave` of a wheel: the program that the wheel holds."""
import os
import sys


def main():
    """Becomes the program, with the arguments of this process."""
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "skywave")
    try:
        os.execv(program, ["skywave", *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"skywave: {program} does not start: {error.strerror}; install the wheel again")
