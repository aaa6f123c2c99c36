// Where a body touches the inside of a cylinder, for one instruction set. Directions go by the tangent of half their angle from r.
#include <cmath>
#include "shapes/jacket.hpp"
#include "shapes/norm_pack.hpp"

namespace quern::QUERN_ISA {
namespace {

QUERN_INLINE PackTriple all(const Triple<double>& v) { return {Pack(v.x), Pack(v.y), Pack(v.z)}; }
QUERN_INLINE Pack size_of(const Pack& a) { return greater(a, -a); }

struct Directions {
  Pack c, s;
  QUERN_INLINE explicit Directions(const Pack& tangent) {
    const Pack square = tangent * tangent, inverse = Pack(1.0) / (Pack(1.0) + square);
    c = (Pack(1.0) - square) * inverse, s = Pack(2.0) * tangent * inverse;
  }
};

// How far the body reaches along directions, which is how far its farthest place there is from a plane through the axis, and the
// derivatives of that with the angle.
struct Reaches {
  PackTriple place;  // in the body's own axes and size
  Pack r, t;         // of the place [m]
  Pack value, slope;
};
struct Bends {
  Pack along, across, rise;  // Hessian of the reach: along a growing angle, with the axis, along the axis [m]
};

struct Seen {
  NormPack norm;
  PackTriple r, t, z;  // those directions in the body's own axes
  Pack size, off;

  QUERN_INLINE explicit Seen(const BodyInJacket& body)
      : norm(all(body.scale), Pack(body.outer), Pack(body.inner)), r(all(body.r)), t(all(body.t)), z(all(body.z)), size(body.size), off(body.off) {}
  QUERN_INLINE PackTriple own(const Directions& n) const { return n.c * r + n.s * t; }
  QUERN_INLINE Reaches reaches(const Directions& n, const PackTriple& place) const {
    const Pack along_r = off + size * dot(place, r), along_t = size * dot(place, t);
    return {place, along_r, along_t, n.c * along_r + n.s * along_t, n.c * along_t - n.s * along_r};
  }
  QUERN_INLINE Bends bends(const Directions& n, const NormPack::Second& at) const {
    const PackTriple turning = n.c * t - n.s * r;
    return {size * at.bend(turning, turning), size * at.bend(turning, z), size * at.bend(z, z)};
  }
};

// The tangent of half the angle of a place.
QUERN_INLINE Pack tangent_of(const Reaches& at) { return at.t / (at.r + square_root(at.r * at.r + at.t * at.t)); }

struct Interval {
  double low, high;
  double first;  // where to begin to look for its top
};

struct Search {
  static constexpr int room = 128;
  Interval open[room], top[most_tops];
  int open_count = 0, top_count = 0;
  double farthest = 0;  // of places in what was left out, squared [m²]
  double radius, narrow, extent;  // [m], of an interval, of the distance of any place [m]
};

// Divides one interval by eight places or two by four, and keeps what may hold a top.
QUERN_INLINE void divide(const Seen& seen, Search& search) {
  constexpr double rounding = 4e-16;
  alignas(64) double tangents[lanes], c[lanes + 1], s[lanes + 1], r[lanes + 1], t[lanes + 1], value[lanes + 1], slope[lanes + 1], at[lanes + 1], own[lanes + 1];
  const int taken = search.open_count > 1 ? 2 : 1, each = lanes / taken;
  for (int k = 0; k < lanes; ++k) {
    const Interval& i = search.open[search.open_count - 1 - k / each];
    tangents[k] = k % each == each - 1 ? i.high : i.low + (i.high - i.low) * (k % each) / (each - 1);
  }
  search.open_count -= taken;
  const Pack tangent = load(tangents);
  const Directions n(tangent);
  const Reaches reached = seen.reaches(n, seen.norm.first(seen.own(n)).gradient);
  const auto keep = [](double* to, const Pack& what) { store(to, what), to[lanes] = to[lanes - 1]; };
  keep(c, n.c), keep(s, n.s), keep(r, reached.r), keep(t, reached.t), keep(value, reached.value), keep(slope, reached.slope), keep(at, tangent), keep(own, tangent_of(reached));
  const auto next = [](const double* from) { return load(from + 1); };
  // The corner of the tangents at both ends.
  const Pack sine = next(s) * n.c - next(c) * n.s, along = greater(next(value) - (next(c) * reached.r + next(s) * reached.t), Pack(0.0)) / sine;
  const auto square = [](const Pack& x, const Pack& y) { return x * x + y * y; };
  const Pack here = square(reached.r, reached.t), corner = here + along * (Pack(2.0) * reached.slope + along);
  const Pack farthest = greater(corner, greater(here, square(next(r), next(t))));
  // That ψ grows with θ is certain only where the axis lies behind the outline.
  const Mask ahead = lesser(reached.value, next(value)) > Pack(search.extent) * (next(at) - tangent);
  const Pack low = greater(tangent, select(ahead, load(own) - Pack(rounding), tangent)), high = lesser(next(at), select(ahead, next(own) + Pack(rounding), next(at)));
  const unsigned empty = bits(low > high), certain = ~bits(reached.slope < Pack(0.0)) & bits(next(slope) < Pack(0.0)), thin = bits(high - low < Pack(search.narrow)), far = bits(farthest > Pack((1 - 1e-9) * search.radius * search.radius));
  alignas(64) double lows[lanes], highs[lanes], squares[lanes];
  store(lows, low), store(highs, high), store(squares, farthest);
  for (int k = 0; k < lanes; ++k) {
    if (k % each == each - 1 || empty >> k & 1u) continue;
    const bool is_thin = thin >> k & 1u, holds_top = certain >> k & 1u;
    if (!(far >> k & 1u) || (is_thin && !holds_top)) {
      search.farthest = quern::greater(search.farthest, squares[k]);
    } else if (is_thin) {
      if (search.top_count == most_tops) continue;
      // Where the chord of ψ − θ is zero.
      const double before = own[k] - at[k], after = at[k + 1] - own[k + 1];
      const double chord = before + after > 0 ? at[k] + (at[k + 1] - at[k]) * (before / (before + after)) : at[k];
      search.top[search.top_count++] = {lows[k], highs[k], quern::greater(lows[k], quern::lesser(highs[k], chord))};
    } else if (search.open_count < Search::room) {
      search.open[search.open_count++] = {lows[k], highs[k], 0};
    }
  }
}

// Newton's method within each top's interval, all at once. What a last step brings to zero is added to what is told.
QUERN_INLINE void climb(const Seen& seen, const BodyInJacket& body, const Search& search, FarPlaces& places, double* distance) {
  constexpr int most_steps = 60;
  alignas(64) double first[lanes], lows[lanes], highs[lanes];
  for (int k = 0; k < lanes; ++k) {
    const Interval& i = search.top[k < search.top_count ? k : 0];
    first[k] = i.first, lows[k] = i.low, highs[k] = i.high;
  }
  Pack tangent = load(first), low = load(lows), high = load(highs);
  const Pack zero(0.0), half(0.5), one(1.0), tight(1e-7 * body.length);
  for (int k = 0;; ++k) {
    const Directions n(tangent);
    const NormPack::Second at = seen.norm.second(seen.own(n));
    const Reaches reached = seen.reaches(n, at.gradient);
    const Bends bends = seen.bends(n, at);
    const Pack bend = bends.along - reached.value;
    const Mask concave = bend < zero;
    const Pack turn = select(concave, -reached.slope / bend, zero), moved = greater(size_of(turn * bends.along), size_of(turn * bends.across));
    const unsigned done = bits(concave & (moved < tight) & (size_of(reached.slope) < tight)) | bits(high - low < Pack(1e-15));
    if (done == (1u << lanes) - 1u || k == most_steps) {
      const Pack last = select(concave & (moved < tight), turn, zero);
      const PackTriple place = at.gradient + (one / seen.size) * (last * bends.along * (n.c * seen.t - n.s * seen.r) + last * bends.across * seen.z);
      const Directions turned(tangent + half * last * (one + tangent * tangent));
      store(places.c, turned.c), store(places.s, turned.s), store(places.x, place.x), store(places.y, place.y), store(places.z, place.z);
      store(distance, reached.value + half * last * reached.slope), store(places.slope, reached.slope + last * bend);
      store(places.along, bends.along), store(places.across, bends.across), store(places.rise, bends.rise);
      return;
    }
    const Mask before = reached.slope > zero;
    low = select(before, tangent, low), high = select(before, high, tangent);
    const Pack newton = tangent + half * turn * (one + tangent * tangent);
    tangent = select(concave & (newton > low) & (newton < high), newton, half * (low + high));
  }
}

}  // namespace

void find_far_places(const BodyInJacket& body, double radius, double widest, FarPlaces& places) {
  const Seen seen(body);
  Search search;
  search.radius = radius, search.extent = std::abs(body.off) + body.bounding_radius;
  // Two tops, 2β apart, stand out against the lowest place between them by at most R β²/2.
  search.narrow = 0.5 * std::sqrt(2e-6 * body.length / radius);
  search.open[search.open_count++] = {-widest, widest, 0};
  while (search.open_count > 0) divide(seen, search);
  double farthest = std::sqrt(search.farthest);
  places.count = 0;
  if (search.top_count > 0) {
    alignas(64) double distance[lanes];
    climb(seen, body, search, places, distance);
    for (int k = 0; k < search.top_count; ++k) {
      if (distance[k] < radius) {
        farthest = quern::greater(farthest, distance[k]);
        continue;
      }
      // Of those that lie so close that nothing between them can be much nearer to the axis, the farthest.
      int to = 0;
      while (to < places.count && std::abs(places.s[k] * places.c[to] - places.c[k] * places.s[to]) > 4 * search.narrow) ++to;
      if (to < places.count && places.distance[to] >= distance[k]) continue;
      if (to == places.count) ++places.count;
      places.distance[to] = distance[k];
      const auto move = [&](double* of) { of[to] = of[k]; };
      move(places.c), move(places.s), move(places.x), move(places.y), move(places.z), move(places.slope), move(places.along), move(places.across), move(places.rise);
    }
  }
  places.gap = radius - farthest;
}

}  // namespace quern::QUERN_ISA
