// The charge and its mill on vtk.js: what stands on the stage, and how it is moved to a frame.
import '@kitware/vtk.js/Rendering/OpenGL/Camera.js';
import '@kitware/vtk.js/Rendering/OpenGL/Renderer.js';
import '@kitware/vtk.js/Rendering/OpenGL/Actor.js';
import '@kitware/vtk.js/Rendering/OpenGL/PolyDataMapper.js';
import '@kitware/vtk.js/Rendering/OpenGL/SphereMapper.js';
import '@kitware/vtk.js/Rendering/OpenGL/Glyph3DMapper.js';
import vtkActor from '@kitware/vtk.js/Rendering/Core/Actor.js';
import vtkCellArray from '@kitware/vtk.js/Common/Core/CellArray.js';
import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray.js';
import vtkGenericRenderWindow from '@kitware/vtk.js/Rendering/Misc/GenericRenderWindow.js';
import vtkGlyph3DMapper from '@kitware/vtk.js/Rendering/Core/Glyph3DMapper.js';
import vtkMapper from '@kitware/vtk.js/Rendering/Core/Mapper.js';
import vtkPolyData from '@kitware/vtk.js/Common/DataModel/PolyData.js';
import vtkSphereMapper from '@kitware/vtk.js/Rendering/Core/SphereMapper.js';
import { OrientationModes, ScaleModes } from '@kitware/vtk.js/Rendering/Core/Glyph3DMapper/Constants.js';
import { edgesOf, matrixOf, rotationOf, segments } from './geometry.js';
import { cornersOf, seenWhole } from './camera.js';

const wallColour = [0.42, 0.5, 0.62], edgeColour = [0.3, 0.33, 0.4];

function polyData(points, { lines, triangles } = {}) {
  const data = vtkPolyData.newInstance();
  data.getPoints().setData(points, 3);
  if (lines) data.getLines().setData(lines);
  if (triangles) data.getPolys().setData(triangles);
  return data;
}

function addArray(data, name, values, components) {
  data.getPointData().addArray(vtkDataArray.newInstance({ name, values, numberOfComponents: components }));
}

// Cells of `corners` points each, as vtk.js counts them.
function cells(indices, corners) {
  const out = new Uint32Array((indices.length / corners) * (corners + 1));
  for (let k = 0, at = 0; k < indices.length; ++k) {
    if (k % corners === 0) out[at++] = corners;
    out[at++] = indices[k];
  }
  return out;
}

function actorOf(mapper, { colour, opacity = 1, lit = true, width = 1 } = {}) {
  const actor = vtkActor.newInstance(), look = actor.getProperty();
  actor.setMapper(mapper);
  if (colour) look.setColor(...colour);
  look.setOpacity(opacity);
  look.setLineWidth(width);
  if (lit) look.setAmbient(0.3), look.setDiffuse(0.75), look.setSpecular(0.15), look.setSpecularPower(25);
  else look.setLighting(false);
  return actor;
}

// Particles of one form: spheres, or the surface of one species turned and scaled.
function particlesOf(members, scene, form) {
  const points = new Float32Array(3 * members.length), colours = new Uint8Array(3 * members.length), size = new Float32Array(members.length);
  const data = polyData(points);
  addArray(data, 'colour', colours, 3);
  addArray(data, 'size', size, 1);
  const mapper = form ? vtkGlyph3DMapper.newInstance() : vtkSphereMapper.newInstance();
  mapper.setInputData(data, 0);
  mapper.setScaleArray('size');
  mapper.setScalarModeToUsePointFieldData();
  mapper.setColorByArrayName('colour');
  let turns = null;
  if (form) {
    turns = new Float32Array(9 * members.length);
    addArray(data, 'turn', turns, 9);
    const surface = polyData(form.points, { triangles: cells(form.triangles, 3) });
    surface.getPointData().setNormals(vtkDataArray.newInstance({ name: 'Normals', values: form.normals, numberOfComponents: 3 }));
    mapper.setInputData(surface, 1);
    mapper.setOrientationArray('turn');
    mapper.setOrientationMode(OrientationModes.MATRIX);
    mapper.setScaleMode(ScaleModes.SCALE_BY_MAGNITUDE);
  }
  const move = (places, colourOf, frame) => {
    members.forEach((particle, row) => {
      const there = !Number.isNaN(places[3 * particle]);
      for (let c = 0; c < 3; ++c) {
        points[3 * row + c] = there ? places[3 * particle + c] : scene.middle[c];
        colours[3 * row + c] = colourOf[3 * particle + c];
      }
      size[row] = there ? scene.particles.radius[particle] : 0;
      if (turns && there) turns.set(rotationOf(scene.particles.orientation, 4 * (frame * scene.particles.count + particle)), 9 * row);
    });
    data.getPoints().modified();
    for (const array of data.getPointData().getArrays()) array.modified();
    data.modified();
  };
  return { actor: actorOf(mapper), move };
}

// A wall that stands, moves as a whole, or (a plane that is shown as far as the charge reaches) changes its corners.
function wallOf(wall) {
  const given = wall.points.length / wall.shots;
  const corners = new Float32Array(wall.points.subarray(0, given));
  const skin = polyData(corners, { triangles: cells(wall.triangles, 3) });
  const rim = polyData(corners, { lines: cells(edgesOf(corners, wall.triangles), 2) });
  const actors = [skin, rim].map((data, k) => {
    const mapper = vtkMapper.newInstance({ scalarVisibility: false });
    mapper.setInputData(data);
    return actorOf(mapper, k === 0 ? { colour: wallColour, opacity: 0.16 } : { colour: edgeColour, lit: false, opacity: 0.55 });
  });
  const move = (frame) => {
    if (wall.shots > 1) {
      corners.set(wall.points.subarray(given * frame, given * (frame + 1)));
      for (const data of [skin, rim]) data.getPoints().modified(), data.modified();
    }
    if (wall.poses) for (const actor of actors) actor.setUserMatrix(matrixOf(wall.poses, 7 * frame));
  };
  return { actors, move };
}

function bondsOf(bonds) {
  const data = polyData(new Float32Array(0));
  const mapper = vtkMapper.newInstance({ scalarVisibility: false });
  mapper.setInputData(data);
  const move = (places, frame) => {
    const points = segments(bonds, places, frame);
    data.getPoints().setData(points, 3);
    data.getLines().setData(cells(Uint32Array.from({ length: points.length / 3 }, (_, k) => k), 2));
    data.modified();
  };
  return { actor: actorOf(mapper, { colour: [0.1, 0.1, 0.12], lit: false, width: 2 }), move };
}

export function makeStage(home, scene) {
  const view = vtkGenericRenderWindow.newInstance({ background: [1, 1, 1], listenWindowResize: false });
  view.setContainer(home);
  const renderer = view.getRenderer(), window_ = view.getRenderWindow(), camera = renderer.getActiveCamera();
  // vtk.js takes the first move after a fifth of a second for a beginning alone: where a picture takes longer, nothing would ever turn.
  const hand = view.getInteractor();
  hand.onStartMouseMove((event) => hand.getInteractorStyle().handleMouseMove(event));
  const { particles } = scene;
  const all = Array.from({ length: particles.count }, (_, k) => k);
  const forms = [null, ...(scene.forms ?? [])];
  const groups = forms.map((form, f) => particlesOf(all.filter((k) => (particles.form ? particles.form[k] === f : f === 0)), scene, form));
  const walls = scene.walls.map(wallOf);
  const bonds = scene.bonds ? bondsOf(scene.bonds) : null;
  for (const group of groups) renderer.addActor(group.actor);
  for (const wall of walls) wall.actors.forEach((actor) => renderer.addActor(actor));
  if (bonds) renderer.addActor(bonds.actor);

  // As near as shows all that the mill and its charge ever reach.
  const reset = () => {
    const { forward, up } = scene.view, angle = 24;
    const canvas = home.getBoundingClientRect();
    const { centre, distance } = seenWhole(cornersOf(scene), forward, up, angle, canvas.width / Math.max(canvas.height, 1));
    camera.setFocalPoint(...centre);
    camera.setPosition(...centre.map((x, c) => x - forward[c] * distance));
    camera.setViewUp(...up);
    camera.setViewAngle(angle);
    renderer.resetCameraClippingRange();
  };
  return {
    draw: () => { renderer.resetCameraClippingRange(); window_.render(); },
    reset,
    resize: () => view.resize(),
    canvas: () => home.querySelector('canvas'),
    show(frame, places, colours) {
      for (const group of groups) group.move(places, colours, frame);
      for (const wall of walls) wall.move(frame);
      bonds?.move(places, frame);
    },
    setWalls(shown) { for (const wall of walls) wall.actors.forEach((actor) => actor.setVisibility(shown)); },
    setBonds(shown) { bonds?.actor.setVisibility(shown); },
  };
}
