"""Long work: other threads go on, Ctrl-C ends it at once, and what comes after works as before."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np
from results_test import CONDITIONS, table

import tribotrack


def endless_track():
    """Frames of a noisy disc that would take minutes, all of them the same memory."""
    picture = np.random.default_rng(1).integers(60, 80, (400, 400)).astype(np.uint8)
    y, x = np.mgrid[:400, :400]
    picture[np.hypot(x - 200, y - 200) < 60] = 170
    frames = np.lib.stride_tricks.as_strided(picture, (200000, 400, 400), (0, 400, 1))
    return tribotrack.track(frames, fps=1000, disc=(200, 200, 60), marker="none", threads=1)


LONG_WORK = {
    "simulate": lambda: tribotrack.simulate(dtau_rad=1, cycles=100000, samples_per_cycle=100),
    "sweep": lambda: tribotrack.sweep(over={"phi_rad": np.linspace(0, 6, 3000), "dtau_rad": np.linspace(0.1, 3, 1000)}),
    "track": endless_track,
    "fit": lambda: tribotrack.fit(table(), bootstrap=1000000, **CONDITIONS),
}


class Released(unittest.TestCase):
    def test_another_thread_goes_on(self):
        ticks = []
        over = threading.Event()

        def tick():
            while not over.wait(0.005):
                ticks.append(time.monotonic())

        clock = threading.Thread(target=tick)
        clock.start()
        begun = time.monotonic()
        tribotrack.simulate(dtau_rad=1, cycles=20000, samples_per_cycle=50)
        took = time.monotonic() - begun
        over.set()
        clock.join()
        during = [at for at in ticks if begun < at < begun + took]
        self.assertGreater(took, 0.1, "too short to show anything")
        self.assertGreater(len(during), 5 * took / 0.1)

    def test_ctrl_c_is_heard_at_once(self):
        for name, work in LONG_WORK.items():
            with self.subTest(name):
                pressed = []

                def press():
                    pressed.append(time.monotonic())
                    os.kill(os.getpid(), signal.SIGINT)

                timer = threading.Timer(0.4, press)
                timer.start()
                with self.assertRaises(KeyboardInterrupt):
                    work()
                    self.fail("the work was over before it could be interrupted")
                self.assertLess(time.monotonic() - pressed[0], 0.5)
                self.assertEqual(tribotrack.simulate(cycles=1)["cycles"], 1)

    def test_the_interpreter_ends_after_the_work_that_ctrl_c_left(self):
        script = """
import os, signal, threading, time
from tribotrack._calling import _released
signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
_released(lambda tell: (time.sleep(1), print("over")), None)
"""
        ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertIn("KeyboardInterrupt", ended.stderr)
        self.assertEqual(ended.stdout, "over\n")

    def test_what_progress_raises_ends_the_work(self):
        class Enough(Exception):
            pass

        def progress(stage, done, total):
            raise Enough(stage, done, total)

        with self.assertRaises(Enough) as enough:
            tribotrack.sweep(
                over={"phi_rad": np.linspace(0, 6, 3000), "dtau_rad": np.linspace(0.1, 3, 1000)}, progress=progress
            )
        stage, done, total = enough.exception.args
        self.assertEqual((stage, total), ("sweep", 3000000))
        self.assertLess(done, total)


if __name__ == "__main__":
    unittest.main()
