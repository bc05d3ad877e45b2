#!/usr/bin/env python3
"""Tests what becomes of outputs that cannot be written: on a full disk, beyond the limit of file
sizes, in a folder that is only for reading or below a file, to a standard output that is full,
closed or that nobody reads, to a standard error that is full or closed, and when the process is
killed while it writes.

    tests/cli/output_failures_test.py PROGRAM

Every command that writes files has to end with an error that names one of them and the reason, to
leave all files what they were, and no temporary one. After SIGKILL the next run removes that.
Checkpoints and snapshots, whose failures end no render, are left to the tests of sessions. Runs in
a name space of its own, where it can mount small file systems.
"""
import errno
import os
import pathlib
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

EXIT_IO = 74
OLD = b"the old file"
SMALL = "--size 24x16 --spp 1"
# What each command writes into the folder {out}. The files that it reads are made by setUpModule.
COMMANDS = {
    "render": (f"render spheres {SMALL} -q -o {{out}}/a.exr", ["a.exr", "a.png"]),
    "render --film": (f"render spheres {SMALL} -q --film {{out}}/a.film", ["a.film"]),
    "render --stats": ("render spheres --size 4x4 --spp 1 -q -o in/b.exr --stats {out}/a.json",
                       ["a.json"]),
    "merge": ("merge in/noisy.film -q -o {out}/a.exr", ["a.exr", "a.png"]),
    "merge to a film": ("merge in/noisy.film -q -o {out}/a.film", ["a.film"]),
    "denoise": ("denoise in/noisy.exr -q -o {out}/a.exr", ["a.exr", "a.png"]),
    "relight": ("relight in/noisy.exr -q -o {out}/a.exr", ["a.exr", "a.png"]),
    "paths": (f"paths spheres {SMALL} --max-depth 1 -q -o {{out}}/a.exr", ["a.exr", "a.png"]),
    "info": ("info spheres --json {out}/a.json", ["a.json"]),
    "compare": ("compare in/noisy.exr in/noisy.exr --json {out}/a.json --map {out}/a.png",
                ["a.json", "a.png"]),
    "converge": ("converge spheres --size 24x16 --strategies importance --budgets 1 --repeats 2 "
                 "--reference-spp 2 -q --json {out}/a.json --plot {out}/a.svg "
                 "--report {out}/a.html",
                 ["a.json", "a.svg", "a.html"]),
    "bench": (f"bench spheres {SMALL} --repetitions 1 --json {{out}}/a.json", ["a.json"]),
    "bench --copies": (f"bench spheres {SMALL} --repetitions 1 --copies 1 --json {{out}}/a.json",
                       ["a.json"]),
    "bench --update-baseline": (
        f"bench spheres {SMALL} --repetitions 1 --gates counters --baseline {{out}}/a.baseline "
        "--update-baseline new", ["a.baseline"]),
    "bench --sustain": (f"bench spheres {SMALL} --sustain 0.1 --json {{out}}/a.json", ["a.json"]),
    "probe assemble": (
        "probe assemble in/sky.pfm in/sky.pfm --times 1/4,1 -o {out}/a.exr", ["a.exr"]),
    "probe calibrate": ("probe calibrate --height 8 -o {out}/a.exr", ["a.exr"]),
    "probe convert to EXR": ("probe convert in/sky.pfm {out}/a.exr --to angular", ["a.exr"]),
    "probe convert to HDR": ("probe convert in/sky.pfm {out}/a.hdr --to angular", ["a.hdr"]),
    "probe convert to PFM": ("probe convert in/sky.pfm {out}/a.pfm --to angular", ["a.pfm"]),
    "probe convert to faces": (
        "probe convert in/sky.pfm {out}/a.exr --to cube-faces",
        [f"a-{face}.exr" for face in ("right", "left", "up", "down", "front", "back")]),
    "probe info": ("probe info in/sky.pfm --json {out}/a.json", ["a.json"]),
    "probe join": ("probe join in/ball.pfm in/ball.pfm --height 8 -o {out}/a.exr", ["a.exr"]),
    "probe lights": ("probe lights in/sky.pfm --output {out}/a.json", ["a.json"]),
    "probe lights --residual": (
        "probe lights in/sky.pfm --strata variation --residual {out}/a.exr", ["a.exr"]),
    "probe plot": ("probe plot in/sky.pfm -o {out}/a.png", ["a.png"]),
    "probe presample": ("probe presample in/sky.pfm -o {out}/a.json --cells {out}/a.png",
                        ["a.json", "a.png"]),
}
# What is there before, where a command reads what it replaces; setUpModule makes it.
OLD_FILES = {}
# Commands that print, besides what they write.
PRINTING = [
    "options", "options --json", "--help", "--version", "render --help", "strategies",
    "info spheres", "probe info in/sky.pfm", "probe lights in/sky.pfm",
    "compare in/noisy.exr in/noisy.exr", f"bench spheres {SMALL} --repetitions 1",
    f"bench spheres {SMALL} --counters", "batch in/job.toml --list",
    f"render spheres {SMALL} -o in/b.exr", f"render spheres {SMALL} -o in/b.exr --progress openjd",
    "merge in/noisy.film -o in/b.exr", "denoise in/noisy.exr -o in/b.exr",
    "relight in/noisy.exr -o in/b.exr", "probe convert in/sky.pfm in/b.exr --to angular"]
# Commands that print only to standard error, with their exit codes.
TELLING = {
    "probe lights in/sky.pfm --output in/b.json": 0,
    "probe presample in/bad.pfm -o in/b.json": 0,
    "render nothere.obj -o in/b.exr": 65,
    "probe info nothere.pfm": 74,
    "render in/sky.pfm -o in/b.exr": 65,
    "render spheres --spp none": 64,
}


def start(arguments, **options):
    """Starts the program with `arguments`, which have no blanks."""
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
               "cwd": SCRATCH} | options
    return subprocess.Popen([PROGRAM, *arguments.split()], **options)


def run(arguments, **options):
    """Returns the exit code and what was printed to standard error."""
    process = start(arguments, **options)
    _, errors = process.communicate(timeout=120)
    return process.returncode, errors.decode() if errors else ""


def files_in(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def parts_in(folder):
    return [name for name in os.listdir(folder) if name.endswith(".part")]


def limit_files(size):
    """For the next program: no file gets larger."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def mount(folder, options):
    folder.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=True)


def fill(folder):
    """Leaves the file system of `folder` without room for a byte."""
    with open(folder / "filler", "wb", buffering=0) as filler:
        for size in (4096, 1):
            try:
                while True:
                    filler.write(bytes(size))
            except OSError as error:
                assert error.errno == errno.ENOSPC, error


def setUpModule():
    folder = SCRATCH / "in"
    folder.mkdir()
    rows = b"".join(struct.pack("<3f", x / 16, y / 8, 30 if (x, y) == (3, 2) else 1)
                    for y in range(8) for x in range(16))
    (folder / "sky.pfm").write_bytes(b"PF\n16 8\n-1.0\n" + rows)
    ball = b"".join(struct.pack("<3f", x / 48, y / 24, 1) for y in range(48) for x in range(48))
    (folder / "ball.pfm").write_bytes(b"PF\n48 48\n-1.0\n" + ball)
    (folder / "bad.pfm").write_bytes(b"PF\n16 8\n-1.0\n" + struct.pack("<f", float("nan"))
                                     + rows[4:])
    (folder / "job.toml").write_text('[base]\nscene = "spheres"\nsize = "24x16"\nspp = 1\n[axes]\n'
                                     'seed = "1-2"\n[output]\npath = "{seed}.exr"\n')
    code, errors = run("render spheres --size 24x16 --spp 8 --aovs denoiser,lights -q "
                       "-o in/noisy.exr --film in/noisy.film")
    assert code == 0, errors
    code, errors = run(COMMANDS["bench --update-baseline"][0].format(out="in"))
    assert code == 0, errors
    OLD_FILES["a.baseline"] = (folder / "a.baseline").read_bytes()


class Files(unittest.TestCase):
    """Every command, where its files cannot be written."""

    def put_old(self, folder, names):
        for name in names:
            (folder / name).write_bytes(OLD_FILES.get(name, OLD))

    def expect_failure(self, folder, command, reason, before=None, **options):
        arguments, names = COMMANDS[command]
        code, errors = run(arguments.format(out=folder), **options)
        self.assertEqual(code, EXIT_IO, errors)
        self.assertTrue(any(f"{folder}/{name}: " in errors for name in names), errors)
        self.assertIn(reason, errors)
        if before is not None:
            self.assertEqual(files_in(folder), before)

    def test_limit_of_file_sizes(self):
        for command, (_, names) in COMMANDS.items():
            with self.subTest(command), tempfile.TemporaryDirectory(dir=SCRATCH) as scratch:
                folder = pathlib.Path(scratch)
                self.put_old(folder, names)
                # The picture that belongs to statistics is written first.
                limit = 1800 if command == "render --stats" else 60
                self.expect_failure(folder, command, "File too large", files_in(folder),
                                    preexec_fn=lambda: limit_files(limit))

    def test_full_disk(self):
        self.need_mounts()
        for command, (_, names) in COMMANDS.items():
            with self.subTest(command):
                folder = SCRATCH / "full"
                mount(folder, "size=64k")
                try:
                    self.put_old(folder, names)
                    fill(folder)
                    self.expect_failure(folder, command, "No space left on device",
                                        files_in(folder))
                finally:
                    subprocess.run(["umount", folder], check=True)

    def test_folder_for_reading_only(self):
        self.need_mounts()
        original, folder = SCRATCH / "original", SCRATCH / "fixed"
        original.mkdir()
        folder.mkdir()
        self.put_old(original, {name for _, names in COMMANDS.values() for name in names})
        subprocess.run(["mount", "--bind", original, folder], check=True)
        try:
            subprocess.run(["mount", "-o", "remount,bind,ro", folder], check=True)
            before = files_in(folder)
            for command in COMMANDS:
                with self.subTest(command):
                    self.expect_failure(folder, command, "Read-only file system", before)
        finally:
            subprocess.run(["umount", folder], check=True)

    def test_folder_that_is_a_file(self):
        folder = SCRATCH / "in/sky.pfm"
        for command in COMMANDS:
            with self.subTest(command):
                self.expect_failure(folder, command, "there is no folder")

    def test_neither_of_two_files_is_replaced(self):
        # The PNG fits, and the EXR does not.
        names = ["a.exr", "a.png"]
        for command, larger in (("render", " --aovs all"), ("merge", " --compression none")):
            with self.subTest(command), tempfile.TemporaryDirectory(dir=SCRATCH) as scratch:
                folder = pathlib.Path(scratch)
                arguments = COMMANDS[command][0].format(out=folder) + larger
                self.assertEqual(run(arguments), (0, ""))
                sizes = {name: len(data) for name, data in files_in(folder).items()}
                limit = sizes["a.png"] + 100
                self.assertLess(limit, sizes["a.exr"])
                self.put_old(folder, names)
                code, errors = run(arguments, preexec_fn=lambda: limit_files(limit))
                self.assertEqual(code, EXIT_IO)
                self.assertIn(f"{folder}/a.exr: cannot be written: File too large", errors)
                self.assertEqual(files_in(folder), {name: OLD for name in names})

    def need_mounts(self):
        if not CAN_MOUNT:
            self.skipTest("no file system can be mounted here")


class Batches(unittest.TestCase):
    """A batch whose pictures cannot be written."""

    def setUp(self):
        if not CAN_MOUNT:
            self.skipTest("no file system can be mounted here")
        self.folder = SCRATCH / "batch"

    def mount(self, options):
        mount(self.folder, options)
        self.addCleanup(subprocess.run, ["umount", self.folder], check=True)

    def test_full_disk(self):
        self.mount("size=64k")
        (self.folder / "1.exr").write_bytes(OLD)
        fill(self.folder)
        before = files_in(self.folder)
        code, errors = run(f"batch in/job.toml --force -q -o {self.folder}")
        self.assertEqual(code, EXIT_IO)
        self.assertIn(f"{self.folder}/job.batch.json: cannot be written: No space left", errors)
        self.assertEqual(files_in(self.folder), before)

    def test_large_pictures_fail_alone(self):
        # The next run makes them.
        job = SCRATCH / "in/large.toml"
        job.write_text('[base]\nscene = "spheres"\nspp = 1\n[axes]\nsize = ["8x8", "320x240"]\n'
                       '[output]\npath = "{size}.exr"\n')
        self.mount("size=4m")
        code, errors = run(f"batch {job} -q -o {self.folder}",
                           preexec_fn=lambda: limit_files(50000))
        self.assertEqual(code, EXIT_IO)
        self.assertIn("320x240.exr: cannot be written: File too large", errors)
        self.assertEqual(set(files_in(self.folder)),
                         {"8x8.exr", "8x8.png", "large.batch.json", "large.batch.html"})
        self.assertEqual(run(f"batch {job} -q -o {self.folder}"), (0, ""))
        self.assertIn("320x240.png", files_in(self.folder))

    def test_scripts_for_slurm(self):
        self.mount("size=64k")
        (self.folder / "render.sh").write_bytes(OLD)
        fill(self.folder)
        before = files_in(self.folder)
        code, errors = run(f"batch in/job.toml -q --slurm {self.folder}")
        self.assertEqual(code, EXIT_IO)
        self.assertRegex(errors, f"{self.folder}/render.sh: cannot be written: No space left")
        self.assertEqual(files_in(self.folder), before)

    def test_folder_for_reading_only(self):
        self.mount("size=64k,ro")
        code, errors = run(f"batch in/job.toml -q -o {self.folder}")
        self.assertEqual(code, EXIT_IO)
        self.assertIn("Read-only file system", errors)
        self.assertIn(str(self.folder), errors)


class StandardOutput(unittest.TestCase):
    """Commands that print, where that cannot be."""

    def test_full(self):
        for arguments in PRINTING:
            with self.subTest(arguments), open("/dev/full", "wb") as full:
                code, errors = run(arguments, stdout=full)
                self.assertEqual(code, EXIT_IO, errors)
                self.assertIn("skywave: standard output: cannot be written", errors)
                self.assertEqual(errors.count("cannot be written"), 1, errors)

    def test_closed(self):
        for arguments in PRINTING:
            with self.subTest(arguments):
                code, errors = run(arguments, stdout=None, preexec_fn=lambda: os.close(1))
                self.assertEqual(code, EXIT_IO, errors)
                self.assertIn("skywave: standard output: cannot be written", errors)

    def test_nobody_reads(self):
        for arguments in PRINTING:
            with self.subTest(arguments):
                reader, writer = os.pipe()
                os.close(reader)
                code, _ = run(arguments, stdout=writer)
                os.close(writer)
                # Progress goes on without readers; then the end of the text is not printed.
                self.assertIn(code, (-signal.SIGPIPE, EXIT_IO))

    def test_batch_goes_on(self):
        with tempfile.TemporaryDirectory(dir=SCRATCH) as folder:
            reader, writer = os.pipe()
            os.close(reader)
            code, errors = run(f"batch in/job.toml -o {folder}", stdout=writer)
            os.close(writer)
            self.assertEqual(code, 0, errors)
            with open("/dev/full", "wb") as full:
                code, errors = run(f"batch in/job.toml -o {folder}", stdout=full)
            self.assertEqual(code, EXIT_IO, errors)

    def test_quiet_commands_need_none(self):
        arguments = f"render spheres {SMALL} -q -o in/b.exr"
        self.assertEqual(run(arguments, stdout=None, preexec_fn=lambda: os.close(1)), (0, ""))

    @staticmethod
    def file_of(process, number):
        try:
            return os.readlink(f"/proc/{process.pid}/fd/{number}")
        except FileNotFoundError:
            return None

    def test_closed_streams_are_no_files(self):
        # The next file to be opened would get the number of a stream that is closed, and what is
        # printed would get into it.
        arguments = "render spheres --size 64x48 --spp 1000000 -o in/never.exr"
        for stream in (0, 1, 2):
            options = {name: None for name in ("stdin", "stdout", "stderr")[stream:stream + 1]}
            process = start(arguments, **options, preexec_fn=lambda: os.close(stream))
            try:
                # Libraries are loaded through the same number first.
                deadline = time.monotonic() + 60
                while self.file_of(process, stream) != "/dev/null":
                    self.assertLess(time.monotonic(), deadline, self.file_of(process, stream))
                    time.sleep(0.01)
            finally:
                process.kill()
                process.communicate()


class StandardError(unittest.TestCase):
    """Commands that print, where standard error does not take it."""

    def expect_code(self, arguments, expected, **options):
        with self.subTest(arguments):
            code, _ = run(arguments, **options)
            self.assertEqual(code, expected)

    def test_full(self):
        with open("/dev/full", "wb") as full:
            for arguments, code in TELLING.items():
                self.expect_code(arguments, code, stderr=full)
            for arguments in PRINTING:
                self.expect_code(arguments, 0, stderr=full)
                self.expect_code(arguments, EXIT_IO, stdout=full, stderr=full)

    def test_closed(self):
        for arguments, code in {**TELLING, **dict.fromkeys(PRINTING, 0)}.items():
            self.expect_code(arguments, code, stderr=None, preexec_fn=lambda: os.close(2))


class Kills(unittest.TestCase):
    """Commands that are killed while they write a large file."""

    LARGE = {
        "render": ("render spheres --size 800x600 --spp 1 --aovs all -q -o {out}/a.exr",
                   ["a.exr", "a.png"]),
        "render --film": ("render spheres --size 800x600 --spp 1 --aovs all -q "
                          "--film {out}/a.film", ["a.film"]),
        "denoise": ("denoise in/large.exr -q -o {out}/a.exr", ["a.exr", "a.png"]),
        "probe convert": ("probe convert in/sky.pfm {out}/a.pfm --to latlong --size 4096x2048",
                          ["a.pfm"]),
    }

    @classmethod
    def setUpClass(cls):
        code, errors = run("render spheres --size 640x480 --spp 8 --aovs denoiser -q "
                           "-o in/large.exr")
        assert code == 0, errors

    def kill_while_writing(self, command, number):
        """Kills the command at its first temporary file; returns the folder."""
        arguments, names = self.LARGE[command]
        for _ in range(20):
            folder = pathlib.Path(tempfile.mkdtemp(dir=SCRATCH))
            self.addCleanup(shutil.rmtree, folder)
            for name in names:
                (folder / name).write_bytes(OLD)
            process = start(arguments.format(out=folder))
            # The first that is not empty: there is one for a moment when the command begins, which
            # tries whether files can be made.
            while process.poll() is None and not any(
                    self.size(folder / name) for name in parts_in(folder)):
                pass
            process.send_signal(number)
            _, errors = process.communicate(timeout=120)
            if process.returncode == 0:
                continue  # it was faster
            self.assertEqual((process.returncode, errors), (-number, b""))
            return folder
        self.fail("it was always faster")

    @staticmethod
    def size(path):
        try:
            return path.stat().st_size
        except FileNotFoundError:
            return 0

    def test_signals_leave_nothing(self):
        signals = [(command, signal.SIGTERM) for command in self.LARGE]
        for command, number in [*signals, ("render --film", signal.SIGINT),
                                ("render --film", signal.SIGHUP),
                                ("render --film", signal.SIGXCPU)]:
            with self.subTest(f"{command} {number.name}"):
                folder = self.kill_while_writing(command, number)
                self.assertEqual(files_in(folder),
                                 {name: OLD for name in self.LARGE[command][1]})

    def test_next_run_removes_what_sigkill_leaves(self):
        for command, (arguments, names) in self.LARGE.items():
            with self.subTest(command):
                for _ in range(20):  # some kills come between two files
                    folder = self.kill_while_writing(command, signal.SIGKILL)
                    files = files_in(folder)
                    if parts_in(folder):
                        break
                self.assertTrue(parts_in(folder))
                self.assertEqual({name: files[name] for name in names},
                                 {name: OLD for name in names})
                self.assertEqual(run(arguments.format(out=folder))[0], 0)
                self.assertEqual(set(files_in(folder)), set(names))
                self.assertNotIn(OLD, files_in(folder).values())

    def test_ignored_signals_stay_ignored(self):
        # As under nohup.
        process = start("render spheres --size 160x120 --spp 64 -q -o in/b.exr",
                        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        while process.poll() is None:
            process.send_signal(signal.SIGHUP)
            time.sleep(0.01)
        self.assertEqual(process.wait(), 0)


def enter_name_space():
    """Runs the test again where it may mount; returns whether it may."""
    if "SKYWAVE_MAY_MOUNT" in os.environ:
        return os.environ["SKYWAVE_MAY_MOUNT"] == "1"
    unshare = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--mount", "-r"]
    tried = subprocess.run([*unshare, "mount", "-t", "tmpfs", "tmpfs", "/mnt"],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) \
        if shutil.which("unshare") else None
    may = tried is not None and tried.returncode == 0
    os.environ["SKYWAVE_MAY_MOUNT"] = str(int(may))
    if may:
        os.execvp(unshare[0], [*unshare, sys.executable, "-B", *sys.argv])
    return False


if __name__ == "__main__":
    CAN_MOUNT = enter_name_space()
    if not CAN_MOUNT:
        print("skipped: this container cannot mount", flush=True)
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    with tempfile.TemporaryDirectory() as scratch:
        SCRATCH = pathlib.Path(scratch)
        unittest.main()
