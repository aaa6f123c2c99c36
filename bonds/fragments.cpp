#include "bonds/fragments.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// Rounds amounts so that any sum of them is exact.
class ExactUnit {
 public:
  // `whole`: about the sum of all amounts, more than 0. Their sum is less than twice the next power of two, 2⁵³ units.
  explicit ExactUnit(double whole) : unit_(std::ldexp(1.0, std::ilogb(whole) + 2 - 53)) {}
  double rounded(double amount) const { return std::nearbyint(amount / unit_) * unit_; }

 private:
  double unit_;
};

double volume_of(double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; }

// Grains in the order of their ids, and which of them bonds tie together.
struct Grains {
  std::vector<std::size_t> row;         // of each grain
  std::vector<std::size_t> first_tie;   // where its ties begin in `tied`; one more at the end
  std::vector<std::size_t> tied;        // grains
  std::vector<std::size_t> body;        // the least grain of the body
};

Grains grains_of(const Bonds& bonds, const Particles& particles) {
  Index most = -1;
  for (const Bond& bond : bonds.list) most = std::max(most, bond.second);
  std::vector<Index> row_of(at(most + 1), -1);
  for (Index row = 0; row < particles.owned; ++row)
    if (particles.id[at(row)] <= most) row_of[at(particles.id[at(row)])] = row;
  std::vector<Index> grain_of(row_of.size(), -1);
  for (const Bond& bond : bonds.list)
    for (const Index id : {bond.first, bond.second})
      if (row_of[at(id)] >= 0) grain_of[at(id)] = 0;
  Grains grains;
  for (std::size_t id = 0; id < grain_of.size(); ++id) {
    if (grain_of[id] < 0) continue;
    grain_of[id] = static_cast<Index>(grains.row.size());
    grains.row.push_back(at(row_of[id]));
  }
  // Every bond, broken or not, is a tie: which bodies there were is told by all of them.
  grains.first_tie.assign(grains.row.size() + 1, 0);
  const auto each_tie = [&](bool broken_too, auto&& take) {
    for (const Bond& bond : bonds.list) {
      const Index a = grain_of[at(bond.first)], b = grain_of[at(bond.second)];
      if (a >= 0 && b >= 0 && (broken_too || bond.state == BondState::intact)) take(at(a), at(b));
    }
  };
  grains.body.resize(grains.row.size());
  std::iota(grains.body.begin(), grains.body.end(), std::size_t{0});
  const auto least = [&](std::size_t k) {
    while (grains.body[k] != k) k = grains.body[k] = grains.body[grains.body[k]];
    return k;
  };
  each_tie(true, [&](std::size_t a, std::size_t b) {
    a = least(a), b = least(b);
    grains.body[std::max(a, b)] = std::min(a, b);
  });
  for (std::size_t& body : grains.body) body = least(body);
  each_tie(false, [&](std::size_t a, std::size_t b) { ++grains.first_tie[a + 1], ++grains.first_tie[b + 1]; });
  std::partial_sum(grains.first_tie.begin(), grains.first_tie.end(), grains.first_tie.begin());
  std::vector<std::size_t> next(grains.first_tie.begin(), grains.first_tie.end() - 1);
  grains.tied.resize(grains.first_tie.back());
  each_tie(false, [&](std::size_t a, std::size_t b) { grains.tied[next[a]++] = b, grains.tied[next[b]++] = a; });
  return grains;
}

Fragments collected(const Grains& grains, const std::vector<std::vector<std::size_t>>& pieces, const std::vector<Triple<double>>& places,
                    const Particles& particles) {
  Fragments all;
  if (pieces.empty()) return all;
  double whole_mass = 0, whole_volume = 0;
  for (const std::size_t row : grains.row) whole_mass += particles.velocity[row].w, whole_volume += volume_of(particles.position[row].w);
  const ExactUnit mass_unit(whole_mass), volume_unit(whole_volume);

  std::vector<Fragment> found;
  for (const std::vector<std::size_t>& piece : pieces) {
    Fragment f{particles.id[grains.row[piece.front()]], particles.id[grains.row[grains.body[piece.front()]]], static_cast<Index>(piece.size()),
               0, 0, {0, 0, 0}, {0, 0, 0}};
    double weight = 0;  // mass as it enters the means
    for (const std::size_t grain : piece) {
      const std::size_t row = grains.row[grain];
      const double mass = particles.velocity[row].w;
      f.mass += mass_unit.rounded(mass);
      f.volume += volume_unit.rounded(volume_of(particles.position[row].w));
      weight += mass;
      f.centre = f.centre + mass * places[grain];
      f.velocity = f.velocity + mass * xyz(particles.velocity[row]);
    }
    f.centre = (1 / weight) * f.centre, f.velocity = (1 / weight) * f.velocity;
    all.mass += f.mass, all.volume += f.volume;
    found.push_back(f);
  }

  std::vector<std::size_t> order(found.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return found[a].mass != found[b].mass ? found[a].mass > found[b].mass : found[a].id < found[b].id;
  });
  all.of_row.assign(static_cast<std::size_t>(particles.size()), -1);
  all.places.assign(all.of_row.size(), {0, 0, 0});
  for (const std::size_t k : order) {
    std::vector<Index> rows;
    for (const std::size_t grain : pieces[k]) {
      const std::size_t row = grains.row[grain];
      rows.push_back(static_cast<Index>(row));
      all.of_row[row] = static_cast<Index>(all.list.size());
      all.places[row] = places[grain];
    }
    all.members.push_back(std::move(rows));
    all.list.push_back(found[k]);
  }
  return all;
}

}  // namespace

Fragments find_fragments(const Bonds& bonds, const Particles& particles, const Domain& domain) {
  const Grains grains = grains_of(bonds, particles);
  const std::size_t count = grains.row.size();
  std::vector<Triple<double>> places(count);
  std::vector<std::vector<std::size_t>> pieces;
  std::vector<bool> seen(count, false);
  for (std::size_t start = 0; start < count; ++start) {
    if (seen[start]) continue;
    std::vector<std::size_t> piece{start};
    seen[start] = true;
    places[start] = xyz(particles.position[grains.row[start]]);
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const std::size_t grain = piece[k];
      for (std::size_t t = grains.first_tie[grain]; t < grains.first_tie[grain + 1]; ++t) {
        const std::size_t other = grains.tied[t];
        if (seen[other]) continue;
        seen[other] = true;
        // Bonds are shorter than half a period, so that the nearest image is the one that is tied.
        const Triple<double> apart = xyz(particles.position[grains.row[other]]) - xyz(particles.position[grains.row[grain]]);
        places[other] = domain.periodic() ? places[grain] + domain.nearest(apart) : xyz(particles.position[grains.row[other]]);
        piece.push_back(other);
      }
    }
    std::sort(piece.begin(), piece.end());
    pieces.push_back(std::move(piece));
  }
  return collected(grains, pieces, places, particles);
}

Fragments find_bodies(const Bonds& bonds, const Particles& particles, const Domain& domain) {
  Bonds whole;
  whole.list = bonds.list;
  for (Bond& bond : whole.list) bond.state = BondState::intact;
  return find_fragments(whole, particles, domain);
}

double sieve_size(const Fragments& fragments, std::size_t fragment, const Particles& particles) {
  std::vector<Quad> spheres;
  for (const Index row : fragments.members[fragment]) {
    const Triple<double>& place = fragments.places[at(row)];
    spheres.push_back({place.x, place.y, place.z, particles.radius(row)});
  }
  return smallest_square_opening(spheres);
}

}  // namespace quern
