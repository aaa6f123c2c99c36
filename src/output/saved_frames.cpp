#include "src/output/saved_frames.hpp"
#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <filesystem>
#include <map>
#include "src/base/error.hpp"

namespace quern {
namespace {

vtkSmartPointer<vtkPolyData> data_in(const std::string& path) {
  if (!std::filesystem::exists(path)) throw RunError("The frame " + path + " is missing.");
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  if (reader->GetErrorCode() != 0 || reader->GetOutput() == nullptr) throw RunError("The frame " + path + " cannot be read.");
  return reader->GetOutput();
}

vtkDataArray* array_of(vtkDataSetAttributes* data, const char* name, const std::string& path) {
  vtkDataArray* array = data->GetArray(name);
  if (array == nullptr) throw RunError(fmt::format("The frame {} has no array \"{}\": it is none of this version's.", path, name));
  return array;
}

Vec3 point_of(vtkPolyData* data, vtkIdType k) {
  double x[3];
  data->GetPoint(k, x);
  return {x[0], x[1], x[2]};
}

}  // namespace

std::vector<SavedFrame> saved_frames(const std::string& directory) {
  const std::string file = directory + "/frames.pvd";
  if (!std::filesystem::exists(file)) return {};
  boost::property_tree::ptree tree;
  try {
    boost::property_tree::read_xml(file, tree);
    std::vector<SavedFrame> frames;
    for (const auto& [tag, entry] : tree.get_child("VTKFile.Collection")) {
      if (tag != "DataSet") continue;
      const double time = entry.get<double>("<xmlattr>.timestep");
      if (frames.empty() || frames.back().time != time) frames.push_back({time, "", "", "", ""});
      const std::string name = entry.get<std::string>("<xmlattr>.name"), path = directory + "/" + entry.get<std::string>("<xmlattr>.file");
      SavedFrame& frame = frames.back();
      (name == "balls" ? frame.balls : name == "walls" ? frame.walls : name == "bonds" ? frame.bonds : frame.shapes) = path;
    }
    std::erase_if(frames, [](const SavedFrame& frame) { return frame.balls.empty(); });
    return frames;
  } catch (const boost::property_tree::ptree_error& error) {
    throw RunError(fmt::format("{}: this is no list of frames ({}).", file, error.what()));
  }
}

SavedBalls read_balls(const std::string& path) {
  const auto data = data_in(path);
  vtkPointData* of = data->GetPointData();
  vtkDataArray *diameter = array_of(of, "diameter", path), *velocity = array_of(of, "velocity", path), *species = array_of(of, "species", path), *id = array_of(of, "id", path);
  vtkDataArray *fragment = of->GetArray("fragment"), *shape = of->GetArray("shape"), *turn = of->GetArray("orientation");
  SavedBalls balls;
  balls.fragments = fragment != nullptr;
  balls.shapes = shape != nullptr && turn != nullptr;
  for (vtkIdType k = 0; k < data->GetNumberOfPoints(); ++k) {
    const double* v = velocity->GetTuple3(k);
    SavedBall ball;
    ball.position = point_of(data, k);
    ball.diameter = diameter->GetTuple1(k);
    ball.speed = Vec3(v[0], v[1], v[2]).norm();
    ball.id = static_cast<int>(id->GetTuple1(k)), ball.species = static_cast<int>(species->GetTuple1(k));
    if (fragment) ball.fragment = static_cast<int>(fragment->GetTuple1(k));
    if (balls.shapes) {
      ball.shape = static_cast<int>(shape->GetTuple1(k));
      const double* q = turn->GetTuple4(k);
      ball.turn = {q[0], q[1], q[2], q[3]};
    }
    balls.list.push_back(ball);
  }
  if (auto* names = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("species_names")))
    for (vtkIdType k = 0; k < names->GetNumberOfValues(); ++k) balls.species.push_back(names->GetValue(k));
  return balls;
}

std::vector<SavedSurface> read_walls(const std::string& path) {
  const auto data = data_in(path);
  vtkDataArray* wall = array_of(data->GetCellData(), "wall", path);
  std::vector<SavedSurface> walls;
  std::vector<vtkIdType> first;  // of each wall's points, which stand one after the other
  vtkNew<vtkIdList> corners;
  vtkIdType next = 0;
  for (vtkIdType t = 0; t < data->GetNumberOfPolys(); ++t) {
    const auto w = static_cast<std::size_t>(wall->GetTuple1(t));
    data->GetPolys()->GetCellAtId(t, corners);
    if (w >= walls.size()) walls.resize(w + 1), first.resize(w + 1, next);
    for (vtkIdType k = 0; k < corners->GetNumberOfIds(); ++k) {
      walls[w].triangles.push_back(static_cast<std::uint32_t>(corners->GetId(k) - first[w]));
      next = std::max(next, corners->GetId(k) + 1);
    }
  }
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (vtkIdType k = first[w]; k < (w + 1 < walls.size() ? first[w + 1] : data->GetNumberOfPoints()); ++k) walls[w].points.push_back(point_of(data, k));
  return walls;
}

std::vector<SavedBond> read_bonds(const std::string& path) {
  const auto data = data_in(path);
  std::vector<SavedBond> bonds;
  if (data->GetNumberOfLines() == 0) return bonds;
  vtkDataArray *number = array_of(data->GetCellData(), "bond", path), *grain = array_of(data->GetPointData(), "id", path);
  for (vtkIdType k = 0; k < data->GetNumberOfLines(); ++k)
    bonds.push_back({static_cast<int>(number->GetTuple1(k)), static_cast<int>(grain->GetTuple1(2 * k)), static_cast<int>(grain->GetTuple1(2 * k + 1))});
  return bonds;
}

SavedSurface read_shape(const std::string& path, int id) {
  const auto data = data_in(path);
  vtkDataArray* of = array_of(data->GetPointData(), "id", path);
  SavedSurface surface;
  std::map<vtkIdType, std::uint32_t> row;
  for (vtkIdType k = 0; k < data->GetNumberOfPoints(); ++k) {
    if (static_cast<int>(of->GetTuple1(k)) != id) continue;
    row[k] = static_cast<std::uint32_t>(surface.points.size());
    surface.points.push_back(point_of(data, k));
  }
  vtkNew<vtkIdList> corners;
  for (vtkIdType t = 0; t < data->GetNumberOfPolys(); ++t) {
    data->GetPolys()->GetCellAtId(t, corners);
    if (row.count(corners->GetId(0)) == 0) continue;
    for (vtkIdType k = 0; k < 3; ++k) surface.triangles.push_back(row.at(corners->GetId(k)));
  }
  return surface;
}

}  // namespace quern
