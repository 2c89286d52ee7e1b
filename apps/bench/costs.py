#!/usr/bin/python3
"""What commands cost against the size of their input: seconds, CPU seconds, memory. Prints the manual's page.
Use: apps/bench/costs.py build/release/apps/tribotrack > apps/manual/costs.md      (some 3 minutes, on a machine that does nothing else)"""
import csv, math, os, pathlib, random, subprocess, sys, tempfile, time

BINARY = os.path.abspath(sys.argv[1])
SCENE = (pathlib.Path(__file__).parents[2] / 'data/example/scene.toml').read_text().split('[[shot]]')[0]
CAMPAIGN = """[platform]
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
phase_shift_rad = "pi/2"
{sections}
[fit]
parameters = ["mu1", "mu2", "phase_lag_rad"]
start = "rest"
{fit}
"""
TRACKED = CAMPAIGN.replace('{sections}', """[part]
diameter_mm = 6.0
chamfer_mm = 0
[camera]
marker_px = [40, 40, 14]""")


def tribotrack(*arguments):
    """Wall seconds, CPU seconds and MB of a command."""
    begun = time.monotonic()
    child = subprocess.Popen([BINARY, *map(str, arguments), '-q'], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f'failed: {arguments}')
    return time.monotonic() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def film(output, frames, shots=''):
    scene = output.parent / 'scene.toml'
    scene.write_text(SCENE.replace('[video]', f'[video]\nframes = {frames}') + shots)
    tribotrack('synth', scene, '-o', output)


def of_frames(kind):
    def cost(folder, count):
        film(folder / f'recording.{kind}', count)
        return tribotrack('track', folder / f'recording.{kind}', '--fps', 250, '--fps-reason', 'scene', '--disc-diameter-mm', 6,
                          '--marker', '40,40,14', '-o', folder / 'track.csv')
    return cost


def campaign_of(folder, recordings, fit):
    """Recordings of 10 cycles over phi, as a campaign."""
    runs = [f'phi_rad = {2 * math.pi * k / recordings}\ndtau_rad = "pi/3"\n' for k in range(recordings)]
    film(folder / 'recordings', 251, ''.join(f'[[shot]]\nname = "r{k}"\nseed = {k + 1}\n{run}' for k, run in enumerate(runs)))
    path = folder / 'campaign.toml'
    path.write_text(TRACKED.format(fit=fit + 'cycles = 10') +
                    ''.join(f'[[run]]\nvideo = "recordings/r{k}.cine"\n{run}' for k, run in enumerate(runs)))
    return path


def of_recordings(folder, count):
    return tribotrack('run', campaign_of(folder, count, ''), '-o', folder / 'out')


def of_points(folder, count):
    campaign = campaign_of(folder, count // 502, 'data = "trajectory"\n')  # x and y of 251 frames
    tribotrack('run', campaign, '-o', folder / 'out')
    return tribotrack('fit', campaign, '--tracks', folder / 'out/tracks', '-o', folder / 'fit.json')


def of_runs(folder, count):
    """alpha and v of the model, with errors of 0.01 rad and 1 %."""
    tribotrack('sweep', '--over', f'phi_rad=0:6.2:{count // 5}', '--over', 'dtau_rad=0.5,1,1.5,2,3', '--lag-rad', 0.2,
               '-o', folder / 'sweep.csv')
    chance = random.Random(1)
    with open(folder / 'sweep.csv') as swept, open(folder / 'table.csv', 'w') as table:
        print('phi_rad,dtau_rad,alpha_rad,alpha_sd_rad,v_mm_s,v_sd_mm_s', file=table)
        for row in csv.DictReader(swept):
            alpha, v = float(row['alpha_rad']) + chance.gauss(0, 0.01), float(row['v_mm_s']) * chance.gauss(1, 0.01)
            print(row['phi_rad'], row['dtau_rad'], alpha, 0.01, v, 0.01 * v, sep=',', file=table)
    campaign = folder / 'table.toml'
    campaign.write_text(CAMPAIGN.format(sections='[data]\ntable = "table.csv"', fit='cycles = 20'))
    return tribotrack('fit', campaign, '-o', folder / 'fit.json')


WHAT = [('`track`, frames of 320 x 320 px', of_frames('cine'), (250, 1000, 4000)),
        ('`track`, the same as H.264', of_frames('mp4'), (250, 1000, 4000)),
        ('`run`, recordings of 251 frames', of_recordings, (4, 16, 64)),
        ('`fit`, runs of a table', of_runs, (15, 60, 240)),
        ('`fit` with `data = "trajectory"`, coordinates', of_points, (4 * 502, 8 * 502, 16 * 502))]

print(f"""# Costs

What commands take on {len(os.sched_getaffinity(0))} cores: seconds, seconds of CPU on all of them, memory of the largest process. The exponents say how
these grow with the size of the input, from the second size to the third: 1 is linear. `apps/bench/costs.py` makes this page.

| command, and what is counted | count | seconds | CPU seconds | MB | exponents |
|---|---|---|---|---|---|""")
for name, cost, counts in WHAT:
    before = None
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            now = cost(pathlib.Path(folder), count)
        exponents = ''
        if count == counts[-1]:
            exponents = ', '.join(f'{math.log(a / b) / math.log(count / counts[-2]):.2f}' for a, b in zip(now, before))
        before = now
        print(f'| {name} | {count} | {now[0]:.2f} | {now[1]:.2f} | {now[2]:.0f} | {exponents} |', flush=True)
print("""
Of videos and pictures the window about the part is kept in a temporary file while they are tracked (in `TMPDIR`, else `/var/tmp`, 4 GB
at most), so that each frame is decoded once; `.cine` and `.mraw` are read where they lie, and count as memory up to some 0.4 GB, however large they are.""")
