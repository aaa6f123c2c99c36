// Collision spectra: how often bodies collide at which energy, by pair kind. Every joule that the ledger counts as dissipated in contacts
// while this watches is found here again: in collisions that ended, or in contacts that still last.
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"
#include "src/observe/time_blocks.hpp"

namespace quern {

// The energies against which collisions are counted, all in joules.
enum class EnergyMeasure : std::uint8_t {
  dissipated,   // lost along the normal, by sliding and by rolling
  impact,       // ½ m* v_n² at first touch
  relative,     // ½ m v², m the lesser mass of the two and v their whole relative speed at first touch (Jayasundara et al. 2009)
};
inline constexpr int energy_measures = 3;

// short: ended within the limit; enduring: ended after it; lasting: still touching when last looked at.
enum class ContactClass : std::uint8_t { collision, enduring, lasting };
inline constexpr int contact_classes = 3;

struct EnergySums {
  double count = 0;
  double normal_loss = 0;      // [J]
  double tangential_loss = 0;  // [J]
  double impact = 0;           // [J]
  double relative = 0;         // [J]
  void add(const EnergySums& more);
  double loss() const { return normal_loss + tangential_loss; }
  template <class Archive>
  void archive(Archive& a) {
    a(count, normal_loss, tangential_loss, impact, relative);
  }
};

// Sums by pair kind, class, measure and energy bin; empty parts take no room.
struct SpectrumSums {
  std::vector<std::vector<EnergySums>> histograms;  // [(kind · classes + class) · measures + measure][bin]
  std::vector<EnergySums> carried;                  // [kind]: what contacts that lasted when these sums began had lost before
  std::vector<EnergySums> totals;                   // [kind · classes + class]
  double overlap_peak = 0;                          // greatest overlap over the lesser radius of its contact
  double force_peak = 0;                            // greatest normal force of a contact [N]
  double contact_time = 0;                          // summed over the contacts of class `collision` [s]
  void add(const SpectrumSums& later);
  template <class Archive>
  void archive(Archive& a) {
    a(histograms, carried, totals, overlap_peak, force_peak, contact_time);
  }
};

// What a contact that lasted at the start had lost before.
struct EarlierLoss {
  Index first_id = 0, second_id = 0;
  double start_time = 0, normal_loss = 0, tangential_loss = 0;
  template <class Archive>
  void archive(Archive& a) {
    a(first_id, second_id, start_time, normal_loss, tangential_loss);
  }
};

// The first span of time over which collisions are summed: a twentieth of a revolution, or a hundred steps where nothing turns [s].
double first_span(const ObserverSettings& settings, double time_step);

struct CollisionSpectrum {
  static constexpr double lowest = 1e-12, highest = 1e6;  // of the bins; what lies beyond is in the first or the last [J]
  TimeBlocks<SpectrumSums> ended;
  SpectrumSums lasting;             // at `until`
  double from = 0, until = 0;       // [s]
  double charge_mass = 0;           // [kg]
  int bins_per_decade = 10;
  double long_contact = 0;          // [s]
  std::vector<std::string> species;
  std::vector<EarlierLoss> earlier;  // sorted by ids and start
  std::vector<double> radii;         // by id [m]
  bool began = false;

  // Begins at the first call at or after settings.start_time.
  void see(const Simulation& simulation, const ObserverSettings& settings);
  // Writes down the contacts that last now. May be repeated.
  void finish(const Simulation& simulation);

  // What was seen from `start` [s] on, to the nearest span of `ended`: sums, and the seconds that they cover.
  struct Window {
    SpectrumSums sums;  // lasting contacts included; their `carried` is still to be taken off
    double from = 0, seconds = 0;
    EnergySums total() const;  // `carried` taken off: equals the ledger's dissipation over the window
  };
  Window window(double start) const;

  // The impact energy that halves E_i: half of ½ m* v_n² comes from harder impacts [J]; none without impacts.
  std::optional<double> median_impact(const SpectrumSums& sums) const;

  // How well the spectrum is known from `start` [s] on. Half-widths are those of 95 % intervals by the scatter between spans; NaN: too few spans
  // to tell.
  struct Precision {
    double seconds = 0;                               // sampled [s]
    double impact_rate = 0, impact_half = NAN;        // E_i [W]
    double collision_rate = 0, collision_half = NAN;  // [1/s]
    double widest_bin = NAN;                          // the greatest half-width over rate of a bin that matters
    bool settled = false;                             // the scatter of E_i and of the collisions shows no correlation any more
  };
  static constexpr double bin_share = 0.01;  // a bin of impact energy matters if it carries this part of E_i
  Precision precision(double start) const;

  std::vector<Headline> headlines(double start) const;
  std::vector<Table> tables(double start) const;

  int bins() const;
  int bin_of(double energy) const;
  double edge(int bin) const;  // the bin's lower end [J]
  // species a, b ↦ kind; b = 255: a wall.
  std::size_t kinds() const { return species.size() * (species.size() + 3) / 2; }
  std::size_t kind_of(std::uint8_t a, std::uint8_t b) const;
  std::string name_of(std::size_t kind) const;

  template <class Archive>
  void archive(Archive& a) {
    a(ended, lasting, from, until, charge_mass, bins_per_decade, long_contact, species, earlier, radii, began);
  }

 private:
  void count(const Collision& collision, SpectrumSums& sums) const;
  double lesser_radius(const Collision& collision) const;
  // Calls use(sums, seconds) for each span of the window that is at least half full.
  template <class Use>
  void each_span(double start, Use use) const;
  // Contacts that ended, all pairs together, by bin of impact energy.
  std::vector<EnergySums> by_impact(const SpectrumSums& sums) const;
};

// Impact energies of one collision [J].
double impact_energy(const Collision& collision);           // ½ m* v_n²
double relative_impact_energy(const Collision& collision);  // ½ m v² of the lesser mass

}  // namespace quern
