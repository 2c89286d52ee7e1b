"""What type checkers and help() are told is what is there."""

import importlib.util
import inspect
import os
import subprocess
import sys
import unittest

from program import ProgramTest

import tribotrack


class Types(ProgramTest):
    def check(self, *command):
        done = subprocess.run(
            [sys.executable, "-m", *map(str, command)], cwd=self.folder, capture_output=True, text=True, check=False,
            env={**os.environ, "MYPYPATH": os.environ["PYTHONPATH"]},
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    @unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy is not installed")
    def test_the_package_and_its_users_pass_mypy(self):
        (self.folder / "user.py").write_text(
            "import numpy as np\n"
            "import tribotrack\n"
            "run = tribotrack.simulate(mu1=0.1, phi_rad='pi/2')\n"
            "x: float = run.end_x_mm + float(run.x_mm[0])\n"
            "track = tribotrack.track(np.zeros((3, 4, 5), np.uint8), fps=1, marker=(1, 2, 3))\n"
            "last: int = int(track.frame[-1])\n"
            "fitted = tribotrack.fit({'phi_rad': [1]}, amplitude_mm=1)\n"
        )
        self.check("mypy", "--strict", "--cache-dir=cache", "-p", "tribotrack")
        self.check("mypy", "--strict", "--cache-dir=cache", "user.py")
        (self.folder / "wrong.py").write_text("import tribotrack\ntribotrack.simulate(mu3=0.1).end_z_mm\n")
        with self.assertRaisesRegex(AssertionError, 'mu3"(.|\n)*end_z_mm'):
            self.check("mypy", "--strict", "--cache-dir=cache", "wrong.py")

    @unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy is not installed")
    def test_the_stub_is_of_the_extension(self):
        self.check("mypy.stubtest", "tribotrack._core")

    def test_every_function_tells_of_every_keyword(self):
        for name in tribotrack.__all__:
            thing = getattr(tribotrack, name)
            if inspect.isfunction(thing):
                for keyword in inspect.signature(thing).parameters:
                    self.assertRegex(thing.__doc__, rf"\b{keyword}\b", f"{name}: {keyword}")


if __name__ == "__main__":
    unittest.main()
