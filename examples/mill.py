# A mill in Python: build, step, look inside, vary, and compare with the program. Cells as editors and Jupyter know them (`# %%`).
# Run it with: python3 examples/mill.py

# %% The module, from this checkout where quern is not installed
import csv
import json
import pathlib
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(root))
import numpy as np
import quern

# %% A case: the README's first one, smaller and shorter
case = quern.Case(text="""
name = "python_mill"
duration = "0.25 s"

[material.steel]
density = 7800
young = "10 MPa"
poisson = 0.3

[pair.steel.steel]
restitution = 0.6
friction = 0.5

[species.ball]
material = "steel"
diameter = "25 mm"

[mill]
type = "tumbling"
diameter = "0.3 m"
length = "0.1 m"
speed_fraction = 0.7
lifters = {count = 8, height = "15 mm", width = "15 mm"}

[insert.charge]
species = "ball"
filling = 0.3

[output]
frames = "0.05 s"
pictures = false
paraview = false
""")
case["pair.steel.steel.friction"] = 0.4  # a key of docs/case-reference.md; a wrong one is refused with the nearest right one

# %% Step it. The arrays are views of the program's memory: nothing is copied, and they show the present
mill = case.simulation()
position, velocity = mill.position, mill.velocity
print(f"{len(position)} balls, time step {mill.time_step:.3g} s")
while mill.time < case.duration:
    mill.run_until(mill.time + 0.05)
    speed = np.linalg.norm(velocity, axis=1)
    print(f"t = {mill.time:.2f} s   mean height {np.average(position[:, 2], weights=mill.mass):+.4f} m   fastest {speed.max():.2f} m/s")
mill = case.simulation()
mill.run()

# %% What it did: the energy ledger and the collision spectrum
ledger = mill.ledger
print(f"work of the shell {ledger['wall_work']:.3f} J, lost by friction {ledger['sliding_loss']:.3f} J, missing {ledger['gap']:.2e} J")
spectra = mill.spectra
dissipated = [k for k, measure in enumerate(spectra["measure"]) if measure == "dissipated"]
print(f"{spectra['rate'][dissipated].sum():.0f} contacts per second")

# %% The same case by the program, which writes everything; it agrees to the bit
with tempfile.TemporaryDirectory() as folder:
    summary = case.run(folder)
    rows = list(csv.DictReader(open(f"{folder}/spectra.csv")))
    last = list(csv.DictReader(open(f"{folder}/energy.csv")))[-1]
    for name, unit in spectra.units.items():
        header = name if name in rows[0] else f"{name} [{unit}]"
        for mine, theirs in zip(spectra[name], (row[header] for row in rows), strict=True):
            assert (mine == float(theirs) if theirs else not np.isfinite(mine)) if not isinstance(mine, str) else mine == theirs, name
    for name, mine in ledger.items():
        assert mine == float(last[f"{name} [J]"]), name
    try:
        import h5py
    except ImportError:
        print("h5py is not there: places were not compared")
    else:
        with h5py.File(f"{folder}/results.h5") as results:
            balls = results["particles/balls"]
            order = np.argsort(mill.id)
            for name, mine in (("position", mill.position), ("velocity", mill.velocity), ("angular_velocity", mill.spin)):
                assert np.array_equal(balls[f"{name}/value"][-1], mine[order]), name
print(f"The program has the same bits; its ledger closes to {summary['energy_closure']['value']:.1e}.")

# %% Vary something
for fraction in (0.6, 0.8):
    case["mill.speed_fraction"] = fraction
    mill = case.simulation()
    mill.run()
    print(f"at {fraction:.0%} of critical: work {mill.ledger['wall_work']:.3f} J")
