"""track() of frames in memory is track() of the file that holds them, and measure() follows either."""

import json
import resource
import subprocess
import sys
import unittest
import warnings

import numpy as np
from program import ProgramTest, frames_of

import tribotrack

OPTIONS = {"fps": 250, "disc_diameter_mm": 6, "marker": (24, 24, 10)}


class Track(ProgramTest):
    def setUp(self):
        self.video = self.rendered()
        self.frames = frames_of(self.video)

    def assert_same(self, one, other):
        self.assertEqual(one.keys() - {"meta"}, other.keys() - {"meta"})
        for name in one.keys() - {"meta"}:
            np.testing.assert_array_equal(one[name], other[name], name)

    def test_a_file_gives_the_programs_table(self):
        done = self.run_program(
            "track", self.video, "--fps=250", "--disc-diameter-mm=6", "--marker=24,24,10", "-o", "t.csv", "--quiet"
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        table = np.genfromtxt(self.folder / "t.csv", delimiter=",", names=True, dtype=None, encoding=None)
        track = tribotrack.track(self.video, **OPTIONS)
        self.assertEqual(list(track)[:-1], list(table.dtype.names))
        for name in table.dtype.names:
            np.testing.assert_array_equal(track[name], table[name], name)
        self.assertEqual(track["meta"], json.loads((self.folder / "t.csv.meta.json").read_text()))
        self.assertEqual(track["frame"].dtype, np.int64)
        self.assertGreater((track["status"] == "ok").sum(), 55)

    def test_frames_in_memory_give_the_files_positions_bit_for_bit(self):
        from_file = tribotrack.track(self.video, **OPTIONS)
        self.assert_same(tribotrack.track(self.frames, **OPTIONS), from_file)
        self.assertEqual(tribotrack.track(self.frames, **OPTIONS)["meta"]["recording"]["format"], "memory")

    def test_any_layout_is_read_where_it_lies(self):
        expected = tribotrack.track(self.frames, **OPTIONS)
        read_only = self.frames.copy()
        read_only.flags.writeable = False
        wide = np.zeros((2 * len(self.frames), 300, 500), np.uint8)
        window = wide[::2, 100:240, 200:360]
        window[:] = self.frames
        fortran = np.asfortranarray(self.frames)
        upside_down = self.frames[:, ::-1].copy()[:, ::-1]
        for stack in (read_only, window, fortran, upside_down, memoryview(self.frames)):
            self.assert_same(tribotrack.track(stack, **OPTIONS), expected)

    def test_nothing_is_copied(self):
        # Twenty thousand frames of four megapixels, 80 GB, all of them the same memory.
        picture = np.zeros((2000, 2000), np.uint8)
        picture[: self.frames.shape[1], : self.frames.shape[2]] = self.frames[0]
        endless = np.lib.stride_tricks.as_strided(picture, (20000, 2000, 2000), (0, 2000, 1))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        track = tribotrack.track(endless, fps=250, disc=(80, 70, 20), marker="none", frames=(0, 4), layers="off")
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
        self.assertEqual(len(track["frame"]), 5)
        self.assertLess(grown, 500e6)

    def test_other_arrays_are_refused_with_the_reason(self):
        for stack, said in [
            (self.frames.astype(float), 'uint8 or uint16 grey levels of the shape (frames, height, width), not of the type "d"'),
            (self.frames.astype(">u2"), 'not of the type ">H"'),
            (self.frames > 5, 'not of the type "?"'),
            (self.frames[0], "not of 2 dimensions"),
            (np.stack([self.frames] * 3, axis=-1), "make grey of colour first"),
            (self.frames[:0], "not (0, 140, 160)"),
            (12, "a path or an array of frames, not int"),
            ([[1, 2]], "a path or an array of frames, not list"),
        ]:
            with self.subTest(said), self.assertRaises(tribotrack.InputError) as refused:
                tribotrack.track(stack, fps=250)
            self.assertIn(said, str(refused.exception))

    def test_options_are_refused_as_the_program_refuses_them(self):
        for options, said in [
            ({}, "frames in memory have no frame rate: give fps"),
            ({"fps": -1}, "fps must be greater than 0, not -1"),
            ({"fps": 250, "mm_per_px": 0.1, "chamfer_mm": 0.1}, "chamfer_mm needs disc_diameter_mm"),
            ({"fps": 250, "disc": (1, 2)}, "disc must read X,Y,R in pixels"),
            ({"fps": 250, "disc": (1, 2, 0)}, "disc must have a radius greater than 0"),
            ({"fps": 250, "marker": "round"}, "marker must read X,Y,R in pixels, such as 640,400,150, or be auto"),
            ({"fps": 250, "frames": (5, 2)}, "the first frame comes after the last"),
            ({"fps": 250, "frames": (3,)}, "frames must read A:B"),
            ({"fps": 250, "bits": 9}, "bits must be 1 to 8"),
            ({"fps": 250, "layers": "perhaps"}, "layers must be auto, on or off"),
            ({"fps": 250, "template": (1.5, 2, 3, 4)}, "template must be whole pixels"),
            ({"fps": 250, "output": "/no/such/folder/t.csv"}, "/no/such/folder"),
        ]:
            with self.subTest(options), self.assertRaises(tribotrack.InputError) as refused:
                tribotrack.track(self.frames, **options)
            self.assertIn(said, str(refused.exception))
        with self.assertRaises(tribotrack.MissingFileError):
            tribotrack.track(self.folder / "none.cine", fps=250)

    def test_several_discs_are_handed_out_to_choose_from(self):
        two = np.concatenate([self.frames[:, 44:, :], self.frames[:, 44:, :]], axis=2)
        with self.assertRaises(tribotrack.AmbiguousPartError) as question:
            tribotrack.track(two, fps=250, marker="none")
        discs = question.exception.discs_px
        self.assertEqual(len(discs), 2)
        self.assertAlmostEqual(discs[1][0] - discs[0][0], 160, delta=1.0)
        left = min(discs)
        track = tribotrack.track(two, fps=250, marker="none", disc=left)
        self.assertAlmostEqual(track["x_px"][0], left[0], delta=0.5)

    def test_files_are_written_where_asked_for(self):
        tribotrack.track(self.frames, output=self.folder / "o.csv", overlay=self.folder / "o.png", **OPTIONS)
        track = tribotrack.track(self.frames, **OPTIONS)
        self.assertEqual(json.loads((self.folder / "o.csv.meta.json").read_text()), track["meta"])
        self.assertTrue((self.folder / "o.png").exists())
        self.assertEqual(
            tribotrack.measure(self.folder / "o.csv"), tribotrack.measure(track)
        )


class Measure(ProgramTest):
    def setUp(self):
        self.video = self.rendered()
        self.track = tribotrack.track(self.video, output=self.folder / "t.csv", **OPTIONS)

    def test_a_file_gives_what_the_program_prints(self):
        for options in ({}, {"cycles": 1}, {"omega_rad_s": 62.8, "epsilon_rad": "pi/2"}):
            flags = [f"--{name.replace('_', '-')}={value}" for name, value in options.items()]
            said = self.printed("measure", "t.csv", *flags)
            self.assertEqual(tribotrack.measure(self.folder / "t.csv", **options), said)

    def test_a_track_in_memory_gives_the_same(self):
        expected = tribotrack.measure(self.folder / "t.csv")
        self.assertEqual(tribotrack.measure(self.track), expected)
        self.assertIn("amplitude_mm_sd", expected)

    def test_refusals_name_the_remedy(self):
        for track, options, said in [
            ({"frame": [1]}, {}, "has no column `time_s`"),
            ({**self.track, "x_mm": self.track["x_mm"][1:]}, {}, "x_mm has 59 rows, frame has 60"),
            ({**self.track, "x_mm": ["a"] * 60}, {}, "x_mm must be a row of numbers"),
            (5, {}, "a path or a dict of columns, not int"),
            (self.track, {"omega_rad_s": -2}, "omega_rad_s must be greater than 0"),
            (self.track, {"free_slide": True, "omega_rad_s": 2}, "free_slide and omega_rad_s contradict"),
            ({**self.track, "meta": None}, {}, "have no scale"),
        ]:
            with self.subTest(said), self.assertRaises(tribotrack.InputError) as refused:
                tribotrack.measure(track, **options)
            self.assertIn(said, str(refused.exception))
        with self.assertRaises(tribotrack.MissingFileError):
            tribotrack.measure("none.csv")


class Import(unittest.TestCase):
    def test_it_loads_neither_numpy_nor_what_reads_pictures(self):
        loaded = subprocess.run(
            [sys.executable, "-c", "import sys, tribotrack; print('numpy' in sys.modules, open('/proc/self/maps').read())"],
            capture_output=True, text=True, check=True,
        ).stdout
        self.assertTrue(loaded.startswith("False"))
        for library in ("libopencv_imgcodecs", "libpython"):
            self.assertNotIn(library, loaded)


if __name__ == "__main__":
    warnings.simplefilter("always")
    unittest.main()
