#include "src/observe/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "src/observe/block_average.hpp"

namespace quern {

namespace {

constexpr std::size_t histogram_at(std::size_t kind, ContactClass c, EnergyMeasure m) {
  return (kind * contact_classes + static_cast<std::size_t>(c)) * energy_measures + static_cast<std::size_t>(m);
}

auto key_of(const EarlierLoss& e) { return std::make_tuple(e.first_id, e.second_id, e.start_time); }
// Which of two particles comes first changes when they are sorted in space; a wall is always second.
EarlierLoss as_earlier(const Collision& c) {
  const bool swap = c.second_id >= 0 && c.second_id < c.first_id;
  return {swap ? c.second_id : c.first_id, swap ? c.first_id : c.second_id, c.record.start_time, c.record.normal_loss, c.record.tangential_loss};
}

template <class T>
void add_each(std::vector<T>& sums, const std::vector<T>& more) {
  if (sums.size() < more.size()) sums.resize(more.size());
  for (std::size_t k = 0; k < more.size(); ++k) sums[k].add(more[k]);
}

}  // namespace

double first_span(const ObserverSettings& settings, double time_step) {
  const double speed = settings.planetary ? settings.planetary->speed : settings.mill ? settings.mill->speed : 0;
  return speed != 0 ? 6.283185307179586 / std::abs(speed) / 20 : 100 * time_step;
}

double impact_energy(const Collision& c) { return 0.5 * c.record.effective_mass * c.record.normal_speed * c.record.normal_speed; }

double relative_impact_energy(const Collision& c) {
  // m* < m₁ tells the other mass; for a wall both are the same.
  const double star = c.record.effective_mass, second = star < c.first_mass * (1 - 1e-12) ? 1 / (1 / star - 1 / c.first_mass) : c.first_mass;
  const double speed_squared = c.record.normal_speed * c.record.normal_speed + c.record.tangential_speed * c.record.tangential_speed;
  return 0.5 * std::min(c.first_mass, second) * speed_squared;
}

void EnergySums::add(const EnergySums& more) {
  count += more.count;
  normal_loss += more.normal_loss;
  tangential_loss += more.tangential_loss;
  impact += more.impact;
  relative += more.relative;
}

void SpectrumSums::add(const SpectrumSums& later) {
  if (histograms.size() < later.histograms.size()) histograms.resize(later.histograms.size());
  for (std::size_t h = 0; h < later.histograms.size(); ++h) add_each(histograms[h], later.histograms[h]);
  add_each(totals, later.totals);
  overlap_peak = std::max(overlap_peak, later.overlap_peak);
  force_peak = std::max(force_peak, later.force_peak);
  contact_time += later.contact_time;
  // `carried` stays that of the earlier sums: where these begin, nothing crosses the joint any more.
}

int CollisionSpectrum::bins() const { return static_cast<int>(std::lround(std::log10(highest / lowest) * bins_per_decade)); }

int CollisionSpectrum::bin_of(double energy) const {
  if (!(energy > lowest)) return 0;
  return static_cast<int>(std::min(bins() - 1.0, std::log10(energy / lowest) * bins_per_decade));
}

double CollisionSpectrum::edge(int bin) const { return lowest * std::pow(10.0, static_cast<double>(bin) / bins_per_decade); }

std::size_t CollisionSpectrum::kind_of(std::uint8_t a, std::uint8_t b) const {
  const std::size_t n = species.size();
  if (b == 255) return n * (n + 1) / 2 + a;
  const std::size_t low = std::min(a, b), high = std::max(a, b);
  return high * (high + 1) / 2 + low;
}

std::string CollisionSpectrum::name_of(std::size_t kind) const {
  const std::size_t n = species.size(), pairs = n * (n + 1) / 2;
  if (kind >= pairs) return species[kind - pairs] + "-wall";
  std::size_t high = 0;
  while ((high + 1) * (high + 2) / 2 <= kind) ++high;
  return species[kind - high * (high + 1) / 2] + "-" + species[high];
}

void CollisionSpectrum::count(const Collision& collision, SpectrumSums& sums) const {
  EnergySums one{1, collision.record.normal_loss, collision.record.tangential_loss, impact_energy(collision), relative_impact_energy(collision)};
  if (!earlier.empty() && collision.record.start_time <= from) {
    const auto key = key_of(as_earlier(collision));
    const auto found = std::lower_bound(earlier.begin(), earlier.end(), key, [](const EarlierLoss& e, const auto& k) { return key_of(e) < k; });
    if (found != earlier.end() && key_of(*found) == key) {
      one.normal_loss -= found->normal_loss;
      one.tangential_loss -= found->tangential_loss;
    }
  }
  const std::size_t kind = kind_of(collision.first_species, collision.second_species);
  const ContactClass type = collision.lasting ? ContactClass::lasting
                            : collision.end_time - collision.record.start_time > long_contact ? ContactClass::enduring
                                                                                              : ContactClass::collision;
  if (sums.histograms.empty()) {
    sums.histograms.resize(kinds() * contact_classes * energy_measures);
    sums.totals.resize(kinds() * contact_classes);
  }
  const double energy[energy_measures] = {one.loss(), one.impact, one.relative};
  for (int m = 0; m < energy_measures; ++m) {
    std::vector<EnergySums>& histogram = sums.histograms[histogram_at(kind, type, static_cast<EnergyMeasure>(m))];
    if (histogram.empty()) histogram.resize(static_cast<std::size_t>(bins()));
    histogram[static_cast<std::size_t>(bin_of(energy[m]))].add(one);
  }
  sums.totals[kind * contact_classes + static_cast<std::size_t>(type)].add(one);
  sums.overlap_peak = std::max(sums.overlap_peak, collision.record.peak_overlap / lesser_radius(collision));
  sums.force_peak = std::max(sums.force_peak, collision.record.peak_force);
  if (type == ContactClass::collision) sums.contact_time += collision.end_time - collision.record.start_time;
}

double CollisionSpectrum::lesser_radius(const Collision& collision) const {
  const double first = radii[static_cast<std::size_t>(collision.first_id)];
  return collision.second_id < 0 ? first : std::min(first, radii[static_cast<std::size_t>(collision.second_id)]);
}

void CollisionSpectrum::see(const Simulation& simulation, const ObserverSettings& settings) {
  const double now = simulation.clock.time(), dt = simulation.clock.time_step;
  if (!began) {
    if (now < settings.start_time - 0.5 * dt) return;
    began = true;
    from = until = now;
    bins_per_decade = settings.bins_per_decade;
    long_contact = settings.long_contact > 0 ? settings.long_contact : 1000 * dt;
    for (const Species& s : simulation.species) species.push_back(s.name);
    for (Index i = 0; i < simulation.particles.owned; ++i) {
      charge_mass += simulation.particles.mass(i);
      const auto id = static_cast<std::size_t>(simulation.particles.id[static_cast<std::size_t>(i)]);
      if (radii.size() <= id) radii.resize(id + 1);
      radii[id] = simulation.particles.radius(i);
      while (species.size() <= simulation.particles.species[static_cast<std::size_t>(i)]) species.push_back("species_" + std::to_string(species.size()));
    }
    for (const Collision& c : simulation.lasting_collisions()) earlier.push_back(as_earlier(c));
    std::sort(earlier.begin(), earlier.end(), [](const EarlierLoss& a, const EarlierLoss& b) { return key_of(a) < key_of(b); });
    ended.span = first_span(settings, dt);
    ended.open(now).sums.carried.resize(kinds());
    return;
  }
  // Where a span begins, what the contacts of that moment have lost already belongs to the spans before.
  if (ended.due(now - dt)) {
    SpectrumSums before;
    for (Collision& c : simulation.lasting_collisions()) c.lasting = true, count(c, before);
    for (Collision c : simulation.ended_collisions()) c.lasting = true, count(c, before);
    auto& block = ended.open(now);
    block.sums.carried.resize(kinds());
    if (!before.totals.empty())
      for (std::size_t kind = 0; kind < kinds(); ++kind)
        block.sums.carried[kind] = before.totals[kind * contact_classes + static_cast<std::size_t>(ContactClass::lasting)];
  }
  auto& block = ended.blocks.back();
  for (const Collision& c : simulation.ended_collisions()) count(c, block.sums);
  block.to = until = now;
}

void CollisionSpectrum::finish(const Simulation& simulation) {
  lasting = {};
  if (!began) return;
  for (Collision& c : simulation.lasting_collisions()) c.lasting = true, count(c, lasting);
  until = simulation.clock.time();
}

EnergySums CollisionSpectrum::Window::total() const {
  EnergySums all;
  for (const EnergySums& t : sums.totals) all.add(t);
  for (const EnergySums& c : sums.carried) {
    all.normal_loss -= c.normal_loss;
    all.tangential_loss -= c.tangential_loss;
  }
  return all;
}

CollisionSpectrum::Window CollisionSpectrum::window(double start) const {
  Window w;
  if (ended.blocks.empty()) return w;
  const std::size_t first = ended.first_from(start);
  w.sums = ended.total(first);
  w.from = ended.blocks[first].from;
  w.seconds = until - w.from;
  w.sums.add(lasting);
  return w;
}

template <class Use>
void CollisionSpectrum::each_span(double start, Use use) const {
  for (std::size_t b = ended.first_from(start); b < ended.blocks.size(); ++b) {
    const double end = b + 1 < ended.blocks.size() ? ended.blocks[b + 1].from : until, seconds = end - ended.blocks[b].from;
    if (seconds >= 0.5 * ended.span) use(ended.blocks[b].sums, seconds);
  }
}

std::vector<EnergySums> CollisionSpectrum::by_impact(const SpectrumSums& sums) const {
  std::vector<EnergySums> all(static_cast<std::size_t>(bins()));
  for (std::size_t kind = 0; kind < kinds(); ++kind)
    for (const ContactClass type : {ContactClass::collision, ContactClass::enduring}) {
      const std::size_t at = histogram_at(kind, type, EnergyMeasure::impact);
      if (at < sums.histograms.size()) add_each(all, sums.histograms[at]);
    }
  return all;
}

std::optional<double> CollisionSpectrum::median_impact(const SpectrumSums& sums) const {
  const std::vector<EnergySums> energy = by_impact(sums);
  double whole = 0, below = 0;
  for (const EnergySums& bin : energy) whole += bin.impact;
  if (!(whole > 0)) return std::nullopt;
  std::size_t bin = 0;
  while (bin + 1 < energy.size() && below + energy[bin].impact < 0.5 * whole) below += energy[bin++].impact;
  const double share = (0.5 * whole - below) / energy[bin].impact;
  return edge(static_cast<int>(bin)) * std::pow(10.0, share / bins_per_decade);
}

CollisionSpectrum::Precision CollisionSpectrum::precision(double start) const {
  Precision out;
  if (ended.blocks.empty()) return out;
  const std::size_t first = ended.first_from(start);
  out.seconds = until - ended.blocks[first].from;
  if (!(out.seconds > 0)) return out;
  std::vector<EnergySums> whole;
  for (std::size_t b = first; b < ended.blocks.size(); ++b) add_each(whole, by_impact(ended.blocks[b].sums));
  EnergySums all;
  for (const EnergySums& bin : whole) all.add(bin);
  out.impact_rate = all.impact / out.seconds;
  out.collision_rate = all.count / out.seconds;
  std::vector<std::size_t> weighty;
  for (std::size_t bin = 0; bin < whole.size(); ++bin)
    if (whole[bin].impact > 0 && whole[bin].impact >= bin_share * all.impact) weighty.push_back(bin);
  std::vector<double> impact, count;
  std::vector<std::vector<double>> of_bin(weighty.size());
  each_span(start, [&](const SpectrumSums& sums, double seconds) {
    const std::vector<EnergySums> of_span = by_impact(sums);
    EnergySums span;
    for (const EnergySums& bin : of_span) span.add(bin);
    impact.push_back(span.impact / seconds);
    count.push_back(span.count / seconds);
    for (std::size_t k = 0; k < weighty.size(); ++k) of_bin[k].push_back(of_span[weighty[k]].count / seconds);
  });
  const auto half = [](const BlockAverage& a) { return a.ci95 ? 0.5 * ((*a.ci95)[1] - (*a.ci95)[0]) : NAN; };
  const BlockAverage by_energy = block_average(impact), by_count = block_average(count);
  out.impact_half = half(by_energy);
  out.collision_half = half(by_count);
  out.settled = by_energy.settled && by_count.settled;
  for (std::size_t k = 0; k < weighty.size(); ++k) {
    const double relative = half(block_average(of_bin[k])) / (whole[weighty[k]].count / out.seconds);
    if (!(out.widest_bin >= relative)) out.widest_bin = relative;
  }
  return out;
}

std::vector<Headline> CollisionSpectrum::headlines(double start) const {
  const Window w = window(start);
  if (w.seconds <= 0) return {};
  EnergySums all, ended_sums;
  for (std::size_t k = 0; k < w.sums.totals.size(); ++k) {
    all.add(w.sums.totals[k]);
    if (k % contact_classes != static_cast<std::size_t>(ContactClass::lasting)) ended_sums.add(w.sums.totals[k]);
  }
  // Intervals come from the scatter between spans, which sees the charge surge as a whole and energies vary from contact to contact.
  std::vector<double> rate, impact, relative, mean, median, duration;
  const auto short_ones = [&](const SpectrumSums& sums) {
    double n = 0;
    for (std::size_t k = static_cast<std::size_t>(ContactClass::collision); k < sums.totals.size(); k += contact_classes) n += sums.totals[k].count;
    return n;
  };
  each_span(start, [&](const SpectrumSums& span, double seconds) {
    EnergySums sums;
    for (const EnergySums& t : span.totals) sums.add(t);
    rate.push_back(sums.count / seconds);
    impact.push_back(sums.impact / seconds);
    relative.push_back(sums.relative / seconds);
    if (sums.count > 0) mean.push_back(sums.loss() / sums.count);
    if (const auto middle = median_impact(span)) median.push_back(*middle);
    if (const double n = short_ones(span); n > 0) duration.push_back(span.contact_time / n);
  });
  const auto around = [&](double value, const std::vector<double>& spans) -> std::optional<std::array<double, 2>> {
    const BlockAverage average = block_average(spans);
    if (!average.ci95) return std::nullopt;
    const double half = 0.5 * ((*average.ci95)[1] - (*average.ci95)[0]);
    return {{value - half, value + half}};
  };
  const double count = ended_sums.count, per_second = count / w.seconds;
  auto rate_interval = around(per_second, rate);
  if (!rate_interval) {
    const auto [low, high] = poisson_interval(count);
    rate_interval = {{low / w.seconds, high / w.seconds}};
  }
  std::vector<Headline> lines = {
      {"collision_rate", per_second, "1/s", rate_interval, "contacts that ended per second"},
      {"impact_energy_rate", ended_sums.impact / w.seconds, "W", around(ended_sums.impact / w.seconds, impact), "E_i: sum of m* v_n^2 / 2 at first touch, per second"},
      {"impact_energy_rate_relative", ended_sums.relative / w.seconds, "W", around(ended_sums.relative / w.seconds, relative),
       "sum of m v^2 / 2 per second, with the lesser mass and the whole relative speed at first touch"},
      {"contact_power", w.total().loss() / w.seconds, "W", std::nullopt, "dissipated in contacts per second, lasting ones included"},
      {"specific_power", w.total().loss() / w.seconds / charge_mass, "W/kg", std::nullopt, "dissipated in contacts per second and mass of charge"}};
  if (count > 0) {
    lines.push_back({"mean_collision_energy", ended_sums.loss() / count, "J", around(ended_sums.loss() / count, mean), "dissipated per contact that ended"});
    const auto share = [&](ContactClass c) {
      double n = 0;
      for (std::size_t k = 0; k < kinds(); ++k) n += w.sums.totals[k * contact_classes + static_cast<std::size_t>(c)].count;
      return n;
    };
    lines.push_back({"enduring_contacts", share(ContactClass::enduring) / count, "1", std::nullopt, "share of ended contacts that lasted longer than the limit"});
    lines.push_back({"lasting_contacts", share(ContactClass::lasting), "1", std::nullopt, "number of contacts that still last at the end"});
    if (const auto middle = median_impact(w.sums))
      lines.push_back({"impact_energy_median", *middle, "J", around(*middle, median), "half of E_i comes from impacts that are harder"});
    if (const double n = short_ones(w.sums); n > 0)
      lines.push_back({"contact_duration", w.sums.contact_time / n, "s", around(w.sums.contact_time / n, duration), "mean, of contacts that ended within the limit of enduring ones"});
  }
  lines.push_back({"sampled_time", w.seconds, "s", std::nullopt, "over which collisions were counted"});
  lines.push_back({"overlap_peak", w.sums.overlap_peak, "1", std::nullopt, "greatest overlap of a contact over the radius of its smaller particle"});
  lines.push_back({"contact_force_peak", w.sums.force_peak, "N", std::nullopt, "greatest normal force of a contact"});
  return lines;
}

std::vector<Table> CollisionSpectrum::tables(double start) const {
  const Window w = window(start);
  if (w.seconds <= 0) return {};
  static const char* measure_names[energy_measures] = {"dissipated", "impact", "relative"};
  static const char* class_names[contact_classes] = {"collision", "enduring", "lasting"};
  Column measure{"measure", "1", "the energy that is binned: dissipated; impact: m* v_n^2 / 2; relative: m v^2 / 2 of the lesser mass", {}, {}};
  Column pair{"pair", "1", "species of the bodies", {}, {}};
  Column type{"class", "1", "collision; enduring: longer than the limit; lasting: still touching at the end; carried: lost before the window by contacts that lasted into it, negative", {}, {}};
  Column low{"energy_from", "J", "lower end of the bin", {}, {}}, high{"energy_to", "J", "upper end of the bin", {}, {}},
      middle{"energy", "J", "geometric middle of the bin", {}, {}}, number{"count", "1", "contacts in the bin", {}, {}},
      rate{"rate", "1/s", "contacts per second", {}, {}}, rate_low{"rate_low", "1/s", "lower end of the 95 % interval (Poisson)", {}, {}},
      rate_high{"rate_high", "1/s", "upper end of the 95 % interval (Poisson)", {}, {}}, loss{"dissipated", "W", "energy dissipated per second", {}, {}},
      normal{"normal", "W", "its part along the normal", {}, {}}, shear{"shear", "W", "its part by sliding and rolling", {}, {}},
      impact{"impact", "W", "impact energy m* v_n^2 / 2 per second", {}, {}}, specific{"specific", "W/kg", "energy dissipated per second and mass of charge", {}, {}};
  const auto row = [&](const char* m, std::size_t kind, const char* c, double from_energy, double to_energy, const EnergySums& s) {
    measure.labels.emplace_back(m);
    pair.labels.push_back(name_of(kind));
    type.labels.emplace_back(c);
    low.values.push_back(from_energy);
    high.values.push_back(to_energy);
    middle.values.push_back(std::sqrt(from_energy * to_energy));
    number.values.push_back(s.count);
    rate.values.push_back(s.count / w.seconds);
    const auto interval = poisson_interval(s.count);
    rate_low.values.push_back(interval[0] / w.seconds);
    rate_high.values.push_back(interval[1] / w.seconds);
    loss.values.push_back(s.loss() / w.seconds);
    normal.values.push_back(s.normal_loss / w.seconds);
    shear.values.push_back(s.tangential_loss / w.seconds);
    impact.values.push_back(s.impact / w.seconds);
    specific.values.push_back(s.loss() / w.seconds / charge_mass);
  };
  for (int m = 0; m < energy_measures; ++m)
    for (std::size_t kind = 0; kind < kinds(); ++kind)
      for (int c = 0; c < contact_classes; ++c) {
        const std::size_t at = histogram_at(kind, static_cast<ContactClass>(c), static_cast<EnergyMeasure>(m));
        if (at >= w.sums.histograms.size()) continue;
        const std::vector<EnergySums>& histogram = w.sums.histograms[at];
        for (std::size_t bin = 0; bin < histogram.size(); ++bin)
          if (histogram[bin].count > 0) row(measure_names[m], kind, class_names[c], edge(static_cast<int>(bin)), edge(static_cast<int>(bin) + 1), histogram[bin]);
      }
  for (std::size_t kind = 0; kind < w.sums.carried.size(); ++kind) {
    EnergySums carried = w.sums.carried[kind];
    if (carried.count <= 0) continue;
    carried.count = 0;
    carried.normal_loss = -carried.normal_loss;
    carried.tangential_loss = -carried.tangential_loss;
    carried.impact = 0;
    row("dissipated", kind, "carried", lowest, highest, carried);
  }
  return {{"spectra", "collisions per second by energy, pair and class, in the steady state",
           {measure, pair, type, low, high, middle, number, rate, rate_low, rate_high, loss, normal, shear, impact, specific}}};
}

}  // namespace quern
