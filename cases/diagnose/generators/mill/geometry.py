"""The mill of cases/diagnose/mill_300 as files for LIGGGHTS: bars and ends as STL, balls at the start. The axis is z."""
import numpy as np

DIAMETER, LENGTH = 0.250, 0.064
BARS, BAR_HEIGHT, BAR_WIDTH, FACE_ANGLE = 8, 0.006, 0.020, np.pi / 4
BALLS, BALL, DENSITY = 300, 0.016, 7800.0
RADIUS = DIAMETER / 2


def write_stl(path, triangles):
    with open(path, "w") as file:
        file.write("solid mill\n")
        for a, b, c in triangles:
            normal = np.cross(b - a, c - a)
            normal /= np.linalg.norm(normal)
            file.write("facet normal %.9g %.9g %.9g\nouter loop\n" % tuple(normal))
            for corner in (a, b, c):
                file.write("vertex %.9g %.9g %.9g\n" % tuple(corner))
            file.write("endloop\nendfacet\n")
        file.write("endsolid mill\n")


def bars():
    """The three faces of bars of a trapezoid section that balls can reach; their corners lie beyond the shell and the ends."""
    half = BAR_WIDTH / 2
    top, end = half - BAR_HEIGHT / np.tan(FACE_ANGLE), 0.52 * LENGTH
    section = [(-half, 0), (-top, BAR_HEIGHT), (top, BAR_HEIGHT), (half, 0)]
    triangles = []
    for k in range(BARS):
        angle = 2 * np.pi * k / BARS
        out, across, along = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        low, high = ([(RADIUS - inward) * out + side * across + z * along for side, inward in section] for z in (-end, end))
        for i in range(len(section) - 1):
            triangles += [(low[i], high[i + 1], low[i + 1]), (low[i], high[i], high[i + 1])]
    return triangles


def ends():
    """A square plate at each end, larger than the shell."""
    triangles = []
    for z in (-LENGTH / 2, LENGTH / 2):
        q = [np.array([0.14 * x, 0.14 * y, z]) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        triangles += [(q[0], q[1], q[2]), (q[0], q[2], q[3])]
    return triangles


def write_start(path, seed):
    """Balls at rest on a jittered lattice, from the bottom."""
    random = np.random.default_rng(seed)
    pitch, jitter = 0.0168, 0.0003
    reach = RADIUS - BAR_HEIGHT - BALL / 2 - 2 * jitter
    lattice = np.array([(i * pitch, j * pitch) for i in range(-7, 8) for j in range(-7, 8) if np.hypot(i, j) * pitch < reach])
    places = []
    for z in (-0.0175, 0, 0.0175):
        order = np.argsort(lattice[:, 1] + random.normal(0, 0.01, len(lattice)))
        places += [(x, y, z) for x, y in lattice[order[: BALLS // 3]]]
    places = np.array(places) + random.uniform(-jitter, jitter, (len(places), 3))
    with open(path, "w") as file:
        file.write("balls\n\n%d atoms\n2 atom types\n\n-0.2 0.2 xlo xhi\n-0.2 0.2 ylo yhi\n-0.05 0.05 zlo zhi\n\nAtoms\n\n" % len(places))
        for i, place in enumerate(places):
            file.write("%d 1 %.9g %.9g %.9g %.9g %.9g\n" % (i + 1, BALL, DENSITY, *place))
