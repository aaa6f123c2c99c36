// Breakage studies: what the fits recover, how often their intervals hold, what is said where data cannot tell, and `quern breakage`.
#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include "src/base/random.hpp"
#include "src/grinding/breakage.hpp"
#include "tests/folder.hpp"

using namespace quern;
namespace fs = std::filesystem;

namespace {

// Specific energies of 2 to 20 m/s [J/kg].
const std::vector<double> energies = {2, 4.5, 8, 15, 24, 36, 60, 90, 140, 200};

bool holds(const std::optional<Interval95>& interval, double truth) { return interval && (*interval)[0] <= truth && truth <= (*interval)[1]; }
bool holds(const Interval95& interval, double truth) { return interval[0] <= truth && truth <= interval[1]; }

// Means of `count` repeats about a law whose scatter grows with the damage and ends where there is none.
std::vector<Level> drawn(const SaturationLaw& law, int count, double relative, RandomStream& random) {
  std::vector<double> x, y;
  for (const double energy : energies)
    for (int k = 0; k < count; ++k) x.push_back(energy), y.push_back(law.at(energy) * (1 + relative * random.normal()));
  return levels_of(x, y);
}

template <class Probability>
std::vector<BreakageCount> drawn_counts(Probability probability, int tested, RandomStream& random) {
  std::vector<BreakageCount> counts;
  for (const double energy : energies) {
    counts.push_back({energy, 0, tested});
    for (int k = 0; k < tested; ++k) counts.back().broken += random.uniform() < probability(energy);
  }
  return counts;
}

double share(int held, int of) { return static_cast<double>(held) / of; }

bool said(const BreakageResult& result, const std::string& words) {
  for (const std::string& remark : result.remarks)
    if (remark.find(words) != std::string::npos) return true;
  return false;
}

struct BreakageFolder : Folder {
  BreakageFolder() : Folder("breakage") {}
  int study(const std::string& arguments) const { return run_quern("breakage " + arguments + " --no-pictures --out '" + (path / "out").string() + "'", path / "log"); }
  nlohmann::json summary() const { return nlohmann::json::parse(read("out/summary.json")); }
};

}  // namespace

TEST_CASE("laws of damage and of t10 are recovered from means without errors") {
  for (const SaturationLaw truth : {SaturationLaw{0.6, 6, 40, 1}, SaturationLaw{0.9, 3, 30, 1.8}, SaturationLaw{0.3, 12, 60, 0.8}}) {
    std::vector<Level> levels;
    for (const double energy : energies) levels.push_back({energy, truth.at(energy), 0, 1});
    const SaturationFit fit = fit_saturation(levels, {true, true}, 1, 0);
    INFO(truth.plateau << " " << truth.threshold << " " << truth.scale << " " << truth.shape);
    CHECK(fit.law.plateau == Approx(truth.plateau).epsilon(1e-3));
    CHECK(fit.law.threshold == Approx(truth.threshold).epsilon(1e-2));
    CHECK(fit.law.scale == Approx(truth.scale).epsilon(1e-2));
    CHECK(fit.law.shape == Approx(truth.shape).epsilon(1e-2));
    CHECK(fit.law.at(fit.law.half()) == Approx(0.5 * fit.law.plateau));
  }
  const SaturationLaw crushing{0.45, 0, 50, 1};
  std::vector<Level> levels;
  for (const double energy : energies) levels.push_back({energy, crushing.at(energy), 0, 1});
  const SaturationFit fit = fit_saturation(levels, {}, 1, 0);
  CHECK(fit.law.plateau == Approx(0.45).epsilon(1e-4));
  CHECK(fit.law.initial_slope() == Approx(0.009).epsilon(1e-4));
  CHECK(SaturationLaw{0.5, 10, 20, 1}.at(9) == 0);
  CHECK(SaturationLaw{0.5, 10, 20, 1}.at(30) == Approx(0.5 * (1 - std::exp(-1))));
}

TEST_CASE("the likelihood of breakage has its closed forms") {
  // Two energies and two parameters: both laws go through both parts, f (W − W_min) = −ln(1 − S).
  const std::vector<BreakageCount> two = {{10, 20, 100}, {30, 60, 100}};
  REQUIRE(evidence_of(two) == BreakageEvidence::enough);
  const double low = -std::log(0.8), high = -std::log(0.4);
  const BreakageFit vogel = fit_breakage(two, BreakageLaw::vogel_peukert, 1, 0), weibull = fit_breakage(two, BreakageLaw::weibull, 1, 0);
  CHECK(vogel.first == Approx((high - low) / 20).epsilon(1e-3));
  CHECK(vogel.second == Approx(10 - low / vogel.first).epsilon(1e-3));
  CHECK(weibull.first == Approx(std::log(high / low) / std::log(3)).epsilon(1e-3));
  CHECK(weibull.second == Approx(10 / std::pow(low, 1 / weibull.first)).epsilon(1e-3));
  CHECK(weibull.at(30) == Approx(0.6).epsilon(1e-3));
  CHECK(vogel.deviance == Approx(0).margin(1e-5));
  // Clopper & Pearson: none of n, 1 − 0.025^(1/n).
  CHECK(proportion_interval(0, 10)[1] == Approx(1 - std::pow(0.025, 0.1)));
  CHECK(proportion_interval(10, 10)[0] == Approx(std::pow(0.025, 0.1)));
}

TEST_CASE("the 95 % intervals of the probability of breakage hold in 93 to 97 % of synthetic sets", "[breakage]") {
  // Of 400 sets 95 % hold with a standard deviation of 1.1 %; the bounds are two to three of them away, as counts are coarse.
  constexpr int sets = 400, tested = 20;
  RandomStream random(11);
  std::array<int, 4> held{};
  const double rate = 0.02, minimum = 6, modulus = 1.6, scale = 40;
  int told = 0;
  for (int k = 0; k < sets; ++k) {
    const auto vogel = drawn_counts([&](double w) { return -std::expm1(-rate * std::max(0.0, w - minimum)); }, tested, random);
    const auto weibull = drawn_counts([&](double w) { return -std::expm1(-std::pow(w / scale, modulus)); }, tested, random);
    REQUIRE(evidence_of(vogel) == BreakageEvidence::enough);
    const BreakageFit a = fit_breakage(vogel, BreakageLaw::vogel_peukert, 1, 0), b = fit_breakage(weibull, BreakageLaw::weibull, 1, 0);
    held[0] += holds(a.first_ci95, rate), held[1] += holds(a.second_ci95, minimum), held[2] += holds(b.first_ci95, modulus), held[3] += holds(b.second_ci95, scale);
    told += fit_breakage(weibull, BreakageLaw::vogel_peukert, 1, 0).log_likelihood < b.log_likelihood;
  }
  for (const int h : held) CHECK(share(h, sets) == Approx(0.95).margin(0.025));
  CHECK(told > sets / 2);
}

TEST_CASE("the 95 % intervals of damage and t10 hold in 93 to 97 % of synthetic sets", "[breakage]") {
  // Below the threshold there is no damage at all, so that the first energy above it, 8 J/kg, bounds it.
  constexpr int sets = 200, repeats = 10, draws = 199;
  RandomStream random(12);
  int plateau = 0, half = 0, scale = 0, largest = 0, slope = 0, threshold = 0, shape = 0;
  const SaturationLaw damage{0.6, 6, 40, 1.3}, crushing{0.45, 0, 50, 1};
  using L = const SaturationLaw&;
  for (std::uint64_t k = 0; k < sets; ++k) {
    const SaturationFit a = fit_saturation(drawn(damage, repeats, 0.15, random), {true, true, 1, 8}, k, draws), b = fit_saturation(drawn(crushing, repeats, 0.15, random), {}, k, draws);
    plateau += holds(a.interval([](L l) { return l.plateau; }), damage.plateau);
    half += holds(a.interval([](L l) { return l.half(); }), damage.half());
    scale += holds(a.interval([](L l) { return l.scale; }), damage.scale);
    largest += holds(b.interval([](L l) { return l.plateau; }), crushing.plateau);
    slope += holds(b.interval([](L l) { return l.initial_slope(); }), crushing.initial_slope());
    threshold += holds(a.interval([](L l) { return l.threshold; }), damage.threshold);
    shape += holds(a.interval([](L l) { return l.shape; }), damage.shape);
  }
  // Of 200 sets 95 % hold with a standard deviation of 1.5 %; the bounds are two of them away.
  for (const int held : {plateau, half, scale, largest, slope}) CHECK(share(held, sets) == Approx(0.95).margin(0.03));
  // Threshold and shape stand in for each other, and the threshold has two bounds: their intervals are wider than they must be.
  for (const int held : {threshold, shape}) CHECK(share(held, sets) > 0.93);
}

TEST_CASE("a study says what its runs cannot tell") {
  BreakageStudy study;
  const auto impacts = [&](const std::vector<std::array<double, 3>>& rows) {  // energy, damage, broken of 5
    study.runs.clear();
    for (const auto& [energy, damage, broken] : rows) study.runs.push_back({energy, damage, std::nullopt, static_cast<int>(broken), 5});
    return study_breakage(study);
  };
  const BreakageResult none = impacts({{10, 0, 0}, {20, 0, 0}, {40, 0, 0}});
  CHECK((said(none, "no bond failed in any run; the threshold lies above 40 J/kg") && said(none, "none of 15 bodies broke") && said(none, "t10: not there")));
  CHECK((!none.damage_fit && !none.vogel_peukert && *none.last_unharmed == 40 && !none.first_harmed));
  // At least 0.025^(1/5) of 5 that all broke.
  const BreakageResult all = impacts({{10, 0.4, 5}, {20, 0.5, 5}, {40, 0.55, 5}, {80, 0.56, 5}});
  CHECK((said(all, "all of 20 bodies broke") && said(all, "At 10 J/kg it is at least 0.48") && said(all, "even the least energy, 10 J/kg, broke bonds")));
  CHECK((!all.vogel_peukert && all.plateau_reached));
  CHECK(said(impacts({{10, 0, 0}, {20, 0.1, 5}}), "every body is whole up to 10 J/kg and broken from 20 J/kg on"));
  CHECK(said(impacts({{10, 0, 0}, {20, 0.1, 2}, {30, 0.2, 5}}), "bodies broke and stayed whole at 20 J/kg only"));
  CHECK(said(impacts({{10, 0.1, 3}}), "one energy gives no law"));
  const BreakageResult rising = impacts({{10, 0, 0}, {20, 0.01, 1}, {30, 0.02, 0}, {40, 0.03, 2}, {50, 0.04, 1}});
  CHECK(said(rising, "the plateau is an extrapolation"));
  CHECK(rising.vogel_peukert->second_ci95[1] < 20);
  CHECK(*rising.last_unharmed == 10);
}

TEST_CASE("quern breakage studies a sweep over speed and seed", "[cli]") {
  const BreakageFolder folder;
  RandomStream random(4);
  std::string text = "insert.body.speed [m/s],seed [1],damage_ratio,largest_fragment_fraction,t10,body_count,directory\n";
  for (const double speed : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 14.0, 18.0, 24.0})
    for (int seed = 1; seed <= 10; ++seed) {
      const double w = 0.5 * speed * speed, damage = SaturationLaw{0.6, 3, 40, 1}.at(w), t10 = SaturationLaw{0.4, 0, 60, 1}.at(w);
      const bool broken = random.uniform() < -std::expm1(-0.03 * std::max(0.0, w - 3));
      text += fmt::format("{},{},{},{},{},1,r{}_{}\n", speed, seed, damage * (1 + 0.1 * random.normal()), broken ? 0.5 : 0.95, speed < 1.5 ? "" : fmt::format("{}", t10 * (1 + 0.1 * random.normal())), speed, seed);
    }
  folder.write("sweep/sweep.csv", text);
  REQUIRE(folder.study("'" + (folder.path / "sweep").string() + "' --size '100 mm'") == 0);
  const nlohmann::json summary = folder.summary();
  const auto holds_value = [&](const char* key, double truth) {
    INFO(key << " " << summary[key].dump());
    CHECK(summary[key]["ci95"][0].get<double>() <= truth);
    CHECK(summary[key]["ci95"][1].get<double>() >= truth);
  };
  holds_value("damage_plateau", 0.6), holds_value("damage_threshold_energy", 3), holds_value("breakage_rate", 0.03), holds_value("t10_A", 0.4);
  CHECK(summary["breakage_f_mat"]["value"].get<double>() == Approx(summary["breakage_rate"]["value"].get<double>() / 0.1));
  CHECK(summary["damage_threshold_speed"]["value"].get<double>() == Approx(std::sqrt(2 * summary["damage_threshold_energy"]["value"].get<double>())));
  CHECK(summary["last_unharmed_energy"]["value"] == 2);
  CHECK(summary["first_harmed_energy"]["value"] == 4.5);
  CHECK_THAT(folder.read("out/breakage.csv"), Catch::StartsWith("specific_energy [J/kg],speed [m/s],damage_runs,damage,"));
  CHECK_THAT(folder.read("out/breakage_fits.csv"), Catch::StartsWith("parameter,value,from,to,unit\n"));
  const std::string first = folder.read("out/summary.json");
  REQUIRE(folder.study("'" + (folder.path / "sweep").string() + "' --size '100 mm'") == 0);
  CHECK(folder.read("out/summary.json") == first);

  // The same impacts by their velocities; and a stricter word for broken: none is below a third.
  std::string turned = "insert.body.velocity,largest_fragment_fraction\n\"[0, 0, -4]\",0.5\n\"[3, 0, \"\"-4 m/s\"\"]\",0.4\n";
  REQUIRE(folder.study("'" + folder.write("turned.csv", turned) + "' --broken 0.3") == 0);
  CHECK_THAT(folder.read("log"), Catch::Contains("none of 2 bodies broke (largest fragment below 0.3 of the mass). At 12.5 J/kg"));
}

TEST_CASE("quern breakage says in one line what is wrong with its input", "[cli]") {
  const BreakageFolder folder;
  struct Bad {
    std::string text, arguments, says;
  };
  const std::vector<Bad> all = {
      {"speed [m/s],seed\n1,2\n", "", "bad.csv:1: none of the columns damage_ratio, largest_fragment_fraction, broken and t10 is there"},
      {"seed,damage_ratio\n1,0.2\n", "", "bad.csv:1: no column says how hard bodies were hit"},
      {"speed,damage_ratio\n1,0.2\n", "", "bad.csv:1: column speed has no unit; write `speed [m/s]`"},
      {"speed [kg],damage_ratio\n1,0.2\n", "", "bad.csv:1: the unit [kg] is not one of m/s or J/kg"},
      {"speed [m/s],damage_ratio\n0,0.2\n", "", "bad.csv:2: column speed: found 0; allowed are numbers above 0."},
      {"speed [m/s],damage_ratio\n1,1.2\n", "", "bad.csv:2: column damage_ratio: found 1.2; allowed are fractions from 0 to 1."},
      {"speed [m/s],broken,tested\n1,6,5\n", "", "bad.csv:2: column broken: found 6; allowed are whole numbers from 0 to 5."},
      {"speed [m/s],tested,t10\n1,6,0.1\n", "", "bad.csv:1: beside `tested` the column `broken` is needed."},
      {"insert.a.speed [m/s],insert.b.speed [m/s],t10\n1,1,0.1\n", "", "bad.csv:1: both insert.a.speed and insert.b.speed may be the speed of the bodies; --against says which."},
      {"insert.a.speed [m/s],bond.x.x.young [Pa],t10\n1,1,0.1\n2,3,0.2\n", "", "bad.csv:3: column bond.x.x.young: found 3 where line 2 has 1; a study holds one kind of body"},
      {"insert.a.velocity,t10\n\"[1, 2]\",0.1\n", "", "bad.csv:2: column insert.a.velocity: found [1, 2]; allowed are velocities [x, y, z]."},
      {"speed [m/s],t10\n1,0.1\n", "--against v", "--against v: "},
      {"speed [m/s],t10\n1,0.1\n", "--broken 1.2", "--broken 1.2: allowed is a part of the mass above 0 and at most 1."},
      {"speed [m/s],t10\n1,0.1\n", "--size 2kg", "--size 2kg: "},
      {"speed [m/s],t10\n", "", "bad.csv: this table is empty"},
  };
  for (const Bad& bad : all) {
    INFO(bad.text << bad.arguments);
    CHECK(folder.study("'" + folder.write("bad.csv", bad.text) + "' " + bad.arguments) == 2);
    const std::string words = folder.read("log");
    INFO(words);
    CHECK_THAT(words, Catch::Contains(bad.says));
    CHECK(words.find('\n') == words.size() - 1);
    CHECK(!fs::exists(folder.path / "out"));
  }
}
