"""What the tests of the Python module share: the built program, a recording of known content, and its frames."""

import json
import os
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

BINARY = os.environ["TRIBOTRACK_BINARY"]
SOURCE = Path(os.environ["TRIBOTRACK_SOURCE_DIR"])

# A disc of 20 px radius that drifts on a circling, textured platform with a mark, two and a half turns.
SCENE = """
seed = 5
[platform]
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
phase_shift_rad = "pi/2"
[friction]
mu1 = 0.1
mu1_over_mu2 = 8
phi_rad = 0
dtau_rad = "pi/3"
[run]
cycles = 2.4
[video]
width = 160
height = 140
frame_rate_hz = 250
frames = 60
[camera]
mm_per_px = 0.15
[disc]
diameter_mm = 6.0
[surface]
texture_rms = 6
[marker]
position_px = [24, 24]
radius_px = 10
"""


class ProgramTest(unittest.TestCase):
    """A folder of its own for each test class."""

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory(prefix="tribotrack-test-")
        cls.folder = Path(cls._folder.name)

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    def run_program(self, *arguments):
        return subprocess.run(
            [BINARY, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, check=False
        )

    def printed(self, *arguments):
        """The JSON object that a command prints."""
        done = self.run_program(*arguments, "--json", "--quiet")
        self.assertIn(done.returncode, (0, 4, 5), done.stderr)
        return json.loads(done.stdout)

    def rendered(self, name="recording.cine", scene=SCENE):
        """A recording of the scene, made once."""
        video = self.folder / name
        if not video.exists():
            (self.folder / "scene.toml").write_text(scene)
            done = self.run_program("synth", "scene.toml", "-o", name, "--quiet")
            self.assertEqual(done.returncode, 0, done.stderr)
        return video


def frames_of(cine):
    """The frames of an uncompressed .cine of 8 bits, read by the format's description."""
    data = Path(cine).read_bytes()
    count, header, _, offsets = struct.unpack_from("<4I", data, 20)
    width, height, _, bits = struct.unpack_from("<iiHH", data, header + 4)
    assert bits == 8
    frames = np.empty((count, abs(height), width), np.uint8)
    for k in range(count):
        (at,) = struct.unpack_from("<q", data, offsets + 8 * k)
        (annotation,) = struct.unpack_from("<I", data, at)
        picture = np.frombuffer(data, np.uint8, width * abs(height), at + annotation).reshape(abs(height), width)
        frames[k] = picture[::-1] if height > 0 else picture
    return frames
