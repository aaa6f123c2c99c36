"""quern, a discrete-element simulator of grinding, from Python.

    import quern
    case = quern.Case("cases/planetary_250rpm/case.toml", {"duration": "0.2 s"})
    mill = case.simulation()
    mill.run()
    print(mill.time, mill.position[:3], mill.ledger["wall_work"])

docs/python.md tells all of it. What is wrong with a case is an InputError, a run that fails a RunError, each with the sentence that the
program says.
"""
import importlib.util
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

__all__ = ["Case", "Simulation", "Table", "InputError", "RunError", "program", "keys"]
__version__ = "0.1.0"


def _load():
    """The compiled part: beside this file where quern is installed, else in the newest build of this checkout."""
    here = pathlib.Path(__file__).resolve().parent
    found = sorted(here.glob("_quern*.so")) or sorted(here.parent.glob("build/*/python/_quern*.so"), key=lambda file: -file.stat().st_mtime)
    if not found:
        raise ImportError(f"quern is not built with its Python module: run ./run.sh or ./test.sh in {here.parent} first; it needs Debian's pybind11-dev and python3-dev.")
    spec = importlib.util.spec_from_file_location("quern._quern", found[0])
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError as problem:
        raise ImportError(f"{found[0]} was built for another Python than {sys.executable} ({problem}); /usr/bin/python3 is Debian's.") from None
    sys.modules["quern._quern"] = module
    return module, found[0]


_quern, _file = _load()
InputError, RunError = _quern.InputError, _quern.RunError
InputError.__doc__ = "The case, or what stands beside it, is wrong; nothing was run."
RunError.__doc__ = "A run failed."


def keys():
    """Everything that a case can set, a dict each: path, unit, default, allowed, meaning, source."""
    return _quern.keys()


def program():
    """Where the program `quern` stands that belongs to this module."""
    beside = _file.parent.parent / "quern"
    found = str(beside) if beside.is_file() else shutil.which("quern")
    if not found:
        raise RunError("The program quern is not there; build it with ./run.sh.")
    return found


def _run_program(*words):
    done = subprocess.run([program(), *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode == 0:
        return done.stdout
    said = done.stderr.strip() or f"quern {words[0]} ended with status {done.returncode}."
    raise (InputError if done.returncode == 2 else RunError)(said.splitlines()[-1])


def _toml(value):
    """A value as it stands in a case."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, int):
        return str(value)
    if hasattr(value, "tolist"):  # of NumPy
        return _toml(value.tolist())
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    raise TypeError(f"A key of a case takes a number, a text, True or False, or a list of those, not {type(value).__name__}.")


class Table(dict):
    """Columns by name: NumPy arrays of numbers in SI units, or lists of words; `units` by name, and a `description`."""

    def __init__(self, columns, units, description):
        super().__init__(columns)
        self.units, self.description = units, description


class Case:
    """A case: from a file, Case("mill.toml"), or from a text, Case(text="…", folder="where its files are"); `set` lays values over it."""

    def __init__(self, file=None, set=None, *, text=None, folder="."):
        if (file is None) == (text is None):
            raise TypeError("A case is made of a file or of a text, one of the two.")
        self._file, self._text, self._folder = file, text, folder
        self._set = dict(set or {})
        self._read()

    def _read(self):
        laid_over = self._overrides()
        if self._text is None:
            self._case = _quern.ReadCase.of_file(os.fspath(self._file), laid_over)
        else:
            self._case = _quern.ReadCase.of_text(self._text, os.path.join(self._folder, "text"), laid_over)

    def _overrides(self):
        return [f"{key}={_toml(value)}" for key, value in self._set.items()]

    def set(self, key, value):
        """Lays a value over the case: a number in SI units or a text with its unit. Checked at once; a wrong one leaves the case as it was."""
        before = dict(self._set)
        self._set[key] = value
        try:
            self._read()
        except Exception:
            self._set = before
            raise

    def __setitem__(self, key, value):
        self.set(key, value)

    name = property(lambda self: self._case.name)
    title = property(lambda self: self._case.title)
    duration = property(lambda self: self._case.duration, doc="[s]")
    text = property(lambda self: self._case.text, doc="The complete case, with every default, as TOML.")
    warnings = property(lambda self: self._case.warnings)

    def write(self, file):
        """Writes the complete case into a file, with copies of the files that it names beside it."""
        self._case.write(os.fspath(file))

    def simulation(self, threads=0):
        """A simulation at its start. Threads: 0 for as many as pay; results do not depend on it."""
        return Simulation(self, threads)

    def _call(self, command, out, words):
        """Runs a command of the program on this case; returns the directory of its results."""
        if self._text is None:
            laid_over = [f"--set={one}" for one in self._overrides()]
            _run_program(command, self._file, "--out", out, "--quiet", *laid_over, *words)
        else:
            with tempfile.TemporaryDirectory(prefix="quern_") as folder:
                self.write(os.path.join(folder, "case.toml"))
                _run_program(command, os.path.join(folder, "case.toml"), "--out", out, "--quiet", *words)
        return pathlib.Path(out)

    def run(self, out=None, *, threads=0, resume=False):
        """What `quern run` does: everything that docs/results.md tells, into a directory (out/<name> where none is given). Returns summary.json."""
        words = (["--threads", threads] if threads else []) + (["--resume"] if resume else [])
        return json.loads((self._call("run", out or f"out/{self.name}", words) / "summary.json").read_text())

    def diagnose(self, recordings, out=None, *, seed=1, threads=0):
        """What `quern diagnose` does: compares with recordings (CSV files). Returns diagnosis.json."""
        recordings = [recordings] if isinstance(recordings, (str, os.PathLike)) else recordings
        words = [word for file in recordings for word in ("--recording", file)] + ["--seed", seed] + (["--threads", threads] if threads else [])
        return json.loads((self._call("diagnose", out or f"out/{self.name}_diagnosis", words) / "diagnosis.json").read_text())


class Simulation:
    """A running simulation: `step`, `run_until`, `run`, and what it is like now.

    The arrays are views of the program's own memory: without a copy, read-only, one row for each particle, and up to date after every step.
    `id` tells which particle a row is; rows change their order while particles move, so copy what must last.
    """

    def __init__(self, case, threads=0):
        if not isinstance(case, Case):
            raise TypeError("A simulation is made of a quern.Case.")
        self._session = _quern.Session(case._case, threads)

    def step(self, steps=1):
        self._session.step(steps)

    def run_until(self, time):
        """To a time [s]: the step at which `quern run` with that duration ends."""
        self._session.run_until(time)

    def run(self):
        """To the duration of the case."""
        self._session.run_until(self._session.duration)

    time = property(lambda self: self._session.time, doc="[s]")
    time_step = property(lambda self: self._session.time_step, doc="[s]")
    steps = property(lambda self: self._session.steps, doc="since the start")
    position = property(lambda self: self._session.position, doc="of the centres [m], n × 3")
    velocity = property(lambda self: self._session.velocity, doc="[m/s], n × 3")
    spin = property(lambda self: self._session.spin, doc="in the fixed frame [rad/s], n × 3")
    acceleration = property(lambda self: self._session.acceleration, doc="at the last step [m/s²], n × 3")
    orientation = property(lambda self: self._session.orientation, doc="unit quaternions x, y, z, w, n × 4; no rows where spheres keep none")
    radius = property(lambda self: self._session.radius, doc="[m]; of another shape: of the ball that holds it")
    mass = property(lambda self: self._session.mass, doc="[kg]")
    moment_of_inertia = property(lambda self: self._session.moment_of_inertia, doc="[kg m²]")
    id = property(lambda self: self._session.id, doc="of each row: the order of insertion from 0")
    species = property(lambda self: self._session.species, doc="index into species_names")
    material = property(lambda self: self._session.material, doc="index into material_names")
    species_names = property(lambda self: self._session.species_names)
    material_names = property(lambda self: self._session.material_names)
    walls = property(lambda self: self._session.walls, doc="by name: force [N] and torque [N m] of the particles on it at the last step")
    ledger = property(lambda self: self._session.ledger, doc="the energy ledger of now [J]; docs/results.md")
    warnings = property(lambda self: self._session.warnings)

    def tables(self):
        """What the observers of the case saw so far, by the names of the program's CSV files: a quern.Table each."""
        return {name: Table(*table) for name, table in self._session.tables().items()}

    @property
    def spectra(self):
        """The table `spectra`: collisions per second by energy."""
        return self.tables()["spectra"]

    def headlines(self):
        """The observers' headline numbers so far, as in summary.json."""
        return self._session.headlines()
