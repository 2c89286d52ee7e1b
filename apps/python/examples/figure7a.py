#!/usr/bin/python3
"""The source paper's figure 7a: the direction alpha of the part's displacement against the phase phi of the pulse.

Use: python3 figure7a.py [figure7a.png]
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import tribotrack

phi = np.linspace(0, 2 * np.pi, 73)
swept = tribotrack.sweep(
    over={"phi_rad": phi},
    mu1=0.1,
    mu1_over_mu2=8,
    dtau_rad="pi/3",
    amplitude_mm=0.28,
    omega_rad_s=62.8,
    cycles=20,
)

figure, axes = plt.subplots(figsize=(5, 4), layout="constrained")
axes.plot(phi, swept["alpha_rad"], ".", label="20 cycles from rest")
# The steady motion's alpha falls with slope -1; it is unwrapped to be drawn as one line, and wrapped again.
steady = np.unwrap(swept["steady_alpha_rad"])
for turn in (0, 2 * np.pi):
    axes.plot(phi, steady + turn, "k-", lw=0.8, label="steady motion" if turn == 0 else None)
axes.set(xlim=(0, 2 * np.pi), ylim=(0, 2 * np.pi), xlabel="phi, rad", ylabel="alpha, rad")
axes.legend()
output = sys.argv[1] if len(sys.argv) > 1 else "figure7a.png"
figure.savefig(output, dpi=150)

slope = np.polyfit(phi, steady, 1)[0]
print(f"steady motion: slope {slope:.4f} rad per rad")
off = np.angle(np.exp(1j * (swept["alpha_rad"] - swept["steady_alpha_rad"])))
print(f"from rest: at most {np.degrees(np.abs(off).max()):.1f} deg off that line")
print(output)
