"""Renders can be stopped, and leave other threads of Python running."""
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import skywave

# It would take hours, in tiles of a fraction of a second.
LONG = {"size": (4000, 3000), "spp": 4096}
STARTED = """
import skywave
once = iter(["started"])
def progress(done):
    for word in once: print(word, flush=True)
"""


def take_interrupts():
    """What nohup or a shell starts in the background ignores SIGINT, and so do its children."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class InterruptTest(unittest.TestCase):
    def stop(self, script):
        """Sends SIGINT to a script that has begun to render; returns its last line on stderr."""
        process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=os.environ,
                                   preexec_fn=take_interrupts)
        try:
            self.assertEqual(process.stdout.readline().strip(), "started")
            start = time.monotonic()
            process.send_signal(signal.SIGINT)
            errors = process.communicate(timeout=60)[1]
            self.assertLess(time.monotonic() - start, 30)
        finally:
            process.kill()
            process.communicate()
        self.assertNotEqual(process.returncode, 0)
        return errors.strip().split("\n")[-1]

    def test_ctrl_c_stops_a_render(self):
        script = STARTED + f"skywave.render('gallery', progress=progress, **{LONG})\n"
        self.assertEqual(self.stop(script), "KeyboardInterrupt")

    def test_ctrl_c_stops_a_render_without_progress(self):
        script = ("import skywave, threading\n"
                  "threading.Timer(2, lambda: print('started', flush=True)).start()\n"
                  f"skywave.render('gallery', **{LONG})\n")
        self.assertEqual(self.stop(script), "KeyboardInterrupt")

    def test_ctrl_c_stops_converge(self):
        script = STARTED + ("skywave.converge('gallery', budgets=[1], reference_spp=8192, "
                            "size=(1600, 1200), progress=progress)\n")
        self.assertEqual(self.stop(script), "KeyboardInterrupt")

    def test_progress_stops_a_render(self):
        with self.assertRaises(skywave.Canceled):
            skywave.render("gallery", progress=lambda done: False, **LONG)

    def test_exceptions_of_progress_pass_through(self):
        def progress(done):
            raise ZeroDivisionError("mine")
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            skywave.render("gallery", progress=progress, **LONG)
        with self.assertRaisesRegex(TypeError, "callable"):
            skywave.render("gallery", progress=3, **LONG)

    def test_other_threads_run_during_a_render(self):
        stop = threading.Event()
        ended = []

        def run():
            try:
                skywave.render("gallery", progress=lambda done: not stop.is_set(), **LONG)
            except skywave.Canceled:
                ended.append(True)

        thread = threading.Thread(target=run)
        thread.start()
        # If the render kept the lock, this thread would not count at all before the render's end.
        for _ in range(20):
            time.sleep(0.02)
        self.assertTrue(thread.is_alive())
        stop.set()
        thread.join(60)
        self.assertEqual(ended, [True])

    def test_threads_share_a_scene(self):
        scene = skywave.Scene("furnace")
        pictures = []
        threads = [threading.Thread(target=lambda: pictures.append(
            skywave.render(scene, size=(40, 30), spp=2).rgb.tobytes())) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual((len(pictures), len(set(pictures))), (4, 1))


if __name__ == "__main__":
    unittest.main()
