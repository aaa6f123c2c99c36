#include "src/case/insertion.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"
#include "src/case/bodies.hpp"
#include "src/case/reading.hpp"
#include "src/case/shape_input.hpp"
#include "src/particle/packing.hpp"

namespace quern {
namespace {

constexpr double tolerated_overlap = 1e-6;  // at the start, in radii

// `vial`: of a planetary mill.
Region region_of(const InsertCase& insert, const Case& c, int vial) {
  Region region;
  if (insert.shape == InsertCase::Shape::mill) return c.planetary ? inside_of(*c.planetary, vial) : c.stirred ? inside_of(*c.stirred) : inside_of(*c.mill);
  region.pose.origin = insert.centre;
  switch (insert.shape) {
    case InsertCase::Shape::box: region.shape = BoxRegion{-0.5 * insert.size, 0.5 * insert.size}; break;
    case InsertCase::Shape::sphere: region.shape = SphereRegion{insert.radius}; break;
    default:
      region.shape = CylinderRegion{insert.radius, -0.5 * insert.length, 0.5 * insert.length};
      region.pose.axes = axes_with_z(insert.axis);
  }
  return region;
}

bool same_place(const InsertCase& a, const InsertCase& b) {
  return a.method == b.method && a.shape == b.shape && a.centre == b.centre && a.axis == b.axis && a.size == b.size && a.radius == b.radius &&
         a.length == b.length && a.velocity == b.velocity && a.spin == b.spin;
}

void add_ball(Simulation& s, const Case& c, std::uint8_t species, const Vec3& centre, double diameter, const Vec3& velocity, const Vec3& spin) {
  const SpeciesCase& kind = c.species[species];
  const auto row = static_cast<std::size_t>(s.particles.add_sphere(triple(centre), 0.5 * diameter, kind.density, kind.material, species));
  set(s.particles.velocity[row], velocity);
  set(s.particles.spin[row], spin);
}

std::vector<Quad> those_in(const PlanetaryMill& mill, int vial, const std::vector<Quad>& balls) {
  std::vector<Quad> inside;
  const Pose pose = vial_pose(mill, vial);
  for (const Quad& ball : balls) {
    const Vec3 own = pose.to_local(vec(ball));
    if (std::hypot(own.x(), own.y()) < 0.5 * mill.vial_diameter && std::abs(own.z()) < 0.5 * mill.vial_length) inside.push_back(ball);
  }
  return inside;
}

void refuse_overlaps(const InsertCase& insert, double allowed, const Simulation& s) {
  std::vector<Quad> balls;
  for (std::size_t i = 0; i < s.particles.position.size(); ++i)
    if (s.particles.shape.empty() || s.particles.shape[i] == 0) balls.push_back(s.particles.position[i]);
  const double overlap = std::max(largest_overlap(balls, s.walls, s.domain), largest_shape_overlap(s));
  if (overlap > allowed)
    refuse(insert.where, "insert." + insert.name, fmt::format("found particles that overlap each other or a wall by {:.3g} of the smaller radius at the start; allowed is {}", overlap, allowed > tolerated_overlap ? fmt::format("{:g} (allowed_overlap)", allowed) : "none"));
}

Portion portion_of(const Case& c, const InsertCase& insert, double reference_volume) {
  const SpeciesCase& species = c.species[insert.species];
  Portion portion{insert.species, species.density, species.sizes, insert.count, insert.mass, insert.filling};
  if (!species.shape) return portion;
  // Placed as the balls that hold them; their amount is that of the bodies themselves.
  const double volume = species.shape->volume * species.sizes.mean_power(3) / std::pow(2 * species.shape->bounding_radius, 3);
  if (insert.mass > 0) portion.count = std::llround(insert.mass / (species.density * volume));
  if (insert.filling > 0) portion.count = std::llround(insert.filling * reference_volume * (1 - bulk_porosity) / volume);
  portion.mass = portion.filling = 0;
  return portion;
}

Mat3 rotation_by(const Vec3& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Mat3::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

// Evenly over all orientations (Shoemake 1992).
Mat3 any_rotation(RandomStream& random) {
  const double u = random.uniform(), a = 2 * M_PI * random.uniform(), b = 2 * M_PI * random.uniform();
  return Rotation(std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)).toRotationMatrix();
}

}  // namespace

double mill_volume(const Case& c) {
  if (c.planetary) return c.planetary->vials * volume(*c.planetary);
  if (c.stirred) return volume(*c.stirred);
  return c.mill ? volume(*c.mill) : 0.0;
}

// Listed particles first, since the packed ones make way for them.
std::vector<std::pair<std::string, BodyReport>> insert_particles(const Case& c, Simulation& s) {
  Bodies bodies(c, s);
  double allowed_overlap = 0;
  for (std::size_t k = 0; k < c.inserts.size(); ++k) {
    const InsertCase& insert = c.inserts[k];
    if (insert.method != InsertCase::Method::list) continue;
    RandomStream random(c.seed, 1000 + k);
    for (const InsertCase::Ball& ball : insert.balls) {
      if (insert.agglomerate) {
        bodies.add(*insert.agglomerate, ball.position, rotation_by(insert.turn), ball.velocity, ball.spin);
        continue;
      }
      if (const auto& shape = c.species[insert.species].shape) {
        add_shape(s, c, insert.species, ball.position, ball.diameter > 0 ? held_by(*shape, ball.diameter) : c.species[insert.species].sizes.sample(random), rotation_by(insert.turn), ball.velocity, ball.spin);
        continue;
      }
      const double diameter = ball.diameter > 0 ? ball.diameter : c.species[insert.species].sizes.sample(random);
      add_ball(s, c, insert.species, ball.position, diameter, ball.velocity, ball.spin);
    }
    allowed_overlap = std::max(allowed_overlap, insert.allowed_overlap);
    refuse_overlaps(insert, allowed_overlap, s);
  }
  std::vector<bool> done(c.inserts.size());
  const double reference_volume = mill_volume(c) / (c.planetary ? c.planetary->vials : 1);
  for (std::size_t k = 0; k < c.inserts.size(); ++k) {
    const InsertCase& first = c.inserts[k];
    if (done[k] || first.method == InsertCase::Method::list) continue;
    PackingRequest request;
    request.reference_volume = reference_volume;
    if (c.gravity.norm() > 0) request.gravity = c.gravity;
    request.domain = s.domain;
    std::vector<const InsertCase*> contents;  // by `species` of the packing
    // What goes into the same place in the same way is packed together, so that it mixes.
    for (std::size_t other = k; other < c.inserts.size(); ++other) {
      const InsertCase& insert = c.inserts[other];
      if (done[other] || !same_place(first, insert)) continue;
      done[other] = true;
      contents.push_back(&insert);
      request.portions.push_back(insert.agglomerate ? bodies.portion(insert, request.reference_volume) : portion_of(c, insert, request.reference_volume > 0 ? request.reference_volume : volume(region_of(first, c, 0))));
      request.portions.back().species = static_cast<std::uint8_t>(contents.size() - 1);
    }
    const bool in_vials = c.planetary && first.shape == InsertCase::Shape::mill;
    const Turn disc = in_vials ? turn_at(disc_motion(*c.planetary), 0) : Turn{};
    for (int vial = 0; vial < (in_vials ? c.planetary->vials : 1); ++vial) {
      request.region = region_of(first, c, vial);
      request.present = in_vials ? those_in(*c.planetary, vial, s.particles.position) : s.particles.position;
      request.seed = c.seed + k + 1000 * static_cast<std::uint64_t>(vial);
      try {
        const Packing packing = first.method == InsertCase::Method::rain ? pack_rain(request, s.walls) : pack_dense(request, s.walls);
        if (packing.largest_overlap > tolerated_overlap)
          throw InputError(fmt::format("the packing found leaves overlaps of {:.3g} radii; ask for less, or a larger region", packing.largest_overlap));
        RandomStream random(request.seed, 77);
        for (std::size_t i = 0; i < packing.position.size(); ++i) {
          const Vec3 velocity = first.velocity + disc.speed * disc.axis.cross(packing.position[i] - disc.centre), spin = first.spin + disc.speed * disc.axis;
          const InsertCase& insert = *contents[packing.species[i]];
          if (insert.agglomerate) bodies.add(*insert.agglomerate, packing.position[i], any_rotation(random), velocity, spin);
          else if (c.species[insert.species].shape) add_shape(s, c, insert.species, packing.position[i], packing.diameter[i], any_rotation(random), velocity, spin);
          else add_ball(s, c, insert.species, packing.position[i], packing.diameter[i], velocity, spin);
        }
      } catch (const InputError& e) {
        refuse(first.where, "insert." + first.name, e.what());
      }
    }
  }
  return bodies.reports();
}

}  // namespace quern
