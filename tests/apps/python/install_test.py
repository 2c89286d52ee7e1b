"""pip installs module and program into a virtual environment."""

import subprocess
import sys
import unittest
from pathlib import Path

from program import BINARY, SOURCE, ProgramTest


class Install(ProgramTest):
    @unittest.skipUnless(Path(BINARY).parent == SOURCE / "build/release/apps", "another build than that of the quickstart")
    def test_pip_installs_module_and_program(self):
        venv = self.folder / "venv"
        # Debian's NumPy is seen; nothing is fetched.
        done = subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", venv], capture_output=True, text=True, check=False)
        if done.returncode:
            self.skipTest("no venv: " + done.stdout)
        for command, said in [
            (["pip", "install", "--no-index", "--disable-pip-version-check", SOURCE / "apps/python"], "Successfully installed tribotrack-"),
            (["python", "-c", "import tribotrack; print(tribotrack.__file__, tribotrack.simulate(cycles=1).cycles)"], f"{venv}/lib"),
            (["tribotrack", "--version"], "tribotrack "),
            (["pip", "show", "tribotrack"], "Requires: numpy"),
        ]:
            done = subprocess.run([venv / "bin" / command[0], *command[1:]], capture_output=True, text=True, check=False, cwd=self.folder,
                                  env={"PATH": "/usr/bin:/bin", "HOME": str(self.folder)})
            self.assertIn(said, done.stdout, done.stderr)


if __name__ == "__main__":
    unittest.main()
