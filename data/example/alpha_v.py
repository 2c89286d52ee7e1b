#!/usr/bin/env python3
"""Makes alpha_v.csv from the model: mu1 = 0.1, mu2 = 0.0125, lag = 0.2 rad, 20 cycles from rest, each of 10 points measured
three times, with errors of 1.5 deg in alpha and 2 % in v that the table does not state.
  data/example/alpha_v.py build/release/apps/tribotrack > data/example/alpha_v.csv
"""
import json
import random
import subprocess
import sys

random.seed(1)
points = [(phi, 60) for phi in range(0, 360, 60)] + [(0, dtau) for dtau in (30, 90, 120, 150)]
lines = []
for phi, dtau in points:
    said = subprocess.run([sys.argv[1], "simulate", "--mu1", "0.1", "--mu2", "0.0125", "--lag-rad", "0.2", "--amplitude-mm",
                           "0.28", "--omega-rad-s", "62.8", "--phi-rad", f"{phi}deg", "--dtau-rad", f"{dtau}deg", "--cycles",
                           "20", "--json"], capture_output=True, check=True, text=True).stdout
    run = json.loads(said)
    for _ in range(3):
        alpha = (run["alpha_rad"] * 180 / 3.141592653589793 + random.gauss(0, 1.5)) % 360
        v = run["v_mm_s"] * (1 + random.gauss(0, 0.02))
        lines.append(f"{phi};{dtau};{alpha:.1f};{v:.2f}".replace(".", ","))
print("phi (deg);dtau (deg);alpha (deg);v (mm/s)")
print("\n".join(lines))
