# The bed of bench/drum.cpp in YADE: yade -n -x -jN bed.py START WARM STEPS SAMPLE MEANS
# Hertz–Mindlin with Tsuji damping from the restitution; no tangential damping. sample > 0: readings instead of a timing.
import os, sys, time, math
from yade import pack, utils

start, warm, steps, sample, means = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
atoms, speeds, box, part = {}, {}, {}, None
for line in open(start):
    words = line.split()
    if not words:
        continue
    if words[0] in ("Atoms", "Velocities"):
        part = words[0]
    elif len(words) == 4 and words[2].endswith("lo"):
        box[words[2][0]] = (float(words[0]), float(words[1]))
    elif part == "Atoms":
        atoms[int(words[0])] = [float(w) for w in words[2:]]
    elif part == "Velocities":
        speeds[int(words[0])] = [float(w) for w in words[1:]]

material = O.materials.append(FrictMat(density=7800, young=1e8, poisson=0.3, frictionAngle=math.atan(0.5)))
# The space is periodic in all three directions; upwards it is so tall that the bed does not meet itself.
height = box["z"][1] - box["z"][0] + 0.2
O.periodic = True
O.cell.setBox(Vector3(box["x"][1] - box["x"][0], box["y"][1] - box["y"][0], height))
lift = 0.05
# Tiles: what is wider than half the period does not touch everything, and an endless wall makes the collider eat all memory.
tiles = 10
half = Vector3(O.cell.size[0] / tiles / 2, O.cell.size[1] / tiles / 2, 0.01)
for column in range(tiles):
    for row in range(tiles):
        O.bodies.append(utils.box(((2 * column + 1) * half[0], (2 * row + 1) * half[1], lift - half[2]), half, fixed=True, material=material))
balls = []
for name, (diameter, density, x, y, z) in atoms.items():
    ball = utils.sphere((x, y, z + lift), diameter / 2, material=material)
    ball.state.vel, ball.state.angVel = Vector3(speeds[name][:3]), Vector3(speeds[name][3:])
    balls.append(ball)
O.bodies.append(balls)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()], verletDist=-0.2),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.6)],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0, gravity=(0, 0, -9.81)),
]
O.dt = 4.8e-5


def read():
    """One row of the readings: step, kinetic energy, contacts per ball."""
    spheres = sum(1 for i in O.interactions if i.isReal and isinstance(O.bodies[i.id1].shape, Sphere) and isinstance(O.bodies[i.id2].shape, Sphere))
    with open(means, "a") as file:
        file.write("%d %g %g 0\n" % (O.iter + 1, utils.kineticEnergy(), 2.0 * spheres / len(balls)))


def start_clock():
    global begin
    begin = time.time()


# One O.run only: a second one sometimes never ends.
if sample > 0:
    open(means, "w").close()
    O.engines = O.engines + [PyRunner(iterPeriod=sample, initRun=False, command="read()")]
else:
    O.engines = O.engines + [PyRunner(iterPeriod=1, firstIterRun=warm, nDo=1, command="start_clock()")]
O.run(warm + steps, True)
print("speed %g" % (0 if sample > 0 else len(balls) * steps / (time.time() - begin)), flush=True)
os._exit(0)  # its own way out now and then crashes
