"""The examples run as their users would run them."""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import unittest

from program import SOURCE, ProgramTest

import tribotrack
from results_test import campaign_text, table

EXAMPLES = SOURCE / "apps/python/examples"


class Examples(ProgramTest):
    def said(self, *command):
        environment = {**os.environ, "MPLCONFIGDIR": str(self.folder)}
        done = subprocess.run(
            [*map(str, command)], cwd=self.folder, capture_output=True, text=True, env=environment, check=False
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_figure_7a_is_drawn(self):
        said = self.said(sys.executable, EXAMPLES / "figure7a.py", "figure.png")
        self.assertIn("steady motion: slope -1.0000 rad per rad", said)
        self.assertRegex(said, r"from rest: at most 2\.\d deg off that line")
        self.assertGreater((self.folder / "figure.png").stat().st_size, 10000)

    def check_fit(self, said):
        rows = re.findall(r"^(\w+) +([0-9.]+) +([0-9.]+) +([0-9.]+)$", said, re.MULTILINE)
        self.assertEqual([row[0] for row in rows], ["mu1", "mu2", "phase_lag_rad"])
        for name, truth, estimate, sd in rows:
            self.assertLess(abs(float(estimate) - float(truth)), 4 * float(sd), name)

    def test_a_table_is_fitted_with_pandas_and_without(self):
        with_pandas = self.said(sys.executable, EXAMPLES / "fit_table.py")
        self.check_fit(with_pandas)
        (self.folder / "pandas.py").write_text("raise ImportError\n")
        without = self.said(
            sys.executable, "-c",
            f"import sys, runpy; sys.path.insert(0, '.'); runpy.run_path('{EXAMPLES / 'fit_table.py'}')",
        )
        (self.folder / "pandas.py").unlink()
        self.assertEqual(without, with_pandas)

    @unittest.skipUnless(importlib.util.find_spec("pandas") and importlib.util.find_spec("matplotlib"), "no pandas or matplotlib")
    def test_the_notebook_runs_and_shows_a_fit(self):
        cells = json.loads((EXAMPLES / "campaign.ipynb").read_text())["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        shown = "print(fit._repr_html_(), fit, run, swept, sep='\\n')"
        script = "\n".join(["import matplotlib", "matplotlib.use('Agg')", f"import os; os.chdir({str(SOURCE)!r})", *code, shown])
        said = self.said(sys.executable, "-c", script)
        self.assertIn("<td>mu1</td>", said)
        self.assertRegex(said, r"\n  mu1 +0\.\d+\(\d+\) ")
        self.assertIn("\nSimulation of 10 cycles: alpha ", said)
        self.assertIn("\nSweep over phi_rad (63 values) and dtau_rad (3 values)\n", said)

    def results(self):
        track = tribotrack.track(
            self.rendered(), disc_diameter_mm=6, marker=(24, 24, 10), output=self.folder / "track.csv"
        )
        (self.folder / "campaign.toml").write_text(campaign_text(table()))
        done = self.run_program("fit", "campaign.toml", "-o", "fit.json", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        fit = tribotrack.fit(self.folder / "campaign.toml")
        ok = track["status"] == "ok"
        x = track["x_px"][ok]
        mu1 = fit["parameters"]["mu1"]
        return (
            f"{len(ok)} frames, {ok.sum()} ok, x from {x.min():.3f} to {x.max():.3f} px\n"
            f"mu1 = {mu1['estimate']:.7f}, sd {mu1['sd']:.7f}\n"
        )

    @unittest.skipUnless(shutil.which("octave"), "octave is not installed")
    def test_octave_reads_the_results(self):
        expected = self.results()
        said = self.said("octave", "--no-gui", "--quiet", "--no-init-file", EXAMPLES / "read_results.m", "track.csv", "fit.json")
        self.assertEqual(said, expected)

    @unittest.skipUnless(shutil.which("Rscript"), "R is not installed")
    def test_r_reads_the_results(self):
        expected = self.results()
        said = self.said("Rscript", "--vanilla", EXAMPLES / "read_results.R", "track.csv", "fit.json")
        self.assertEqual(said, expected)


if __name__ == "__main__":
    unittest.main()
