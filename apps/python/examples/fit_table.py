#!/usr/bin/python3
"""mu1, mu2 and the phase lag from a table of displacements, measured with noise of a known size.

The table is a pandas DataFrame where pandas is there, else a dict of lists.
Use: python3 fit_table.py
"""

import random

import tribotrack

try:
    import pandas
except ImportError:
    pandas = None

TRUTH = {"mu1": 0.1, "mu2": 0.0125, "phase_lag_rad": 0.2}
ALPHA_SD_RAD, V_SD_MM_S = 0.01, 0.03

noise = random.Random(7)
runs = []
for phi, dtau in [("0", "pi/3"), ("pi/2", "pi/3"), ("pi", "pi/3"), ("3pi/2", "pi/3"), ("0", "pi/6"), ("0", "pi/2"), ("0", "pi")]:
    motion = tribotrack.simulate(
        mu1=TRUTH["mu1"], mu2=TRUTH["mu2"], lag_rad=TRUTH["phase_lag_rad"], phi_rad=phi, dtau_rad=dtau, cycles=20
    )
    runs.append(
        {
            "phi_rad": phi,
            "dtau_rad": dtau,
            "alpha_rad": motion["alpha_rad"] + noise.gauss(0, ALPHA_SD_RAD),
            "alpha_sd_rad": ALPHA_SD_RAD,
            "v_mm_s": motion["v_mm_s"] + noise.gauss(0, V_SD_MM_S),
            "v_sd_mm_s": V_SD_MM_S,
        }
    )
table = pandas.DataFrame(runs) if pandas else {name: [run[name] for run in runs] for name in runs[0]}

result = tribotrack.fit(table, amplitude_mm=0.28, angular_frequency_rad_s=62.8, phase_shift_rad="pi/2", cycles=20)

print(f"{'':15}{'truth':>10}{'estimate':>12}{'sd':>10}")
for name, found in result["parameters"].items():
    print(f"{name:15}{TRUTH[name]:10.4f}{found['estimate']:12.5f}{found['sd']:10.5f}")
print(f"chi2 {result['chi2']:.1f} at {result['dof']} degrees of freedom; {result['identifiability']['verdict']}")
