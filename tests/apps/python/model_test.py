"""simulate() and sweep() are the program's commands, number for number."""

import csv
import inspect
import json
import re
import unittest

import numpy as np
from program import SOURCE, ProgramTest

import tribotrack


class Simulate(ProgramTest):
    CONDITIONS = [
        {},
        {"dtau_rad": "pi/3", "phi_rad": "pi/2", "mu1": 0.12, "mu2": 0.02, "cycles": 7.5},
        {"mu1_over_mu2": 5, "dtau_rad": 1.25, "lag_rad": 0.2, "amplitude_mm": 0.31, "amplitude_y_mm": 0.29},
        {"omega_rad_s": 45, "epsilon_rad": "-pi/2", "dtau_rad": "90deg", "tilt_x_rad": 0.002, "start": "steady"},
        {"velocity_x_mm_s": 10, "velocity_y_mm_s": -4, "start_phase_rad": 1, "gravity_m_s2": 9.8, "cycles": 3},
        {"mu1": 0, "cycles": 2, "samples_per_cycle": 7},
    ]

    def flags(self, conditions):
        return [f"--{name.replace('_', '-')}={value}" for name, value in conditions.items()]

    def test_results_are_those_of_the_program(self):
        for conditions in self.CONDITIONS:
            with self.subTest(conditions):
                said = self.printed("simulate", *self.flags(conditions))
                run = tribotrack.simulate(**conditions)
                self.assertEqual({name: run[name] for name in said}, said)

    def test_arrays_are_the_programs_table(self):
        for conditions in self.CONDITIONS:
            with self.subTest(conditions):
                done = self.run_program("simulate", *self.flags(conditions), "-o", "-", "--quiet")
                rows = list(csv.DictReader(done.stdout.splitlines()))
                run = tribotrack.simulate(**conditions)
                for name in rows[0]:
                    column = [row[name] if name == "state" else float(row[name]) for row in rows]
                    np.testing.assert_array_equal(run[name], column, name)

    def test_a_scenario_file_is_overridden_by_keywords(self):
        file = SOURCE / "data/figure7a.toml"
        said = self.printed("simulate", file, "--phi-rad=1")
        run = tribotrack.simulate(file, phi_rad=1)
        self.assertEqual({name: run[name] for name in said}, said)
        self.assertEqual(tribotrack.simulate(scenario=str(file), phi_rad=1)["alpha_rad"], run["alpha_rad"])

    def test_defaults_are_those_of_its_documentation(self):
        told = {"mu1": 0.1, "mu2": 0.0125, "amplitude_mm": 0.28, "omega_rad_s": 62.8, "gravity_m_s2": 9.81}
        for name, value in told.items():
            self.assertIn(f"{name} = {value}", tribotrack.simulate.__doc__)
        whole = tribotrack.simulate(epsilon_rad="pi/2", dtau_rad=0, cycles=20, start="rest", samples_per_cycle=100, **told)
        default = tribotrack.simulate()
        np.testing.assert_allclose(default["x_mm"], whole["x_mm"], rtol=0, atol=1e-10)  # 0.28 mm and 0.28e-3 m differ in a bit
        pulsed = tribotrack.simulate(dtau_rad=1)
        np.testing.assert_array_equal(pulsed["x_mm"], tribotrack.simulate(dtau_rad=1, mu2=0.0125)["x_mm"])

    def test_messages_are_the_programs_with_keywords_for_flags(self):
        for conditions, said in [
            ({"mu1": -1}, "mu1"),
            ({"mu2": 0.1, "mu1_over_mu2": 8}, "mu2 and mu1_over_mu2 mean the same; give one of them"),
            ({"phi_rad": 300}, "phi_rad"),
            ({"start": "walking"}, "rest, circling, steady"),
            ({"samples_per_cycle": 0}, "samples_per_cycle must be between 1 and 1000000"),
            ({"phi_rad": "a third"}, "phi_rad: must be an angle"),
            ({"mu1": "much"}, 'mu1: must be a finite number, not "much"'),
            ({"cycles": 1e9}, "lower cycles or samples_per_cycle"),
        ]:
            with self.subTest(conditions), self.assertRaises(tribotrack.InputError) as refused:
                tribotrack.simulate(**conditions)
            self.assertIn(said, str(refused.exception))
            self.assertNotIn("--", str(refused.exception))
        with self.assertRaises(tribotrack.MissingFileError) as missing:
            tribotrack.simulate("no such.toml")
        self.assertIsInstance(missing.exception, FileNotFoundError)
        self.assertIsInstance(missing.exception, ValueError)
        self.assertIn("no such.toml: there is no such file", str(missing.exception))


class Sweep(ProgramTest):
    def test_a_grid_is_the_programs_table(self):
        over = {"phi_rad": np.linspace(0, 6, 5), "dtau_rad": np.array([0, 0.5, 1.0, 2.5])}
        given = [f"--over={name}={','.join(repr(float(v)) for v in values)}" for name, values in over.items()]
        done = self.run_program("sweep", SOURCE / "data/figure7a.toml", *given, "-o", "s.csv", "--json", "--quiet")
        said = json.loads(done.stdout)
        swept = tribotrack.sweep(SOURCE / "data/figure7a.toml", over=over)
        for name in ("alpha_rad", "v_mm_s", "steady_alpha_rad", "steady_v_mm_s"):
            self.assertEqual(swept[name].shape, (5, 4))
            np.testing.assert_array_equal(swept[name].ravel(), np.array(said[name], float), name)
        for name, values in over.items():
            np.testing.assert_array_equal(swept[name], values)

    def test_refusals_name_the_remedy(self):
        for over, said in [
            ({}, "one or two"),
            ({"phi_rad": []}, "must read NAME=FROM:TO:COUNT"),
            ({"ph_rad": [1]}, 'did you mean "phi_rad"?'),
            ({"mu1": [0.1], "mu2": [0.1], "phi_rad": [1]}, "one or two"),
            ({"mu2": [0.1], "mu1_over_mu2": [8]}, "mean the same"),
            ({"mu1": [0.1, -1]}, "mu1"),
            ({"phi_rad": [0, 360]}, "phi_rad"),
            (None, "one or two"),
        ]:
            with self.subTest(over), self.assertRaises(tribotrack.InputError) as refused:
                tribotrack.sweep(over=over)
            self.assertIn(said, str(refused.exception))


class Keywords(ProgramTest):
    """Every flag of a command is a keyword here, and no other."""

    FOR_THE_SHELL = {"help", "quiet", "threads", "version", "json", "explain", "output"}
    # What only pictures on disk show, and what stands in place of a flag.
    NOT_HERE = {
        "track": {"debug", "first_frame", "campaign", "run", "tracks"},  # jobs of a workflow
        "fit": {"require_all", "measurements"},
    }
    ONLY_HERE = {
        "simulate": {"scenario"},
        "sweep": {"scenario", "conditions"},
        "track": {"source", "bits"},
        "measure": {"track"},
        "fit": {"campaign", "conditions"},
    }

    def test_keywords_are_the_flags(self):
        for command, own in self.ONLY_HERE.items():
            with self.subTest(command):
                told = self.run_program(command, "--help").stdout
                flags = {name.replace("-", "_") for name in re.findall(r"--([a-z][a-z0-9-]*)", told)}
                flags -= {"angular_frequency_rad_s", "frequency_hz", "phase_shift_rad", "phase_lag_rad"}  # other names
                if command == "sweep":
                    flags &= {"over", "start"}  # its conditions are quantities by name
                keywords = set(inspect.signature(getattr(tribotrack, command)).parameters)
                self.assertEqual(
                    flags - self.FOR_THE_SHELL - self.NOT_HERE.get(command, set()),
                    keywords - own - {"threads", "progress", "output"},
                )

    def test_the_version_is_the_programs(self):
        self.assertEqual(self.run_program("--version").stdout.split()[:2], ["tribotrack", tribotrack.__version__])


class CampaignSchema(ProgramTest):
    """`help campaign --json`."""

    def test_shipped_campaigns_follow_it_and_slips_do_not(self):
        try:
            import tomllib

            from jsonschema import Draft202012Validator
        except ImportError:
            self.skipTest("python3-jsonschema is not installed")
        schema = json.loads(self.run_program("help", "campaign", "--json").stdout)
        Draft202012Validator.check_schema(schema)
        validator = Draft202012Validator(schema)
        for name in ("campaign", "alpha_v"):
            validator.validate(tomllib.loads((SOURCE / f"data/example/{name}.toml").read_text()))
        for slip in (
            {"platform": {"amplitude": 0.28}},
            {"camera": {"mm_per_px": 0}},
            {"fit": {"start": "moving"}},
            {"platform": {"tilt_x_rad_sd": 0.1}},
        ):
            self.assertFalse(validator.is_valid(slip), slip)


if __name__ == "__main__":
    unittest.main()
