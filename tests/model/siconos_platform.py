"""A part on the circling platform by Siconos (Moreau-Jean time stepping, theta = 1/2, set-valued friction):
prints the displacement after whole cycles with N, 2N and 4N steps per cycle, one line each.

    siconos_platform.py A w g mu1 mu2 phi dtau cycles N      (SI, rad)

Exits with 77 and says why where Siconos cannot be imported.
"""
import math
import sys

try:
    import siconos.kernel as kernel
    import siconos.numerics as numerics
except ImportError as missing:
    print(f"Siconos is not here: {missing}")
    sys.exit(77)


def displacement(amplitude, w, gravity, mu1, mu2, phi, dtau, cycles, steps):
    step = 2 * math.pi / w / steps
    # The contact's frame: the normal first, then the plane.
    part = kernel.LagrangianLinearTIDS([0.0] * 3, [0.0] * 3, [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    force = kernel.SiconosVector([-gravity, 0.0, 0.0])
    part.setFExtPtr(force)
    friction = kernel.NewtonImpactFrictionNSL(0.0, 0.0, mu1, 3)
    identity = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    contact = kernel.Interaction(friction, kernel.LagrangianLinearTIR(identity))
    model = kernel.NonSmoothDynamicalSystem(0.0, (cycles + 1) * steps * step)
    model.insertDynamicalSystem(part)
    model.link(contact, part)
    simulation = kernel.TimeStepping(model, kernel.TimeDiscretisation(0.0, step))
    simulation.insertIntegrator(kernel.MoreauJeanOSI(0.5))
    simulation.insertNonSmoothProblem(kernel.FrictionContact(3, numerics.SICONOS_FRICTION_3D_ONECONTACT_NSN))
    drive = amplitude * w * w
    turn = 2 * math.pi / steps
    for k in range(cycles * steps):
        # The drive's mean over the step; friction as in its middle: pulses begin and end between steps.
        before, after = turn * k, turn * (k + 1)
        force.setValue(1, drive * (math.sin(after) - math.sin(before)) / turn)
        force.setValue(2, drive * (math.cos(after) - math.cos(before)) / turn)
        friction.setMu(mu2 if (before + turn / 2 - phi) % (2 * math.pi) < dtau else mu1)
        simulation.computeOneStep()
        simulation.nextStep()
    return part.q()[1], part.q()[2]


if __name__ == "__main__":
    *physics, cycles, steps = sys.argv[1:]
    for refined in (1, 2, 4):
        x, y = displacement(*map(float, physics), int(cycles), refined * int(steps))
        print(f"{x:.17g} {y:.17g}")
