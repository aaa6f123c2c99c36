#include "src/particle/turning.hpp"
#include <cmath>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

Rotation rotation(const Quad& q) { return {q.w, q.x, q.y, q.z}; }

}  // namespace

Rotation turned_freely(const Rotation& orientation, const Vec3& momentum, const Vec3& moments, double time) {
  Vec3 own = orientation.conjugate() * momentum;
  Rotation q = orientation;
  const auto turn = [&](int axis, double share) {
    const double angle = share * time * own[axis] / moments[axis], cosine = std::cos(angle), sine = std::sin(angle);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    // The body turns forwards, so that the momentum, which stays, turns backwards in its axes.
    const double along_u = own[u], along_v = own[v];
    own[u] = cosine * along_u + sine * along_v;
    own[v] = cosine * along_v - sine * along_u;
    Rotation by(std::cos(0.5 * angle), 0, 0, 0);
    by.vec()[axis] = std::sin(0.5 * angle);
    q = q * by;
  };
  turn(2, 0.5), turn(1, 0.5), turn(0, 1), turn(1, 0.5), turn(2, 0.5);
  q.normalize();
  return q;
}

Vec3 spin_of(const Rotation& orientation, const Vec3& momentum, const Vec3& moments) {
  const Vec3 own = orientation.conjugate() * momentum;
  return orientation * own.cwiseQuotient(moments);
}

void turn_shapes(Particles& p, Index first, Index last, const Quad* before, double time_step) {
  for (Index i = first; i < last; ++i) {
    if (p.shape[at(i)] == 0) continue;
    const Vec3 torque = vec(p.angular_acceleration[at(i)]), momentum = vec(p.momentum[at(i)]);
    const Rotation q = turned_freely(rotation(before[i - first]), momentum + 0.5 * time_step * torque, vec(p.inertia[at(i)]), time_step);
    p.orientation[at(i)] = {q.x(), q.y(), q.z(), q.w()};
    set(p.momentum[at(i)], momentum + time_step * torque);
  }
  set_spins(p, first, last);
}

void correct_momenta(Particles& p, Index first, Index last, const Torques& torques, double time_step) {
  for (Index i = first; i < last; ++i) {
    if (p.shape[at(i)] == 0) continue;
    const double* torque = torques.first + torques.stride * (i - first);
    add(p.momentum[at(i)], 0.5 * time_step * (Vec3(torque[0], torque[1], torque[2]) - vec(p.angular_acceleration[at(i)])));
  }
}

void set_spins(Particles& p, Index first, Index last) {
  for (Index i = first; i < last; ++i)
    if (p.shape[at(i)] != 0) set(p.spin[at(i)], spin_of(rotation(p.orientation[at(i)]), vec(p.momentum[at(i)]), vec(p.inertia[at(i)])));
}

void set_spin(Particles& p, Index row, const Vec3& spin) {
  const Rotation q = rotation(p.orientation[at(row)]);
  const Vec3 own = q.conjugate() * spin;
  set(p.momentum[at(row)], q * own.cwiseProduct(vec(p.inertia[at(row)])));
  set(p.spin[at(row)], spin);
}

}  // namespace quern
