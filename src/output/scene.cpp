#include "src/output/scene.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include "src/output/packed_blocks.hpp"
#include "src/output/saved_frames.hpp"

namespace quern {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::uint16_t absent = 65535;       // in place of a coordinate
constexpr std::size_t most_frames = 2000;     // a minute and a half at 25 a second

Json numbers_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

struct Box {
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  void hold(const Vec3& x) { lower = lower.cwiseMin(x), upper = upper.cwiseMax(x); }
};

std::vector<SavedFrame> chosen(const std::vector<SavedFrame>& all, std::size_t room) {
  const SavedBalls last = read_balls(all.back().balls);
  const std::size_t each = last.list.size() * (7u + (last.fragments ? 2 : 0) + (last.shapes ? 4 : 0)) + 1;
  const std::size_t most = std::clamp<std::size_t>(room / each, 2, most_frames);
  if (all.size() <= most) return all;
  std::vector<SavedFrame> few;
  for (std::size_t k = 0; k < most; ++k) few.push_back(all[k * (all.size() - 1) / (most - 1)]);
  return few;
}

// What every frame says of every particle, by id.
class ParticleRows {
 public:
  explicit ParticleRows(const std::vector<SavedFrame>& frames) {
    for (const SavedFrame& frame : frames) {
      frames_.push_back(read_balls(frame.balls));
      for (const SavedBall& ball : frames_.back().list) count_ = std::max(count_, static_cast<std::size_t>(ball.id) + 1);
    }
    std::vector<double> speeds;
    for (const SavedBalls& balls : frames_)
      for (const SavedBall& ball : balls.list) box_.hold(ball.position), speeds.push_back(ball.speed);
    if (speeds.empty()) return;
    // One ball that flies would leave the others all of one colour.
    const auto high = speeds.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(speeds.size() - 1));
    std::nth_element(speeds.begin(), high, speeds.end());
    top_speed_ = *high;
  }

  std::size_t count() const { return count_; }
  const Box& box() const { return box_; }

  Json packed(PackedBlocks& blocks) const {
    std::vector<float> radius(count_, 0);
    std::vector<std::uint8_t> species(count_, 0), form(count_, 0), speed(count_ * frames_.size(), 0);
    std::vector<std::uint16_t> place(3 * count_ * frames_.size(), absent);
    std::vector<std::int16_t> fragment(frames_.back().fragments ? speed.size() : 0, -1);
    std::vector<std::int8_t> turn(frames_.back().shapes ? 4 * speed.size() : 0, 0);
    const Vec3 size = (box_.upper - box_.lower).cwiseMax(1e-12);
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      for (const SavedBall& ball : frames_[f].list) {
        const auto id = static_cast<std::size_t>(ball.id), at = f * count_ + id;
        radius[id] = static_cast<float>(0.5 * ball.diameter);
        species[id] = static_cast<std::uint8_t>(ball.species), form[id] = static_cast<std::uint8_t>(ball.shape);
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          place[3 * at + static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(std::lround((absent - 1) * (ball.position[axis] - box_.lower[axis]) / size[axis]));
        speed[at] = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, ball.speed / std::max(top_speed_, 1e-300))));
        if (!fragment.empty()) fragment[at] = static_cast<std::int16_t>(std::min(ball.fragment, 32767));
        for (std::size_t k = 0; k < 4 && !turn.empty(); ++k) turn[4 * at + k] = static_cast<std::int8_t>(std::lround(127 * ball.turn[k]));
      }
    }
    Json out = {{"count", count_}, {"names", frames_.back().species}, {"lower", numbers_of(box_.lower)}, {"upper", numbers_of(box_.lower + size)}, {"topSpeed", top_speed_},
                {"radius", blocks.add(radius)}, {"species", blocks.add(species)}, {"speed", blocks.add(speed)}, {"position", blocks.add_rows(place, 3 * count_)}};
    if (!fragment.empty()) out["fragment"] = blocks.add(fragment);
    if (!turn.empty()) out["form"] = blocks.add(form), out["orientation"] = blocks.add(turn);
    return out;
  }

  // The surface of each shape in the axes of its particle, the radius being 1.
  Json forms(const SavedFrame& frame, PackedBlocks& blocks) const {
    std::map<int, const SavedBall*> examples;
    for (const SavedBall& ball : frames_.back().list)
      if (ball.shape > 0) examples.emplace(ball.shape, &ball);
    Json out = Json::array();
    for (int shape = 1; !examples.empty() && shape <= examples.rbegin()->first; ++shape) {
      std::vector<float> points, normals;
      SavedSurface surface;
      if (examples.count(shape)) {
        const SavedBall& ball = *examples.at(shape);
        surface = read_shape(frame.shapes, ball.id);
        const Rotation turn(ball.turn[0], ball.turn[1], ball.turn[2], ball.turn[3]);
        for (Vec3& x : surface.points) x = turn.conjugate() * (x - ball.position) / (0.5 * ball.diameter);
        std::vector<Vec3> normal(surface.points.size(), Vec3::Zero());
        for (std::size_t t = 0; t < surface.triangles.size(); t += 3) {
          const auto a = surface.triangles[t], b = surface.triangles[t + 1], c = surface.triangles[t + 2];
          const Vec3 area = (surface.points[b] - surface.points[a]).cross(surface.points[c] - surface.points[a]);
          normal[a] += area, normal[b] += area, normal[c] += area;
        }
        for (std::size_t k = 0; k < surface.points.size(); ++k)
          for (Eigen::Index axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(surface.points[k][axis])), normals.push_back(static_cast<float>(normal[k].normalized()[axis]));
      }
      out.push_back({{"points", blocks.add(points)}, {"normals", blocks.add(normals)}, {"triangles", blocks.add(surface.triangles)}});
    }
    return out;
  }

 private:
  std::vector<SavedBalls> frames_;
  std::size_t count_ = 0;
  Box box_;
  double top_speed_ = 0;  // of all but a hundredth [m/s]
};

// How a wall has moved since it stood at `from`, if it moved as a whole.
std::optional<Eigen::Isometry3d> motion_of(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  if (from.size() != to.size() || from.size() < 3) return {};
  constexpr std::size_t enough = 200;  // points to tell it by
  const std::size_t every = std::max<std::size_t>(1, from.size() / enough), count = (from.size() + every - 1) / every;
  Eigen::Matrix3Xd a(3, count), b(3, count);
  for (std::size_t k = 0; k < count; ++k) a.col(static_cast<Eigen::Index>(k)) = from[k * every], b.col(static_cast<Eigen::Index>(k)) = to[k * every];
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (a == b) return motion;
  motion.matrix() = Eigen::umeyama(a, b, false);
  const double extent = (a.rowwise().maxCoeff() - a.rowwise().minCoeff()).norm();
  const double misfit = ((motion.linear() * a).colwise() + motion.translation() - b).colwise().norm().maxCoeff();
  if (misfit > 1e-5 * extent) return {};
  return motion;
}

// Walls frame by frame. One of few points (a plane, shown as far as the charge reaches) may change; others move as a whole.
class WallRows {
 public:
  void add(const std::vector<SavedSurface>& walls) {
    if (walls_.empty()) walls_.resize(walls.size());
    for (std::size_t w = 0; w < std::min(walls_.size(), walls.size()); ++w) {
      One& one = walls_[w];
      if (one.first.points.empty()) one.first = walls[w];
      const std::vector<Vec3>& points = walls[w].points;
      if (points.size() <= few)
        for (const Vec3& x : points)
          for (const double coordinate : x) one.shots.push_back(static_cast<float>(coordinate));
      const auto motion = motion_of(one.first.points, points);
      one.whole &= motion.has_value();
      if (!motion) continue;
      one.moves |= !motion->matrix().isIdentity(1e-12);
      const Rotation turn(motion->linear());
      for (const double x : {turn.w(), turn.x(), turn.y(), turn.z(), motion->translation().x(), motion->translation().y(), motion->translation().z()}) one.poses.push_back(static_cast<float>(x));
    }
  }

  Json packed(PackedBlocks& blocks, Box& box) const {
    Json out = Json::array();
    for (const One& one : walls_) {
      std::vector<float> points;
      for (const Vec3& x : one.first.points) {
        box.hold(x);
        for (const double coordinate : x) points.push_back(static_cast<float>(coordinate));
      }
      const bool changes = !one.whole && one.first.points.size() <= few;
      Json wall = {{"shots", changes ? one.shots.size() / points.size() : 1}, {"points", blocks.add(changes ? one.shots : points)}, {"triangles", blocks.add(one.first.triangles)}};
      if (one.whole && one.moves) wall["poses"] = blocks.add(one.poses);
      out.push_back(std::move(wall));
    }
    return out;
  }

 private:
  static constexpr std::size_t few = 8;
  struct One {
    SavedSurface first;
    std::vector<float> shots, poses;
    bool whole = true, moves = false;
  };
  std::vector<One> walls_;
};

Json walls_of(const std::vector<SavedFrame>& frames, PackedBlocks& blocks, Box& box) {
  WallRows rows;
  const bool still = frames.front().walls == frames.back().walls;
  for (const SavedFrame& frame : frames) {
    if (frame.walls.empty()) continue;
    rows.add(read_walls(frame.walls));
    if (still) break;
  }
  return rows.packed(blocks, box);
}

// Each bond with the first and the last frame in which it holds.
Json bonds_of(const std::vector<SavedFrame>& frames, PackedBlocks& blocks) {
  std::map<int, std::size_t> row;
  std::vector<std::uint32_t> pairs;
  std::vector<std::uint16_t> life;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].bonds.empty()) continue;
    for (const SavedBond& bond : read_bonds(frames[f].bonds)) {
      const auto [found, fresh] = row.emplace(bond.number, row.size());
      if (fresh) {
        pairs.insert(pairs.end(), {static_cast<std::uint32_t>(bond.first), static_cast<std::uint32_t>(bond.second)});
        life.insert(life.end(), 2, static_cast<std::uint16_t>(f));
      }
      life[2 * found->second + 1] = static_cast<std::uint16_t>(f);
    }
  }
  return {{"pairs", blocks.add(pairs)}, {"frames", blocks.add(life)}};
}

int decimals_of(const std::vector<SavedFrame>& frames) {
  const double step = frames.size() > 1 ? (frames.back().time - frames.front().time) / static_cast<double>(frames.size() - 1) : 1;
  return step > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(step))), 1, 9) : 3;
}

}  // namespace

std::optional<PackedScene> pack_scene(const std::string& directory, const SceneView& view, std::size_t room) {
  const std::vector<SavedFrame> all = saved_frames(directory);
  if (all.empty()) return {};
  const std::vector<SavedFrame> frames = chosen(all, room);
  PackedBlocks blocks;
  const ParticleRows rows(frames);
  if (rows.count() == 0) return {};
  Box box = rows.box();
  Json scene;
  for (const SavedFrame& frame : frames) scene["times"].push_back(frame.time);
  scene["decimals"] = decimals_of(frames);
  scene["particles"] = rows.packed(blocks);
  if (!frames.back().shapes.empty()) scene["forms"] = rows.forms(frames.back(), blocks);
  scene["walls"] = walls_of(frames, blocks, box);
  if (!frames.back().bonds.empty()) scene["bonds"] = bonds_of(frames, blocks);
  scene["middle"] = numbers_of(0.5 * (box.lower + box.upper));
  scene["reach"] = 0.5 * (box.upper - box.lower).norm();
  scene["view"] = {{"forward", numbers_of(view.forward.normalized())}, {"up", numbers_of(view.up)}};
  return PackedScene{scene.dump(), blocks.text(), frames.size(), all.size(), rows.count(), frames.front().time, frames.back().time};
}

}  // namespace quern
