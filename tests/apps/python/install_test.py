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
        done = subprocess.run([sys.executable, "-m", "venv", venv], capture_output=True, text=True, check=False)
        if done.returncode:
            self.skipTest("no venv: " + done.stdout)
        # Without NumPy, which arrays need: measurements and fits.
        fit = f"tribotrack.fit({str(SOURCE / 'data/example/alpha_v.csv')!r}, amplitude_mm=0.28, frequency_hz=9.995, phase_shift_rad='90deg')"
        for command, said in [
            (["pip", "install", "--no-index", "--disable-pip-version-check", SOURCE / "apps/python"], "Successfully installed tribotrack-"),
            (["python", "-c", f"import tribotrack; print(tribotrack.__file__, {fit})"], "\n  mu1            0.09"),
            (["tribotrack", "--version"], "tribotrack "),
            (["pip", "check"], "No broken requirements"),
        ]:
            done = subprocess.run([venv / "bin" / command[0], *command[1:]], capture_output=True, text=True, check=False, cwd=self.folder,
                                  env={"PATH": "/usr/bin:/bin", "HOME": str(self.folder)})
            self.assertIn(said, done.stdout, done.stderr)


if __name__ == "__main__":
    unittest.main()
