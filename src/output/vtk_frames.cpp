#include "src/output/vtk_frames.hpp"
#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataWriter.h>
#include <algorithm>
#include <numeric>
#include "bonds/fragments.hpp"
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/output/shape_surfaces.hpp"
#include "src/output/wall_facets.hpp"

namespace quern {
namespace {

template <class Array>
vtkNew<Array> array(const char* name, int components, std::size_t rows) {
  vtkNew<Array> made;
  made->SetName(name);
  made->SetNumberOfComponents(components);
  made->SetNumberOfTuples(static_cast<vtkIdType>(rows));
  return made;
}

void write(vtkPolyData* data, const std::string& path) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->WriteToOutputStringOn();
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  if (writer->Write() != 1) throw WriteError("The file " + path + " cannot be written: VTK gives no reason.");
  write_whole_file(path, writer->GetOutputString());
}

// Words that go with the numbers of an array, in their order.
template <class List>
void add_names(vtkPolyData* data, const char* name, const List& list) {
  vtkNew<vtkStringArray> names;
  names->SetName(name);
  for (const auto& entry : list) names->InsertNextValue(entry.name);
  data->GetFieldData()->AddArray(names);
}

// With bonds: which fragment a grain belongs to, by mass (0 the heaviest) and by its name; −1: no grain.
vtkNew<vtkPolyData> balls_of(const Simulation& s) {
  const Particles& p = s.particles;
  std::vector<std::size_t> order(static_cast<std::size_t>(p.owned));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p.id[a] < p.id[b]; });

  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(p.owned);
  auto velocity = array<vtkFloatArray>("velocity", 3, order.size()), spin = array<vtkFloatArray>("angular_velocity", 3, order.size());
  auto diameter = array<vtkFloatArray>("diameter", 1, order.size()), mass = array<vtkFloatArray>("mass", 1, order.size());
  auto species = array<vtkIntArray>("species", 1, order.size()), id = array<vtkIntArray>("id", 1, order.size());
  vtkNew<vtkCellArray> vertices;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t i = order[k];
    const auto row = static_cast<vtkIdType>(k);
    const Quad &x = p.position[i], &v = p.velocity[i], &w = p.spin[i];
    points->SetPoint(row, x.x, x.y, x.z);
    velocity->SetTuple3(row, v.x, v.y, v.z);
    spin->SetTuple3(row, w.x, w.y, w.z);
    diameter->SetValue(row, static_cast<float>(2 * s.solid_radius(static_cast<Index>(i))));
    mass->SetValue(row, static_cast<float>(v.w));
    species->SetValue(row, p.species[i]);
    id->SetValue(row, p.id[i]);
    vertices->InsertNextCell(1, &row);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetVerts(vertices);
  for (vtkDataArray* a : {static_cast<vtkDataArray*>(velocity), static_cast<vtkDataArray*>(spin), static_cast<vtkDataArray*>(diameter),
                          static_cast<vtkDataArray*>(mass), static_cast<vtkDataArray*>(species), static_cast<vtkDataArray*>(id)}) {
    data->GetPointData()->AddArray(a);
  }
  if (!p.shape.empty()) {
    auto shape = array<vtkIntArray>("shape", 1, order.size());
    auto turn = array<vtkFloatArray>("orientation", 4, order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Rotation q = rotation_of(p.orientation[order[k]]);
      shape->SetValue(static_cast<vtkIdType>(k), p.shape[order[k]]);
      turn->SetTuple4(static_cast<vtkIdType>(k), q.w(), q.x(), q.y(), q.z());
    }
    data->GetPointData()->AddArray(shape);
    data->GetPointData()->AddArray(turn);
  }
  add_names(data, "species_names", s.species);
  if (!s.bonds.empty()) {
    const Fragments fragments = find_fragments(s.bonds, p, s.domain);
    auto rank = array<vtkIntArray>("fragment", 1, order.size()), name = array<vtkIntArray>("fragment_id", 1, order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Index of = fragments.of_row[order[k]];
      rank->SetValue(static_cast<vtkIdType>(k), of);
      name->SetValue(static_cast<vtkIdType>(k), of < 0 ? -1 : fragments.list[static_cast<std::size_t>(of)].id);
    }
    data->GetPointData()->AddArray(rank);
    data->GetPointData()->AddArray(name);
  }
  data->GetPointData()->SetActiveVectors("velocity");
  data->GetPointData()->SetActiveScalars("diameter");
  return data;
}

// The intact bonds as lines between the centres of their grains.
vtkNew<vtkPolyData> bonds_of(const Simulation& s) {
  const Particles& p = s.particles;
  Index most = 0;
  for (const Bond& bond : s.bonds.list) most = std::max(most, bond.second);
  std::vector<Index> row_of(static_cast<std::size_t>(most + 1), -1);
  for (Index row = 0; row < p.owned; ++row)
    if (const Index id = p.id[static_cast<std::size_t>(row)]; id <= most) row_of[static_cast<std::size_t>(id)] = row;

  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  auto stress = array<vtkFloatArray>("stress", 1, 0), radius = array<vtkFloatArray>("radius", 1, 0);
  auto number = array<vtkIntArray>("bond", 1, 0), material = array<vtkIntArray>("material", 1, 0), grain = array<vtkIntArray>("id", 1, 0);
  for (std::size_t k = 0; k < s.bonds.list.size(); ++k) {
    const Bond& bond = s.bonds.list[k];
    const Index first = row_of[static_cast<std::size_t>(bond.first)], second = row_of[static_cast<std::size_t>(bond.second)];
    if (bond.state != BondState::intact || first < 0 || second < 0) continue;
    const Triple<double> from = xyz(p.position[static_cast<std::size_t>(first)]);
    const Triple<double> apart = s.domain.nearest(xyz(p.position[static_cast<std::size_t>(second)]) - from), to = from + apart;
    const vtkIdType begin = points->InsertNextPoint(from.x, from.y, from.z);
    lines->InsertNextCell({begin, points->InsertNextPoint(to.x, to.y, to.z)});
    grain->InsertNextValue(bond.first);
    grain->InsertNextValue(bond.second);
    stress->InsertNextValue(static_cast<float>(bond.normal_stiffness * (length(apart) - bond.length)));
    radius->InsertNextValue(static_cast<float>(bond.radius));
    number->InsertNextValue(static_cast<int>(k));
    material->InsertNextValue(bond.material);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(lines);
  for (vtkDataArray* a : {static_cast<vtkDataArray*>(stress), static_cast<vtkDataArray*>(radius), static_cast<vtkDataArray*>(number), static_cast<vtkDataArray*>(material)})
    data->GetCellData()->AddArray(a);
  data->GetPointData()->AddArray(grain);
  data->GetCellData()->SetActiveScalars("stress");
  return data;
}

// The surfaces of particles that are no spheres.
vtkNew<vtkPolyData> shapes_of(const Simulation& s) {
  constexpr int cells = 4;
  const ShapeSurfaces surfaces = shape_surfaces(s, cells, [](std::size_t) { return true; });
  const Particles& p = s.particles;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> triangles;
  auto velocity = array<vtkFloatArray>("velocity", 3, 0), diameter = array<vtkFloatArray>("diameter", 1, 0);
  auto species = array<vtkIntArray>("species", 1, 0), id = array<vtkIntArray>("id", 1, 0);
  for (std::size_t k = 0; k < surfaces.points.size(); ++k) {
    const std::size_t i = surfaces.particle[k];
    const Quad& v = p.velocity[i];
    points->InsertNextPoint(surfaces.points[k].data());
    velocity->InsertNextTuple3(v.x, v.y, v.z);
    diameter->InsertNextValue(static_cast<float>(2 * s.solid_radius(static_cast<Index>(i))));
    species->InsertNextValue(p.species[i]);
    id->InsertNextValue(p.id[i]);
  }
  for (const auto& t : surfaces.triangles) triangles->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(triangles);
  for (vtkDataArray* a : {static_cast<vtkDataArray*>(velocity), static_cast<vtkDataArray*>(diameter), static_cast<vtkDataArray*>(species), static_cast<vtkDataArray*>(id)})
    data->GetPointData()->AddArray(a);
  data->GetPointData()->SetActiveVectors("velocity");
  return data;
}

vtkNew<vtkPolyData> walls_of(const Simulation& s) {
  const Surroundings shown = surroundings(s.walls, s.particles.position);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> triangles;
  vtkNew<vtkIntArray> wall;
  wall->SetName("wall");
  vtkNew<vtkFloatArray> velocity;
  velocity->SetName("velocity");
  velocity->SetNumberOfComponents(3);
  for (std::size_t w = 0; w < s.walls.size(); ++w) {
    const Facets facets = facets_of(s.walls[w], shown);
    const vtkIdType base = points->GetNumberOfPoints();
    for (const Vec3& point : facets.points) {
      points->InsertNextPoint(point.data());
      const Vec3 v = s.walls[w].pose.velocity_at(point);
      velocity->InsertNextTuple3(v.x(), v.y(), v.z());
    }
    for (const auto& t : facets.triangles) {
      triangles->InsertNextCell({base + t[0], base + t[1], base + t[2]});
      wall->InsertNextValue(static_cast<int>(w));
    }
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(triangles);
  data->GetPointData()->AddArray(velocity);
  data->GetCellData()->AddArray(wall);
  add_names(data, "wall_names", s.walls);
  return data;
}

}  // namespace

VtkFrames::VtkFrames(std::string directory) : directory_(std::move(directory)) { make_directory(directory_ + "/frames"); }

void VtkFrames::append(const Simulation& s) {
  const auto list = [&](int part, const char* name, const std::string& file) {
    entries_ += fmt::format("    <DataSet timestep=\"{:.17g}\" part=\"{}\" name=\"{}\" file=\"{}\"/>\n", s.clock.time(), part, name, file);
  };
  const std::string balls = fmt::format("frames/balls_{:06}.vtp", frames_);
  write(balls_of(s), directory_ + "/" + balls);
  list(0, "balls", balls);
  if (!s.walls.empty()) {
    const bool moving = std::any_of(s.walls.begin(), s.walls.end(), [](const Wall& wall) { return wall.frame >= 0; });
    std::string walls = moving ? fmt::format("frames/walls_{:06}.vtp", frames_) : fixed_walls_;
    if (walls.empty()) fixed_walls_ = walls = "frames/walls.vtp";
    if (moving || frames_ == 0) write(walls_of(s), directory_ + "/" + walls);
    list(1, "walls", walls);
  }
  if (!s.bonds.empty()) {
    const std::string bonds = fmt::format("frames/bonds_{:06}.vtp", frames_);
    write(bonds_of(s), directory_ + "/" + bonds);
    list(2, "bonds", bonds);
  }
  if (!s.shapes.empty()) {
    const std::string shapes = fmt::format("frames/shapes_{:06}.vtp", frames_);
    write(shapes_of(s), directory_ + "/" + shapes);
    list(3, "shapes", shapes);
  }
  ++frames_;
  write_whole_file(directory_ + "/frames.pvd",
                   "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n" +
                       entries_ + "  </Collection>\n</VTKFile>\n");
}

}  // namespace quern
