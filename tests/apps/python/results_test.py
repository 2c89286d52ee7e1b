"""fit() of a file, of its structure and of a table is one fit, the program's."""

import json
import math
import tomllib
import unittest

import numpy as np
from program import SOURCE, ProgramTest

import tribotrack

TRUTH = {"mu1": 0.1, "mu2": 0.0125, "lag_rad": 0.2}
CONDITIONS = {"amplitude_mm": 0.28, "angular_frequency_rad_s": 62.8, "phase_shift_rad": "pi/2"}


def table():
    """Displacements of seven runs under known parameters, a little off."""
    runs = {"phi_rad": [0, 1.5, 3, 4.5, 0, 0, 0], "dtau_rad": [1, 1, 1, 1, 0.5, 1.5, 3]}
    ends = [
        tribotrack.simulate(phi_rad=phi, dtau_rad=dtau, **TRUTH) for phi, dtau in zip(runs["phi_rad"], runs["dtau_rad"])
    ]
    off = [1.3, -0.4, 0.7, -1.1, 0.2, 0.9, -0.6]
    runs["alpha_rad"] = np.array([end["alpha_rad"] + 0.004 * z for end, z in zip(ends, off)])
    runs["alpha_sd_rad"] = [0.005] * 7
    runs["v_mm_s"] = np.array([end["v_mm_s"] - 0.01 * z for end, z in zip(ends, off)])
    runs["v_sd_mm_s"] = [0.01] * 7
    return runs


def campaign_text(runs):
    text = '[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = "pi/2"\n'
    for k in range(len(runs["phi_rad"])):
        text += "[[run]]\n" + "".join(f"{name} = {float(column[k])!r}\n" for name, column in runs.items())
    return text


class Fit(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.table = table()
        cls.text = campaign_text(cls.table)
        (cls.folder / "campaign.toml").write_text(cls.text)

    def program_s_fit(self, *flags):
        done = self.run_program("fit", "campaign.toml", "-o", "fit.json", "--quiet", *flags)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder / "fit.json").read_text())

    def test_a_file_gives_fit_json(self):
        self.assertEqual(tribotrack.fit(self.folder / "campaign.toml"), self.program_s_fit())

    def test_options_are_the_flags(self):
        expected = self.program_s_fit("--loss=huber", "--bootstrap=20", "--seed=3", "--compare-models")
        found = tribotrack.fit(
            self.folder / "campaign.toml", loss="huber", bootstrap=20, seed=3, compare_models=True, threads=1
        )
        self.assertEqual(found, expected)

    def test_tables_give_the_same_parameters(self):
        import pandas

        # Of numbers, as a table is: what a file's last digits say they do not.
        expected = tribotrack.fit(tomllib.loads(self.text))["parameters"]
        self.assertEqual(tribotrack.fit(self.table, **CONDITIONS)["parameters"], expected)
        frame = pandas.DataFrame(self.table)
        self.assertEqual(tribotrack.fit(frame, **CONDITIONS)["parameters"], expected)
        by_other_names = tribotrack.fit(frame, amplitude_mm=0.28, omega_rad_s=62.8, epsilon_rad="90deg")
        self.assertEqual(by_other_names["parameters"], expected)

    def test_a_table_is_read_as_the_command_line_reads_it(self):
        import pandas

        expected = self.printed("fit", SOURCE / "data/example/alpha_v.toml", "-o", "t.json")["parameters"]
        conditions = {**CONDITIONS, "cycles": 20, "start": "rest"}
        file = SOURCE / "data/example/alpha_v.csv"
        for given in (file, str(file), pandas.read_csv(file, sep=";", decimal=",")):
            found = tribotrack.fit(given, **conditions, alpha_sd_rad="1.5deg", v_sd_mm_s=0.08).parameters
            self.assertAlmostEqual(found.mu1.estimate, 0.1, delta=0.005)
            found = tribotrack.fit(given, **conditions).parameters
            for name, parameter in expected.items():
                self.assertLess(abs(found[name].estimate - parameter["estimate"]), 0.1 * parameter["sd"], name)

    def test_results_print_briefly_and_make_tables_and_figures(self):
        import matplotlib

        matplotlib.use("Agg")
        fit = tribotrack.fit(self.table, **CONDITIONS)
        self.assertLess(len(repr(fit)), 1000)
        self.assertRegex(repr(fit), r"^Fit to 7 runs: .*\n(.*\n)*  mu1 +0\.1\d*\(\d\d\) +0\.\d+ to 0\.\d+\n")
        self.assertIn("<td>mu1</td>", fit._repr_html_())
        self.assertEqual(list(fit.to_dataframe().estimate), [p["estimate"] for p in fit["parameters"].values()])
        self.assertEqual(len(fit.plot().axes), 2)
        run = tribotrack.simulate(cycles=2, dtau_rad=1)
        self.assertEqual(run.x_mm is run["x_mm"], True)
        self.assertEqual(len(run.to_dataframe()), len(run.time_s))
        swept = tribotrack.sweep(over={"mu1": [0.1, 0.2, 0.3], "dtau_rad": [1, 2]})
        last = swept.to_dataframe().iloc[-1]
        self.assertEqual((last.mu1, last.dtau_rad, last.v_mm_s), (0.3, 2, swept.v_mm_s[2, 1]))
        with self.assertRaisesRegex(AttributeError, "`alpha_deg` in this Simulation: .*alpha_rad"):
            run.alpha_deg

    def test_a_cell_without_a_value_is_left_out(self):
        import pandas

        frame = pandas.DataFrame(self.table)
        expected = tribotrack.fit(frame, **CONDITIONS)["parameters"]
        frame["cycles"] = [20, math.nan, 20, math.nan, 20, 20, 20]
        frame["name"] = ["a", None, "c", "d", "e", "f", "g"]
        found = tribotrack.fit(frame, cycles=20, **CONDITIONS)
        self.assertEqual(found["parameters"], expected)
        self.assertEqual([run["name"] for run in found["runs"]][:3], ["a", "run02", "c"])

    def test_what_the_data_do_not_determine_is_warned_of(self):
        one = {name: column[:1] for name, column in self.table.items()}
        with self.assertWarnsRegex(tribotrack.QualityWarning, "campaign: do not use these values"):
            result = tribotrack.fit(one, **CONDITIONS)
        self.assertEqual(result["identifiability"]["verdict"], "not identifiable")

    def test_refusals_name_the_place(self):
        runs = tomllib.loads(self.text)
        broken = json.loads(json.dumps(runs))
        broken["run"][2]["dtau_rad"] = 60
        misspelt = {**runs, "platform": {"amplitud_mm": 1}}
        circle = {"run": []}
        circle["run"].append(circle)
        for campaign, conditions, said in [
            (broken, {}, "campaign, run 3: `dtau_rad` in [[run]] "),
            (misspelt, {}, "campaign: `amplitud_mm` in [platform]"),
            ({"run": []}, {}, "campaign: has no [[run]]"),
            ({"run": [{"phi_rad": {1}}]}, {}, "must be a number, a text, a list or a dict, not set"),
            ({**self.table, "v_mm_s": [1]}, CONDITIONS, "columns differ in length"),
            (self.table, {"amplitude": 3}, "`amplitude` is not a condition of a table's runs; known: amplitude_mm"),
            (self.table, {}, "amplitude_mm is neither given nor seen"),
            (runs, {"amplitude_mm": 1}, "amplitude_mm: conditions stand in the campaign"),
            (runs, {"loss": "cubes"}, 'loss: must be one of squares, huber, not "cubes"'),
            (runs, {"bootstrap": 5}, "bootstrap: must be a whole number, 20 to 1000000"),
            (3, {}, "a path, a dict or a table, not int"),
        ]:
            with self.subTest(said), self.assertRaises(tribotrack.InputError) as refused:
                tribotrack.fit(campaign, **conditions)
            self.assertIn(said, str(refused.exception))
        with self.assertRaises((RecursionError, tribotrack.InputError)):
            tribotrack.fit(circle)
        with self.assertRaises(tribotrack.MissingFileError):
            tribotrack.fit("none.toml")

    def test_recordings_are_tracked_and_tracks_taken(self):
        video = self.rendered()
        (self.folder / "tracks").mkdir(exist_ok=True)
        campaign = {
            "platform": {"phase_shift_rad": "pi/2"},
            "part": {"diameter_mm": 6},
            "camera": {"marker_px": [24, 24, 10]},
            "fit": {"parameters": ["mu1"], "fixed": {"mu2": 0.0125, "phase_lag_rad": 0}, "cycles": 2},
            "run": [{"video": str(video), "phi_rad": 0, "dtau_rad": "pi/3"}],
        }
        stages = []
        tracked = tribotrack.fit(campaign, progress=lambda stage, done, total: stages.append(stage))
        self.assertIn("track recording", stages)
        mu1 = tracked["parameters"]["mu1"]
        self.assertLess(abs(mu1["estimate"] - 0.1), 5 * mu1["sd"])
        tribotrack.track(video, disc_diameter_mm=6, marker=(24, 24, 10), output=self.folder / "tracks/recording.csv")
        taken = tribotrack.fit(campaign, tracks=self.folder / "tracks")
        self.assertEqual(taken["parameters"], tracked["parameters"])


if __name__ == "__main__":
    unittest.main()
