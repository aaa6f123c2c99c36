"""h5md.py QUERN: results.h5 is H5MD 1.1 (de Buyl et al. 2014, nongnu.org/h5md), as h5py reads it. A reader after the specification alone."""
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from python_module import TEXT

CASE = TEXT + """[output]
frames = "5 ms"
paraview = false
pictures = false
"""


def element(group):
    """An H5MD element that depends on time: step, time and value of one length."""
    assert group["step"].shape == group["time"].shape == group["value"].shape[:1]
    assert np.issubdtype(group["step"].dtype, np.integer) and (np.diff(group["step"]) > 0).all() and (np.diff(group["time"]) > 0).all()
    return group["value"]


with tempfile.TemporaryDirectory() as folder:
    case = pathlib.Path(folder, "case.toml")
    case.write_text(CASE)
    subprocess.run([sys.argv[1], "run", case, "--quiet", "--out", folder + "/out"], check=True)
    with h5py.File(folder + "/out/results.h5", "r") as file:
        root = file["h5md"]
        assert tuple(root.attrs["version"]) == (1, 1)
        assert root["author"].attrs["name"] and root["creator"].attrs["name"] and root["creator"].attrs["version"]
        for particles in file["particles"].values():
            box = particles["box"]
            assert box.attrs["dimension"] == 3 and box.attrs["boundary"].shape == (3,)
            assert set(box.attrs["boundary"]) <= {b"none", b"periodic", "none", "periodic"}
            position = element(particles["position"])
            frames, count, dimension = position.shape
            assert frames >= 5 and (count, dimension) == (40, 3), position.shape
            assert position.attrs["unit"] in ("m", b"m")
            for name in ("velocity", "angular_velocity"):
                assert element(particles[name]).shape == position.shape
            assert element(particles["id"]).shape == (frames, count)
            assert particles["position/step"] == particles["velocity/step"]  # the same object: written once
            assert np.isfinite(position[...]).all() and np.abs(position[...]).max() < 0.12
            assert particles["mass"].shape == particles["radius"].shape == (count,)
            # The places go along with the velocities.
            time = particles["position/time"][...]
            moved = (position[-1] - position[-2]) / (time[-1] - time[-2])
            speed = 0.5 * (particles["velocity/value"][-1] + particles["velocity/value"][-2])
            assert np.abs(moved - speed).mean() < 0.2 * np.abs(speed).mean() + 0.05
        assert "name" in str(file["parameters/case"][()])
        for table in file["observables"].values():
            assert len({len(column) for column in table.values() if column.shape}) <= 1
print("results.h5 is H5MD 1.1.")
