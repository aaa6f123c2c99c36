// Newton's method for eight pairs of shapes that touched a step ago, for one instruction set.
#include <cmath>
#include "shapes/norm_pack.hpp"
#include "src/contact/shape_meeting.hpp"

namespace quern::QUERN_ISA {
namespace {

constexpr double accepted = 1e-5;  // what is left of a step of this size, in places over the size or in the normal, is its square
constexpr double longest = 0.3;    // steps beyond this lead nowhere
constexpr double deepest = 0.05;   // overlap over size; deeper, other sides may count
constexpr int most_looks = 6;

// Exponents of eight bodies; most often all the same, and whole.
struct Exponents {
  alignas(64) double of[lanes];
  bool same, whole;

  explicit Exponents(const Pack& e) {
    store(of, e);
    same = true, whole = of[0] == std::nearbyint(of[0]);
    for (const double one : of) same = same && one == of[0];
  }
  bool all(double e) const { return same && of[0] == e; }
};

double product(double a, int exponent) {
  double result = 1;
  for (; exponent > 0; exponent >>= 1, a *= a)
    if (exponent & 1) result *= a;
  return result;
}

// a^(exponent − less), a ≥ 0. Whole exponents by products, the same whether a lane is alone with its exponent or not.
QUERN_INLINE Pack raised(Pack a, const Exponents& exponents, double less) {
  if (exponents.same && exponents.whole) {
    Pack result(1.0);
    for (int e = static_cast<int>(exponents.of[0] - less); e > 0; e >>= 1, a = a * a)
      if (e & 1) result = result * a;
    return result;
  }
  alignas(64) double lane[lanes];
  store(lane, a);
  for (int k = 0; k < lanes; ++k) {
    const double e = exponents.of[k] - less;
    lane[k] = e == std::nearbyint(e) ? product(lane[k], static_cast<int>(e)) : std::pow(lane[k], e);
  }
  return load(lane);
}

struct Body {
  PackTriple axis[3], inverse;  // 1/semi-axes
  Exponents outer, inner;
  Pack ratio;  // outer/inner
  bool round, plain;  // all exponents 2; outer = inner

  template <class At>
  QUERN_INLINE Body(At&& pose, const QuadPack& exponents) : outer(exponents.x), inner(exponents.y), ratio(exponents.x / exponents.y) {
    Pack companions[3];
    for (int k = 0; k < 3; ++k) {
      const QuadPack row = gather_rows([&](int lane) { return &pose(lane).axis[k].x; });
      axis[k] = row.xyz(), companions[k] = row.w;
    }
    inverse = {companions[0], companions[1], companions[2]};
    round = outer.all(2) && inner.all(2);
    plain = outer.same && inner.same && outer.of[0] == inner.of[0];
  }
  QUERN_INLINE PackTriple fixed(const PackTriple& own) const { return own.x * axis[0] + own.y * axis[1] + own.z * axis[2]; }
  QUERN_INLINE PackTriple own(const PackTriple& fixed) const { return {dot(axis[0], fixed), dot(axis[1], fixed), dot(axis[2], fixed)}; }
};

// F = (|x/a|^n₂ + |y/b|^n₂)^(n₁/n₂) + |z/c|^n₁ − 1 and its derivatives, in a body's own axes.
struct Surface {
  Pack value;
  PackTriple slope;
  PackTriple bend;  // second derivatives: the diagonal
  Pack bend_xy;
};

QUERN_INLINE Surface surface(const Body& body, const PackTriple& place) {
  const PackTriple s = body.inverse, u = {s.x * place.x, s.y * place.y, s.z * place.z};
  const Pack xx = u.x * u.x, yy = u.y * u.y, zz = u.z * u.z, zero(0.0), one(1.0), two(2.0);
  if (body.round) {
    const PackTriple bend = {two * s.x * s.x, two * s.y * s.y, two * s.z * s.z};
    return {xx + yy + zz - one, {bend.x * place.x, bend.y * place.y, bend.z * place.z}, bend, zero};
  }
  const auto size = [&](const Pack& a) { return greater(a, -a); };
  const Pack outer = load(body.outer.of), inner = load(body.inner.of);
  const Pack x = raised(size(u.x), body.inner, 2), y = raised(size(u.y), body.inner, 2), z = raised(size(u.z), body.outer, 2);
  const Pack ring = x * xx + y * yy;
  const PackTriple along = {x * u.x * s.x, y * u.y * s.y, z * u.z * s.z};
  Pack first = outer, second = zero, whole = ring;  // factors of the ring's own derivatives
  if (!body.plain) {
    const Pack safe = greater(ring, Pack(1e-100));
    alignas(64) double lane[lanes], ratio[lanes];
    store(lane, safe), store(ratio, body.ratio);
    for (int k = 0; k < lanes; ++k) lane[k] = ratio[k] == 1 ? 1 : std::pow(lane[k], ratio[k] - 1);
    const Pack power = load(lane);
    first = outer * power, second = outer * (outer - inner) * (power / safe), whole = power * ring;
  }
  const Pack diagonal = first * (inner - one);
  return {whole + z * zz - one,
          {first * along.x, first * along.y, outer * along.z},
          {diagonal * x * s.x * s.x + second * along.x * along.x, diagonal * y * s.y * s.y + second * along.y * along.y, outer * (outer - one) * z * s.z * s.z},
          second * along.x * along.y};
}

struct Two {
  Pack x, y;
};
QUERN_INLINE Pack dot(const Two& a, const Two& b) { return a.x * b.x + a.y * b.y; }

struct Matrix {
  Pack xx, xy, yy;
  QUERN_INLINE Two operator*(const Two& a) const { return {xx * a.x + xy * a.y, xy * a.x + yy * a.y}; }
};

// A body at its place: the outward normal, how far the place is outside, and what bends how.
struct Side {
  PackTriple normal, place;  // fixed axes; the place from the body's centre
  Pack outside, inverse_slope;
  Surface at;
};

QUERN_INLINE Side side(const Body& body, const PackTriple& place) {
  Side s;
  s.at = surface(body, place);
  s.inverse_slope = Pack(1.0) / square_root(dot(s.at.slope, s.at.slope));
  s.normal = body.fixed(s.inverse_slope * s.at.slope);
  s.place = body.fixed(place);
  s.outside = s.at.value * s.inverse_slope;
  return s;
}

QUERN_INLINE Matrix curvature(const Side& side, const PackTriple& t, const PackTriple& u) {
  const auto between = [&](const PackTriple& a, const PackTriple& b) {
    return side.inverse_slope * (side.at.bend.x * a.x * b.x + side.at.bend.y * a.y * b.y + side.at.bend.z * a.z * b.z + side.at.bend_xy * (a.x * b.y + a.y * b.x));
  };
  return {between(t, t), between(t, u), between(u, u)};
}

}  // namespace

void meet_shapes(const PosedShape* poses, const KeptPair* pairs, Index count, Quad* shaped, Meeting* meetings) {
  const Pack zero(0.0), one(1.0), half(0.5);
  for (Index from = 0; from < count; from += lanes) {
    const int used = count - from < lanes ? count - from : lanes;
    const auto pair = [&](int k) -> const KeptPair& { return pairs[from + (k < used ? k : used - 1)]; };
    const auto pose_1 = [&](int k) -> const PosedShape& { return poses[pair(k).first]; };
    const auto pose_2 = [&](int k) -> const PosedShape& { return poses[pair(k).second]; };
    const auto memory = [&](int k, int row) { return shaped + shaped_rows * static_cast<std::ptrdiff_t>(pair(k).slot) + row; };
    const Body a(pose_1, gather_rows([&](int k) { return &pose_1(k).exponents.x; })), b(pose_2, gather_rows([&](int k) { return &pose_2(k).exponents.x; }));
    const QuadPack centre_a = gather_rows([&](int k) { return &pose_1(k).centre.x; }), centre_b = gather_rows([&](int k) { return &pose_2(k).centre.x; });
    const PackTriple apart = centre_b.xyz() - centre_a.xyz();
    const Pack size = lesser(centre_a.w, centre_b.w), inverse_size = one / size;
    PackTriple place_a = gather_rows([&](int k) { return &memory(k, 1)->x; }).xyz(), place_b = gather_rows([&](int k) { return &memory(k, 2)->x; }).xyz();

    PackTriple normal = {zero, zero, zero}, arm = normal;
    Pack overlap = zero;
    unsigned open = 0xffu, answered = 0;
    for (int look = 0; look < most_looks && open != 0; ++look) {
      const Side first = side(a, place_a), second = side(b, place_b);
      // n from the second body to the first: the mean of what the two say, off by as much to either side.
      const PackTriple both = second.normal - first.normal;
      const Pack length = square_root(dot(both, both));
      const PackTriple n = (one / length) * both;
      const Pack sign = select(n.z < zero, Pack(-1.0), one), p = -one / (sign + n.z), q = n.x * n.y * p;
      const PackTriple t = {one + sign * n.x * n.x * p, sign * q, -sign * n.x}, u = {q, sign + n.y * n.y * p, -n.y};
      const PackTriple n_a = a.own(n), t_a = a.own(t), u_a = a.own(u), n_b = b.own(n), t_b = b.own(t), u_b = b.own(u);
      const Matrix bend_a = curvature(first, t_a, u_a), bend_b = curvature(second, t_b, u_b);
      const PackTriple joining = apart + second.place - first.place;
      const Two tilt_a = {-dot(first.normal, t), -dot(first.normal, u)}, tilt_b = {dot(second.normal, t), dot(second.normal, u)};
      const Pack raw = dot(joining, n), now = raw - first.outside - second.outside;
      const Two off = {dot(joining, t) - first.outside * tilt_a.x - second.outside * tilt_b.x, dot(joining, u) - first.outside * tilt_a.y - second.outside * tilt_b.y};
      // tilt_a − K_a x_a = tilt_b + K_b x_b = dn,  off + x_b − x_a = overlap dn.
      const Two shifted = bend_b * Two{off.x - now * tilt_a.x, off.y - now * tilt_a.y};
      const Two right = {tilt_a.x - tilt_b.x + shifted.x, tilt_a.y - tilt_b.y + shifted.y};
      const Two column_x = bend_b * Two{bend_a.xx, bend_a.xy}, column_y = bend_b * Two{bend_a.xy, bend_a.yy};
      const Pack m_xx = bend_a.xx + bend_b.xx - now * column_x.x, m_xy = bend_a.xy + bend_b.xy - now * column_y.x;
      const Pack m_yx = bend_a.xy + bend_b.xy - now * column_x.y, m_yy = bend_a.yy + bend_b.yy - now * column_y.y;
      const Pack determinant = m_xx * m_yy - m_xy * m_yx, inverse = one / determinant;
      const Two step_a = {inverse * (m_yy * right.x - m_xy * right.y), inverse * (m_xx * right.y - m_yx * right.x)};
      const Two turned_a = bend_a * step_a;
      const Two turn = {tilt_a.x - turned_a.x, tilt_a.y - turned_a.y};
      const Two step_b = {step_a.x - off.x + now * turn.x, step_a.y - off.y + now * turn.y};
      const Two turned_b = bend_b * step_b;
      // Along n the places follow their surfaces to second order, and so does the overlap.
      const Pack lift_a = first.outside - dot(tilt_a, step_a) + half * dot(turned_a, step_a), lift_b = -second.outside - dot(tilt_b, step_b) - half * dot(turned_b, step_b);
      const Pack square = dot(turn, turn), steps = greater(dot(step_a, step_a), dot(step_b, step_b)) * (inverse_size * inverse_size);
      const Pack largest = greater(square + dot(tilt_a, tilt_a), steps + (off.x * off.x + off.y * off.y) * (inverse_size * inverse_size));
      const Pack found = raw + lift_b - lift_a + half * now * square;
      const Mask sound = (determinant > zero) & (m_xx + m_yy > zero) & (largest < Pack(longest * longest)) & (found < Pack(deepest) * size);
      const unsigned going = bits(sound) & open, done = bits(sound & (largest < Pack(accepted * accepted))) & open;
      if (going == 0) {
        open = 0;
        break;
      }
      alignas(64) double moves[lanes];
      for (int k = 0; k < lanes; ++k) moves[k] = going >> k & 1u ? 1 : 0;
      const Mask move = load(moves) > half;
      const PackTriple new_a = place_a + step_a.x * t_a + step_a.y * u_a + lift_a * n_a, new_b = place_b + step_b.x * t_b + step_b.y * u_b + lift_b * n_b;
      const auto chosen = [&](const Mask& m, const PackTriple& yes, const PackTriple& no) -> PackTriple { return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)}; };
      place_a = chosen(move, new_a, place_a), place_b = chosen(move, new_b, place_b);
      if (done != 0) {
        for (int k = 0; k < lanes; ++k) moves[k] = done >> k & 1u ? 1 : 0;
        const Mask ends = load(moves) > half;
        const PackTriple turned = n + turn.x * t + turn.y * u;
        normal = chosen(ends, (one / square_root(one + square)) * turned, normal);
        const PackTriple moved_a = first.place + step_a.x * t + step_a.y * u + lift_a * n, moved_b = apart + second.place + step_b.x * t + step_b.y * u + lift_b * n;
        arm = chosen(ends, half * (moved_a + moved_b), arm);
        overlap = select(ends, found, overlap);
      }
      answered |= done;
      open = going & ~done;
    }

    alignas(64) Quad scratch;
    alignas(64) Quad normals[lanes], arms[lanes];
    alignas(64) double flags[lanes];
    for (int k = 0; k < lanes; ++k) flags[k] = answered >> k & 1u ? 1 : 0;
    scatter_rows({normal.x, normal.y, normal.z, overlap}, [&](int k) { return &normals[k].x; });
    scatter_rows({arm.x, arm.y, arm.z, load(flags)}, [&](int k) { return &arms[k].x; });
    const auto keep = [&](int k, int row) { return k < used && (answered >> k & 1u) ? memory(k, row) : &scratch; };
    scatter_rows({place_a.x, place_a.y, place_a.z, zero}, [&](int k) { return &keep(k, 1)->x; });
    scatter_rows({place_b.x, place_b.y, place_b.z, zero}, [&](int k) { return &keep(k, 2)->x; });
    for (int k = 0; k < used; ++k) meetings[from + k] = {normals[k], arms[k]};
  }
}

void find_gaps(const PosedShape* poses, const ParallelPlanes* pairs, Index count, Gap* gaps) {
  const Pack one(1.0), zero(0.0);
  for (Index from = 0; from < count; from += lanes) {
    const int used = count - from < lanes ? count - from : lanes;
    const auto pair = [&](int k) -> const ParallelPlanes& { return pairs[from + (k < used ? k : used - 1)]; };
    const PackTriple n = gather_rows([&](int k) { return &pair(k).normal.x; }).xyz();
    // How far a body's farthest place along n is from its centre, and how far that is from the origin.
    struct Reach {
      NormPack::First own;
      Pack centre;
    };
    const auto reach = [&](auto&& pose) __attribute__((always_inline)) -> Reach {
      const QuadPack x = gather_rows([&](int k) { return &pose(k).axis[0].x; }), y = gather_rows([&](int k) { return &pose(k).axis[1].x; });
      const QuadPack z = gather_rows([&](int k) { return &pose(k).axis[2].x; }), e = gather_rows([&](int k) { return &pose(k).exponents.x; });
      const NormPack support({one / x.w, one / y.w, one / z.w}, e.x / (e.x - one), e.y / (e.y - one));
      return {support.first({dot(x.xyz(), n), dot(y.xyz(), n), dot(z.xyz(), n)}), dot(n, gather_rows([&](int k) { return &pose(k).centre.x; }).xyz())};
    };
    const Reach a = reach([&](int k) -> const PosedShape& { return poses[pair(k).first]; }), b = reach([&](int k) -> const PosedShape& { return poses[pair(k).second]; });
    const PackTriple &ga = a.own.gradient, &gb = b.own.gradient;
    alignas(64) Quad scratch;
    scatter_rows({-ga.x, -ga.y, -ga.z, (a.centre - b.centre) - (a.own.value + b.own.value)}, [&](int k) { return k < used ? &gaps[from + k].first.x : &scratch.x; });
    scatter_rows({gb.x, gb.y, gb.z, zero}, [&](int k) { return k < used ? &gaps[from + k].second.x : &scratch.x; });
  }
}

}  // namespace quern::QUERN_ISA
