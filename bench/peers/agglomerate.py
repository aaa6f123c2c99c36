# The agglomerate of bench/agglomerate.cpp in YADE: yade -n -x -jN agglomerate.py START WARM STEPS GAP
# Cohesive-frictional contacts (CohFrictMat, Law2_ScGeom6D_CohFrictPhys_CohesionMoment): linear springs with bending and twist between
# the pairs that quern bonds, those nearer than GAP [m]; where bonds have failed, linear contacts with friction.
import os, sys, time, math
from yade import utils

start, warm, steps, gap = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4])
atoms, speeds, part = {}, {}, None
for line in open(start):
    words = line.split()
    if not words:
        continue
    if words[0] in ("Atoms", "Velocities"):
        part = words[0]
    elif part == "Atoms":
        atoms[int(words[0])] = [float(w) for w in words[2:]]
    elif part == "Velocities":
        speeds[int(words[0])] = [float(w) for w in words[1:]]

# k_n = E R of a pair of like balls. quern's bonds have E_b π R²/L_0 = E_b (π/2) R: the modulus is set so that both are alike.
grains = O.materials.append(CohFrictMat(density=2500, young=1e9 * math.pi / 2, poisson=0.4, frictionAngle=math.atan(0.5),
                                        normalCohesion=1e30, shearCohesion=1e30, momentRotationLaw=True, isCohesive=True,
                                        alphaKr=0.5, alphaKtw=0.5, etaRoll=-1, etaTwist=-1))
floor = O.materials.append(FrictMat(density=2500, young=1e9, poisson=0.3, frictionAngle=math.atan(0.5)))
O.bodies.append(utils.wall((0, 0, 0), axis=2, sense=1, material=floor))
balls = []
for name, (diameter, density, x, y, z) in atoms.items():
    ball = utils.sphere((x, y, z), diameter / 2, material=grains)
    ball.state.vel = Vector3(speeds[name][:3])
    balls.append(ball)
O.bodies.append(balls)
reach = 1 + gap / (2 * balls[0].shape.radius)
box, geometry = Bo1_Sphere_Aabb(aabbEnlargeFactor=reach), Ig2_Sphere_Sphere_ScGeom6D(interactionDetectionFactor=reach)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([box, Bo1_Wall_Aabb()], verletDist=-0.2),
    InteractionLoop([geometry, Ig2_Wall_Sphere_ScGeom()], [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True), Ip2_FrictMat_FrictMat_FrictPhys()],
                    [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(always_use_moment_law=False), Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(damping=0, gravity=(0, 0, -9.81)),
]
O.dt = 1e-30  # for the step in which pairs are bonded, whose gaps are not yet their rest lengths


def bonded():
    return sum(1 for i in O.interactions if i.isReal and getattr(i.phys, "cohesionBroken", True) is False)


def after_first():
    """The pairs are bonded: from now on only those that touch begin a contact."""
    for i in O.interactions:
        if i.isReal and isinstance(i.phys, CohFrictPhys):
            area = math.pi * balls[0].shape.radius**2
            i.phys.unp = i.geom.penetrationDepth
            i.phys.normalAdhesion, i.phys.shearAdhesion = 5e6 * area, 8e6 * area
    O.dt = 2e-7
    box.aabbEnlargeFactor = geometry.interactionDetectionFactor = 1
    print("bonds %g per grain" % (bonded() / len(balls)), flush=True)


def start_clock():
    global begin
    begin = time.time()


# One O.run only: a second one sometimes never ends.
O.engines = O.engines + [PyRunner(iterPeriod=1, firstIterRun=1, nDo=1, command="after_first()"),
                         PyRunner(iterPeriod=1, firstIterRun=max(warm, 2), nDo=1, command="start_clock()")]
O.run(warm + steps, True)
print("speed %g" % (len(balls) * steps / (time.time() - begin)), flush=True)
print("bonds left %g per grain" % (bonded() / len(balls)), flush=True)
os._exit(0)  # its own way out now and then crashes
