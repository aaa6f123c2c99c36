#include "src/particle/turning.hpp"
#include <array>
#include <cmath>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// By their series where an angle is as small as a step's.
std::array<double, 2> sine_and_cosine(double angle) {
  const double s = angle * angle;
  if (s > 0.01) return {std::sin(angle), std::cos(angle)};
  return {angle * (1 + s * (-1.0 / 6 + s * (1.0 / 120 + s * (-1.0 / 5040 + s * (1.0 / 362880 - s * (1.0 / 39916800)))))),
          1 + s * (-1.0 / 2 + s * (1.0 / 24 + s * (-1.0 / 720 + s * (1.0 / 40320 - s * (1.0 / 3628800)))))};
}

}  // namespace

Rotation turned_freely(const Rotation& orientation, const Vec3& momentum, const Vec3& moments, double time) {
  Vec3 own = orientation.conjugate() * momentum;
  Rotation q = orientation;
  const Vec3 rates = time * moments.cwiseInverse();
  const auto turn = [&](int axis, double share) {
    const auto [half_sine, half_cosine] = sine_and_cosine(0.5 * share * rates[axis] * own[axis]);
    const double cosine = 1 - 2 * half_sine * half_sine, sine = 2 * half_sine * half_cosine;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    // The body turns forwards, so that the momentum, which stays, turns backwards in its axes.
    const double along_u = own[u], along_v = own[v];
    own[u] = cosine * along_u + sine * along_v;
    own[v] = cosine * along_v - sine * along_u;
    // q times the turn about that axis.
    const double w = q.w(), along = q.vec()[axis], x = q.vec()[u], y = q.vec()[v];
    q.w() = half_cosine * w - half_sine * along;
    q.vec()[axis] = half_cosine * along + half_sine * w;
    q.vec()[u] = half_cosine * x + half_sine * y;
    q.vec()[v] = half_cosine * y - half_sine * x;
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
    const double moved = time_step * (vec(p.velocity[at(i)]) - 0.5 * time_step * vec(p.acceleration[at(i)])).norm();  // `advance` has predicted already
    if (p.shape[at(i)] == 0) {
      p.momentum[at(i)].w += moved;
      continue;
    }
    const Rotation old = rotation_of(before[i - first]);
    const Vec3 torque = vec(p.angular_acceleration[at(i)]), momentum = vec(p.momentum[at(i)]);
    const Rotation q = turned_freely(old, momentum + 0.5 * time_step * torque, vec(p.inertia[at(i)]), time_step);
    p.orientation[at(i)] = {q.x(), q.y(), q.z(), q.w()};
    set(p.momentum[at(i)], momentum + time_step * torque);
    p.momentum[at(i)].w += moved + 2 * p.position[at(i)].w * (q.coeffs() - old.coeffs()).norm();
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
    if (p.shape[at(i)] != 0) set(p.spin[at(i)], spin_of(rotation_of(p.orientation[at(i)]), vec(p.momentum[at(i)]), vec(p.inertia[at(i)])));
}

void set_spin(Particles& p, Index row, const Vec3& spin) {
  const Rotation q = rotation_of(p.orientation[at(row)]);
  const Vec3 own = q.conjugate() * spin;
  set(p.momentum[at(row)], q * own.cwiseProduct(vec(p.inertia[at(row)])));
  set(p.spin[at(row)], spin);
}

}  // namespace quern
