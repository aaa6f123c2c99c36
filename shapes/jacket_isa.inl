// Where a body touches the inside of a cylinder, for one instruction set: climbs from eight directions at once.
#include <cmath>
#include "shapes/jacket.hpp"
#include "shapes/norm_pack.hpp"

namespace quern::QUERN_ISA {
namespace {

// How far the body reaches along directions (c, s), which is how far its farthest place there is from a plane through the axis, and the derivatives of that with the direction's angle.
struct Reaches {
  Pack c, s;
  Pack r, t;  // of the place [m]
  PackTriple place;  // in the body's own axes and size
  Pack value, slope, bend;
  Pack along, across, rise;  // Hessian: along a growing angle, with the axis, along the axis [m]
};

struct Seen {
  NormPack norm;
  PackTriple r, t, z;  // those directions in the body's own axes
  Pack size, off;

  QUERN_INLINE Reaches reach(const Pack& c, const Pack& s) const {
    const PackTriple turning = c * t - s * r;
    const NormPack::Second at = norm.second(c * r + s * t);
    Reaches found;
    found.c = c, found.s = s, found.place = at.gradient;
    found.r = off + size * dot(at.gradient, r), found.t = size * dot(at.gradient, t);
    found.value = c * found.r + s * found.t, found.slope = c * found.t - s * found.r;
    found.along = size * at.bend(turning, turning), found.across = size * at.bend(turning, z), found.rise = size * at.bend(z, z);
    found.bend = found.along - found.value;
    return found;
  }
  QUERN_INLINE Reaches towards(const Pack& r_part, const Pack& t_part) const {
    const Pack inverse = Pack(1.0) / square_root(r_part * r_part + t_part * t_part);
    return reach(inverse * r_part, inverse * t_part);
  }
};

QUERN_INLINE PackTriple all(const Triple<double>& v) { return {Pack(v.x), Pack(v.y), Pack(v.z)}; }
QUERN_INLINE Pack size_of(const Pack& a) { return greater(a, -a); }
QUERN_INLINE Mask mask_of(unsigned bit) {
  alignas(64) double lane[lanes];
  for (int k = 0; k < lanes; ++k) lane[k] = bit >> k & 1u ? 1 : 0;
  return load(lane) > Pack(0.5);
}
QUERN_INLINE void take(const Mask& m, const Reaches& next, Reaches& at) {
  const auto one = [&](const Pack& fresh, Pack& old) { old = select(m, fresh, old); };
  one(next.c, at.c), one(next.s, at.s), one(next.r, at.r), one(next.t, at.t);
  one(next.place.x, at.place.x), one(next.place.y, at.place.y), one(next.place.z, at.place.z);
  one(next.value, at.value), one(next.slope, at.slope), one(next.bend, at.bend);
  one(next.along, at.along), one(next.across, at.across), one(next.rise, at.rise);
}

// Sines of −π/2, −5π/14 … π/2; their cosines are their mirror's, by parts of π/7.
constexpr double part_sine = 0.43388373911755812, part_cosine = 0.90096886790241913;
constexpr double start_cosine[lanes] = {0, 0.43388373911755812, 0.78183148246802981, 0.97492791218182361, 0.97492791218182361, 0.78183148246802981, 0.43388373911755812, 0};
constexpr double start_sine[lanes] = {-1, -0.90096886790241913, -0.62348980185873353, -0.22252093395631440, 0.22252093395631440, 0.62348980185873353, 0.90096886790241913, 1};

// Bit k: near start k a place may be as far as the radius. Between the normals of two starts lies what is within their places and the corner
// of their tangents, and beyond a right angle from the direction to the centre no place is farther than those around it.
unsigned within_reach(const Reaches& starts, double radius) {
  alignas(64) double value[lanes], place[lanes];
  store(value, starts.value), store(place, starts.r * starts.r + starts.t * starts.t);
  unsigned bit = 0;
  for (int k = 1; k < lanes; ++k) {
    const double a = value[k - 1], b = value[k], corner = (a * a + b * b - 2 * part_cosine * a * b) / (part_sine * part_sine);
    if (quern::greater(corner, quern::greater(place[k - 1], place[k])) >= (1 - 1e-12) * radius * radius) bit |= 3u << (k - 1);
  }
  return bit;
}

}  // namespace

bool find_far_places(const BodyInJacket& body, double radius, FarPlaces& places) {
  constexpr int most_steps = 60;
  const Seen seen{{all(body.scale), Pack(body.outer), Pack(body.inner)}, all(body.r), all(body.t), all(body.z), Pack(body.size), Pack(body.off)};
  Reaches at = seen.reach(load(start_cosine), load(start_sine));
  const unsigned possible = within_reach(at, radius);
  if (possible == 0) return false;
  // A body's edges lie in all directions of it; seen from the axis they lie within the angle beyond which the ball about the body does not reach the jacket.
  const double window = (radius * radius + body.off * body.off - body.bounding_radius * body.bounding_radius) / (2 * radius * body.off);
  const double cosine = quern::greater(-1.0, quern::lesser(1.0, window)), sine = std::sqrt(1 - cosine * cosine);
  const Mask beyond = at.r < Pack(cosine) * square_root(at.r * at.r + at.t * at.t);
  at = seen.towards(select(beyond, Pack(cosine), at.r), select(beyond, select(at.t < Pack(0.0), Pack(-sine), Pack(sine)), at.t));
  // Climbs to places farther from the axis than all beside them: Newton's method where the reach is concave, else the direction of the
  // farthest place itself, which always climbs.
  const Pack tight(1e-12 * body.length), loose(1e-6 * body.length);
  unsigned plainly = 0;
  for (int k = 0; k < most_steps; ++k) {
    // What a last step of the place along the surface brings nearly to zero is left to it.
    const unsigned open = possible & bits(size_of(at.slope) > tight) & ~(bits(size_of(at.slope) < loose) & bits(size_of(at.along * at.slope) < size_of(loose * at.bend)));
    if (open == 0) break;
    const unsigned concave = bits(at.bend < Pack(-0.01) * at.value) & ~plainly;
    const Mask newton = mask_of(concave);
    const Pack turn = select(newton, -at.slope / at.bend, Pack(0.0));
    const Reaches next = seen.towards(select(newton, at.c - turn * at.s, at.r), select(newton, at.s + turn * at.c, at.t));
    const unsigned better = bits(next.value > at.value) | bits(size_of(next.slope) < Pack(0.5) * size_of(at.slope)) | ~concave;
    take(mask_of(open & better), next, at);
    plainly = open & ~better;
  }
  const Pack last = select(at.bend < Pack(-0.01) * at.value, -at.slope / at.bend, Pack(0.0)), turn_along = last * at.along, turn_rise = last * at.across;
  at.place = at.place + Pack(1 / body.size) * (turn_along * (at.c * seen.t - at.s * seen.r) + turn_rise * seen.z);
  at.value = at.value + Pack(0.5) * last * at.slope;
  at.slope = at.slope + last * at.bend;
  const Pack c = at.c - last * at.s, s = at.s + last * at.c;
  at.c = c, at.s = s;
  store(places.c, at.c), store(places.s, at.s), store(places.x, at.place.x), store(places.y, at.place.y), store(places.z, at.place.z);
  store(places.distance, select(mask_of(possible), at.value, Pack(-1.0))), store(places.slope, at.slope);
  store(places.along, at.along), store(places.across, at.across), store(places.rise, at.rise);
  return true;
}

}  // namespace quern::QUERN_ISA
