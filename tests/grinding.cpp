// Grinding kinetics: what the fits recover, how often their intervals hold, and `quern grinding`.
#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include "src/base/random.hpp"
#include "src/grinding/kinetics.hpp"
#include "src/grinding/passing_size.hpp"
#include "src/grinding/power_law.hpp"
#include "tests/folder.hpp"
#include "tests/places.hpp"

using namespace quern;
namespace fs = std::filesystem;

namespace {

const std::vector<double> times = {0, 10, 20, 40, 60, 90, 120, 180, 240};

SizeSeries series_of(double rate, double start, double limit, double shape = 1) {
  SizeSeries s;
  for (const double t : times) s.times.push_back(t), s.sizes.push_back(limit + (start - limit) * std::exp(-std::pow(rate * t, shape)));
  return s;
}

SizeSeries noisy(SizeSeries s, double error, RandomStream& random) {
  for (double& size : s.sizes) size += error * random.normal();
  return s;
}

bool holds(const std::optional<Interval95>& interval, double truth) { return interval && (*interval)[0] <= truth && truth <= (*interval)[1]; }

struct GrindingFolder : Folder {
  GrindingFolder() : Folder("grinding") {}
  // `quern grinding`; its words are then in the file log.
  int grind(const std::string& arguments) const { return run_quern("grinding " + arguments, path / "log"); }
  nlohmann::json summary(const std::string& out) const { return nlohmann::json::parse(read(out + "/summary.json")); }
};

// Three runs with D80 [um] and K_p = 0.01 E_i^0.9 [1/s].
std::string three_runs(const std::string& condition, const std::vector<std::string>& labels) {
  std::string text = "# made\nrun,t [min],D80 [um]" + condition + "\n";
  for (std::size_t k = 0; k < labels.size(); ++k)
    for (const double t : {0.0, 1.0, 2.0, 4.0, 8.0}) {
      const double rate = 0.01 * std::pow(static_cast<double>(k + 1), 0.9);
      text += labels[k].substr(0, labels[k].find(',')) + "," + std::to_string(t) + "," + std::to_string(20 + 80 * std::exp(-rate * 60 * t)) +
              (labels[k].find(',') == std::string::npos ? "" : labels[k].substr(labels[k].find(','))) + "\n";
    }
  return text;
}

}  // namespace

TEST_CASE("kinetics without errors are recovered") {
  for (const double rate : {0.002, 0.015, 0.1}) {
    for (const double limit : {0.0, 20.0}) {
      const SizeSeries s = series_of(rate, 100, limit);
      for (const bool known : {true, false}) {
        const KineticsFit fit = fit_kinetics(s, known ? std::optional(limit) : std::nullopt);
        INFO(rate << " " << limit << " " << known);
        CHECK(fit.determined);
        CHECK(fit.rate == Approx(rate).epsilon(1e-4));
        CHECK(fit.start == Approx(100).epsilon(1e-4));
        CHECK(fit.limit == Approx(limit).margin(0.01));
        CHECK(fit.at(30) == Approx(limit + (100 - limit) * std::exp(-rate * 30)).epsilon(1e-5));
        CHECK(holds(fit.rate_ci95, fit.rate));
      }
    }
  }
}

TEST_CASE("the 95 % intervals of K_p and of the exponent hold in 93 to 97 % of synthetic sets") {
  // Of 600 sets 95 % hold with a standard deviation of 0.9 %; the bounds are 2.2 of them away. Of 3000 rates: 0.4 %;
  // 3.7 of them, as intervals from series that hardly tell D_∞ hold a little more often.
  constexpr int sets = 600, operating_points = 5;
  constexpr double exponent = 0.9, factor = 0.01;
  struct Setting {
    double noise, limit, lack;  // of D_0 = 100; of ln K
    bool limit_known;
  };
  for (const Setting& set : {Setting{0.5, 0, 0, true}, Setting{3, 0, 0, true}, Setting{3, 20, 0.1, true}, Setting{0.5, 20, 0, false}, Setting{1, 20, 0.1, false}, Setting{5, 20, 0.1, false}}) {
    RandomStream random(5);
    int rates_hold = 0, exponents_hold = 0, factors_hold = 0;
    for (int k = 0; k < sets; ++k) {
      std::vector<OperatingPoint> points;
      double squares = 0;
      int freedom = 0;
      for (int j = 0; j < operating_points; ++j) {
        const double x = 0.5 * std::pow(8.0, j / (operating_points - 1.0)), rate = factor * std::pow(x, exponent) * std::exp(set.lack * random.normal());
        const KineticsFit fit = fit_kinetics(noisy(series_of(rate, 100, set.limit), set.noise, random), set.limit_known ? std::optional(set.limit) : std::nullopt);
        rates_hold += holds(fit.rate_ci95, rate);
        squares += fit.squares, freedom += fit.freedom();
        points.push_back({x, fit.rate, fit.log_rate_variance, 0});
      }
      for (OperatingPoint& p : points)
        for (double& variance : p.log_rate_variance) variance *= squares / freedom;
      const PowerLawFit law = fit_power_law(points);
      exponents_hold += holds(law.exponent_ci95, exponent), factors_hold += holds(law.factor_ci95, factor);
    }
    INFO("noise " << set.noise << ", limit " << set.limit << (set.limit_known ? " known" : " unknown") << ", lack " << set.lack);
    const auto share = [](int held, int of) { return static_cast<double>(held) / of; };
    CHECK(share(rates_hold, sets * operating_points) == Approx(0.95).margin(0.015));
    CHECK(share(exponents_hold, sets) == Approx(0.95).margin(0.02));
    CHECK(share(factors_hold, sets) == Approx(0.95).margin(0.02));
  }
}

TEST_CASE("errors of the impact energy widen the interval of the exponent as much as they must") {
  // Of 1500 sets 95 % hold with a standard deviation of 0.56 %.
  constexpr int sets = 1500;
  RandomStream random(8);
  int held = 0;
  for (int k = 0; k < sets; ++k) {
    std::vector<OperatingPoint> points;
    for (int j = 0; j < 6; ++j) {
      const double log_x = 0.4 * j, error_x = 0.05 * (1 + j % 2), error = 0.03;
      points.push_back({std::exp(log_x + error_x * random.normal()), 0.01 * std::exp(0.9 * log_x + error * random.normal()), {error * error, error * error}, error_x * error_x});
    }
    held += holds(fit_power_law(points).exponent_ci95, 0.9);
  }
  CHECK(static_cast<double>(held) / sets == Approx(0.95).margin(0.017));
}

TEST_CASE("sizes that do not fall leave the rate open") {
  RandomStream random(3);
  int open_below = 0;
  constexpr int sets = 200;
  for (int k = 0; k < sets; ++k) {
    const KineticsFit fit = fit_kinetics(noisy(series_of(0, 100, 0), 1, random), 0);
    open_below += (*fit.rate_ci95)[0] == 0;
  }
  // Zero lies outside a two-sided interval in 2.5 % of cases, of 200 in 5 ± 2.2.
  CHECK(open_below >= sets - 12);
  const SizeSeries plateau{{0, 50, 60, 70, 80}, {100, 20.1, 19.9, 20, 20}, {}};
  const KineticsFit fast = fit_kinetics(plateau, std::nullopt);
  CHECK((*fast.rate_ci95)[0] > 0.05);
  CHECK(std::isinf((*fast.rate_ci95)[1]));
}

TEST_CASE("kinetics that are not first-order are told, and 5 % of those that are") {
  RandomStream random(7);
  int alarms = 0;
  constexpr int sets = 150;
  for (int k = 0; k < sets; ++k) alarms += fit_shape(noisy(series_of(0.015, 100, 0), 1, random), 0)->p_first_order < 0.05;
  CHECK(alarms <= 15);  // 7.5 ± 2.7
  CHECK(alarms >= 1);
  const ShapeFit slow = *fit_shape(noisy(series_of(0.015, 100, 0, 0.5), 1, random), 0);
  CHECK(slow.p_first_order < 1e-4);
  CHECK(holds(slow.shape_ci95, 0.5));
  CHECK(!holds(slow.shape_ci95, 1));
  const SizeSeries s = noisy(series_of(0.015, 100, 0, 0.5), 0.5, random);
  CHECK(*held_out_error(s, 0, true) < 0.5 * *held_out_error(s, 0));
}

TEST_CASE("the held-out error of a true law is that of the sizes") {
  RandomStream random(2);
  double sum = 0;
  constexpr int sets = 200;
  for (int k = 0; k < sets; ++k) sum += std::pow(*held_out_error(noisy(series_of(0.01, 100, 0), 2, random), 0), 2) / sets;
  // Each is predicted from eight, two parameters fitted: the errors are 2 √(1 + 2/7 … ), more at the ends.
  CHECK(std::sqrt(sum) > 2);
  CHECK(std::sqrt(sum) < 3);
  CHECK(!held_out_error(SizeSeries{{0, 1}, {2, 1}, {}}, 0));
}

TEST_CASE("an uncertain size weighs little") {
  SizeSeries s = series_of(0.01, 100, 0);
  s.sizes[4] *= 1.5;
  s.weights.assign(s.times.size(), 1);
  CHECK(std::abs(fit_kinetics(s, 0).rate - 0.01) > 5e-4);
  s.weights[4] = 1e-6;
  CHECK(fit_kinetics(s, 0).rate == Approx(0.01).epsilon(1e-4));
}

TEST_CASE("a power law: exact, with errors, with two points") {
  std::vector<OperatingPoint> points;
  for (const double x : {0.5, 1.0, 3.0, 7.0}) points.push_back({x, 0.02 * std::pow(x, 0.8), {0.01, 0.01}, 0});
  const PowerLawFit exact = fit_power_law(points);
  CHECK(exact.exponent == Approx(0.8));
  CHECK(exact.factor == Approx(0.02));
  CHECK(exact.lack == 0);
  CHECK(*exact.held_out == Approx(0).margin(1e-9));
  CHECK(*exact.held_out_mean > 0.5);
  CHECK(*exact.p_of_law > 0.99);

  // Equal errors: ordinary least squares, whose interval is known in closed form.
  const std::vector<double> off = {0.1, -0.1, -0.1, 0.1};
  std::vector<OperatingPoint> crooked;
  for (int k = 0; k < 4; ++k) crooked.push_back({std::exp(k), 0.02 * std::exp(0.8 * k + off[static_cast<std::size_t>(k)]), {}, 0});
  const PowerLawFit plain = fit_power_law(crooked);
  CHECK(plain.exponent == Approx(0.8));
  CHECK((*plain.exponent_ci95)[1] - plain.exponent == Approx(4.3027 * std::sqrt(0.04 / 2 / 5)).epsilon(1e-4));
  CHECK(!plain.p_of_law);
  for (OperatingPoint& p : crooked) p.log_rate_variance = {1e-4, 1e-4};
  const PowerLawFit known = fit_power_law(crooked);
  CHECK(known.lack == Approx(std::sqrt(0.04 / 2 - 1e-4)).epsilon(1e-3));
  CHECK(*known.p_of_law < 1e-10);

  // An error of x at the far end takes weight from it.
  crooked[3].log_x_variance = 4;
  CHECK(fit_power_law(crooked).exponent < plain.exponent);

  const PowerLawFit two = fit_power_law({points[0], points[2]});
  CHECK(two.exponent == Approx(0.8));
  CHECK((!two.exponent_ci95 && !two.held_out && !two.band_at(1)));
}

TEST_CASE("passing sizes are read between the sieves") {
  CHECK(passing_size({1, 10, 100}, {0, 0.5, 1}, 0.5) == Approx(10));
  CHECK(passing_size({1, 10, 100}, {0, 0.5, 1}, 0.75) == Approx(std::sqrt(1000)));
  CHECK(std::isnan(passing_size({1, 10}, {0.2, 0.5}, 0.8)));
  // Classes meet halfway in the logarithm.
  CHECK(passing_size_of_classes({1, 10, 100}, {20, 20, 20}, 0.5) == Approx(10));
  CHECK(passing_size_of_classes({1, 10, 100}, {30, 30, 40}, 0.6) == Approx(std::sqrt(1000)));
}

TEST_CASE("quern grinding fits rates and their law", "[cli]") {
  const GrindingFolder folder;
  const std::string file = folder.write("sizes.csv", three_runs(",E_i [mW]", {"a,1000", "b,2000", "c,3000"}));
  REQUIRE(folder.grind("'" + file + "' --no-pictures --out '" + (folder.path / "out").string() + "'") == 0);
  const nlohmann::json summary = folder.summary("out");
  CHECK(summary["rate_exponent_D80"]["value"].get<double>() == Approx(0.9).epsilon(1e-3));
  CHECK(summary["rate_factor_D80"]["value"].get<double>() == Approx(0.01).epsilon(1e-3));
  CHECK(summary["rate_factor_D80"]["unit"] == "1/s");
  CHECK_THAT(folder.read("out/kinetics.csv"), Catch::StartsWith("run,measure,E_i [W],K_p [1/s],K_p_from [1/s],K_p_to [1/s],D_0 [m],D_limit [m],"));
  CHECK_THAT(folder.read("out/power_law.csv"), Catch::StartsWith("measure,a [1/s],"));

  SECTION("one operating point: a rate and no law") {
    const std::string one = folder.write("one.csv", "t [s],D50 [um]\n0,100\n10,81\n20,68\n40,44\n");
    REQUIRE(folder.grind("'" + one + "' --limit 0 --no-pictures --out '" + (folder.path / "one").string() + "'") == 0);
    CHECK(folder.summary("one")["rate_constant_D50"]["value"].get<double>() == Approx(0.02).epsilon(0.05));
    CHECK(!folder.summary("one").contains("rate_exponent_D50"));
    const std::string same = folder.write("same.csv", three_runs(",E_i [W]", {"a,1", "b,1"}));
    REQUIRE(folder.grind("'" + same + "' --no-pictures --out '" + (folder.path / "same").string() + "'") == 0);
    CHECK_THAT(folder.read("log"), Catch::Contains("No power law for D80: it needs K_p at two or more values of E_i, and there is one."));
  }
  SECTION("an uncertain E_i weighs little, however its uncertainty is given") {
    // The third point lies off the law of the others; its E_i is hardly known.
    const std::vector<std::string> plain = {"a,1", "b,2", "c,4"};
    const auto exponent = [&](const std::string& text) {
      REQUIRE(folder.grind("'" + folder.write("uncertain.csv", text) + "' --no-pictures --out '" + (folder.path / "uncertain").string() + "'") == 0);
      return folder.summary("uncertain")["rate_exponent_D80"]["value"].get<double>();
    };
    const double trusted = exponent(three_runs(",E_i [W]", plain));
    const double sd = exponent(three_runs(",E_i [W],E_i_sd [mW]", {"a,1,10", "b,2,20", "c,4,4000"}));
    const double ends = exponent(three_runs(",E_i [W],E_i_from [W],E_i_to [W]", {"a,1,0.9804,1.0196", "b,2,1.9608,2.0392", "c,4,-3.84,11.84"}));
    CHECK(trusted < 0.8);
    const std::vector<std::string> alike = {"a,1,0.15", "b,2,0.3", "c,3,0.45"};
    exponent(three_runs(",E_i [W],E_i_sd [W]", alike));
    // Of equal errors of 15 %: two thirds of 0.0225 over the mean square of ln 1, ln 2 and ln 3 about their mean, 0.204: 7 %.
    CHECK_THAT(folder.read("log"), Catch::Contains("The errors of E_i flatten the law of D80: its exponent is nearer to 0 than it should be, by some 7 %."));
    CHECK(sd == Approx(0.9).margin(0.02));
    CHECK(ends == Approx(sd).margin(1e-3));
    CHECK(folder.grind("'" + folder.write("bad.csv", three_runs(",E_i [W],E_i_from [W],E_i_to [W]", {"a,1,2,3", "b,2,1,3", "c,3,2,4"})) + "'") == 2);
    CHECK_THAT(folder.read("log"), Catch::Contains("bad.csv:3: column E_i_from: the interval does not hold E_i, 1."));
  }
  SECTION("E_i comes from a sweep, by folder or by what was swept") {
    folder.write("sweep/sweep.csv",
                 "mill.speed [rad/s],power [W],impact_energy_rate [W],impact_energy_rate_from [W],impact_energy_rate_to [W],directory\n"
                 "31.41592653589793,9,3,2.9,3.1,fast\n10.471975511965976,5,1,0.9,1.1,slow\n20.943951023931952,7,2,,,middle\n");
    const std::string sweep = " --sweep '" + (folder.path / "sweep").string() + "' --no-pictures --out '" + (folder.path / "swept").string() + "'";
    for (const std::string& text : {three_runs("", {"slow", "middle", "fast"}), three_runs(",speed [rpm]", {"a,100", "b,200", "c,300"})}) {
      const std::string sizes = folder.write("swept.csv", text);
      REQUIRE(folder.grind("'" + sizes + "'" + sweep) == 0);
      CHECK(folder.summary("swept")["rate_exponent_D80"]["value"].get<double>() == Approx(0.9).epsilon(1e-3));
    }
    REQUIRE(folder.grind("'" + folder.write("swept.csv", three_runs("", {"slow", "middle", "fast"})) + "' --against power" + sweep) == 0);
    CHECK_THAT(folder.read("swept/kinetics.csv"), Catch::StartsWith("run,measure,power [W],"));
    const std::string other = folder.write("other.csv", three_runs(",speed [rpm]", {"a,100", "b,200", "c,301"}));
    CHECK(folder.grind("'" + other + "'" + sweep) == 2);
    CHECK_THAT(folder.read("log"), Catch::Contains("other.csv:13: c matches 0 of the 3 runs in"));

    // The folder alone, where the runs sieved themselves.
    const std::vector<std::string> names = {"slow", "middle", "fast"};
    for (std::size_t k = 0; k < names.size(); ++k) {
      std::string sizes = "t [s],D80 [m],D50 [m]\n";
      for (const double t : {0.0, 60.0, 120.0, 240.0, 480.0}) {
        const double left = std::exp(-0.01 * std::pow(static_cast<double>(k + 1), 0.9) * t);
        sizes += fmt::format("{},{},{}\n", t, (20 + 80 * left) * 1e-6, (10 + 80 * left) * 1e-6);
      }
      folder.write("sweep/" + names[k] + "/product_sizes.csv", sizes);
    }
    REQUIRE(folder.grind("'" + (folder.path / "sweep").string() + "/' --limit 'D80=20 um' --limit 'D50=10 um' --no-pictures --out '" + (folder.path / "own").string() + "'") == 0);
    for (const char* measure : {"D80", "D50"}) CHECK(folder.summary("own")[std::string("rate_exponent_") + measure]["value"].get<double>() == Approx(0.9).epsilon(1e-3));
    std::filesystem::remove(folder.path / "sweep/slow/product_sizes.csv");
    CHECK(folder.grind("'" + (folder.path / "sweep").string() + "'") == 2);
    CHECK_THAT(folder.read("log"), Catch::Contains("slow/product_sizes.csv: this file cannot be read"));
  }
}

TEST_CASE("quern grinding says in one line what is wrong with its input", "[cli]") {
  const GrindingFolder folder;
  const auto rows = [](const std::string& header, const std::string& body) { return header + "\n" + body; };
  struct Bad {
    std::string text, arguments, says;
  };
  const std::vector<Bad> all = {
      {rows("time [s],D80 [um]", "0,9\n1,8\n2,7\n"), "", "bad.csv:1: the column t is missing"},
      {rows("t [s],d [um]", "0,9\n1,8\n2,7\n"), "", "bad.csv:1: no column of sizes is there"},
      {rows("t,D80 [um]", "0,9\n1,8\n2,7\n"), "", "bad.csv:1: column t has no unit; write `t [s]`"},
      {rows("t [kg],D80 [um]", "0,9\n1,8\n2,7\n"), "", "bad.csv:1: the unit [kg] is not one of s or 1"},
      {rows("t [s],D80 [um]", "0,9\n"), "", "bad.csv:2: column D80: all has 1 of D80 at 1 time; 3 are needed where the limit is not known, or 2 with `D80_limit` or --limit."},
      {rows("t [s],D80 [um]", "0,9\n1,8\n"), "", "bad.csv:3: column D80: all has 2 of D80 at 2 times; 3 are needed"},
      {rows("t [s],D80 [um]", "0,9\n5,8\n2,7\n"), "", "bad.csv:4: column t: the times of all do not ascend: found 2 s after 5 s."},
      {rows("t [s],D80 [um]", "-1,9\n5,8\n7,7\n"), "", "bad.csv:2: column t: found -1; allowed are times from 0."},
      {rows("t [s],D80 [um]", "0,9\n1,10.1\n2,11\n3,12.1\n"), "", "bad.csv:5: column D80: the D80 of all grow, from 9 to 12.1 um;"},
      {rows("t [s],D80 [um]", "0,9\n1,9\n2,9\n3,9\n"), "", "bad.csv:5: column D80: the D80 of all are all the same;"},
      {rows("t [s],D80 [um]", "0,9\n1,x\n2,7\n"), "", "bad.csv:3: found \"x\" in column D80; allowed are finite numbers."},
      {rows("t [s],D80 [um]", "0,9\n1,-2\n2,7\n"), "", "bad.csv:3: column D80: allowed are sizes above 0."},
      {rows("t [s],D80 [um]", "0,9\n1\n2,7\n"), "", "bad.csv:3: found 1 cells; the header has 2."},
      {rows("t [s],D80 [um],D80_sd [um]", "0,9,1\n1,8,0\n2,7,1\n"), "", "bad.csv:3: column D80_sd: allowed are standard deviations above 0."},
      {rows("run,t [s],D80 [um],E_i [W]", "a,0,9,-1\na,1,8,-1\na,2,7,-1\n"), "", "bad.csv:2: column E_i: found -1; allowed are numbers above 0."},
      {rows("run,t [s],D80 [um],E_i", "a,0,9,1\na,1,8,1\na,2,7,1\n"), "", "bad.csv:1: column E_i has no unit; write `E_i [W]`."},
      {rows("run,t [s],D80 [um],E_i [W]", "a,0,9,1\na,1,8,2\na,2,7,1\n"), "", "bad.csv:3: column E_i: found 2 where a has 1 before; it must be the same in a run."},
      {rows("t [s],size [um]", "0,9\n"), "", "bad.csv:1: beside `size` the column `percent`"},
      {rows("t [s],size [um],finer", "0,9,0.5\n0,20,0.6\n"), "", "bad.csv:2: column finer: D80 of all at 0 s lies outside the sizes given."},
      {rows("t [s],D80 [um]", "0,9\n1,8\n2,7\n"), "--limit D50=3um", "--limit D50=3um: found D50; this file has D80."},
      {rows("t [s],D80 [um]", "0,9\n1,8\n2,7\n"), "--limit 12um", "bad.csv:4: column D80: the known limit of all, 12 um, is not below its largest D80, 9 um."},
      {rows("t [s],D80 [um]", "0,9\n1,8\n2,7\n"), "--limit=-1um", "--limit -1um: allowed is a size from 0."},
      {rows("t [s],D80 [um]", "0,9\n1,8\n2,7\n"), "--until 5kg", "--until 5kg: "},
      {rows("t [s],D80 [um],D80 [um]", "0,9,9\n1,8,8\n2,7,7\n"), "", "bad.csv:1: two columns are called D80; repeats are rows of the same time."},
      {rows("run,t [s],D80 [um]", "*,0,9\n"), "", "bad.csv: every row is of the run *"},
      {rows("t [s],D80 [um]", "0,9\n1,8\n2,7\n"), "--against speed", "--against speed: "},
      {rows("t [s],D80 [um]", "0,9\n1,8\n2,7\n"), "--sweep nowhere", "nowhere/sweep.csv: this file cannot be read"},
      {"t [s],D80 [um]\n", "", "bad.csv: this table is empty"},
  };
  for (const Bad& bad : all) {
    const std::string file = folder.write("bad.csv", bad.text);
    INFO(bad.text << bad.arguments);
    CHECK(folder.grind("'" + file + "' " + bad.arguments + " --out '" + (folder.path / "out").string() + "'") == 2);
    const std::string said = folder.read("log");
    INFO(said);
    CHECK_THAT(said, Catch::Contains(bad.says));
    CHECK(said.find('\n') == said.size() - 1);
    CHECK(!fs::exists(folder.path / "out"));
  }
}

TEST_CASE("quern validate holds fits to measured sizes against their bands", "[cli]") {
  const GrindingFolder folder;
  folder.write("case/sizes.csv", three_runs(",E_i [W]", {"a,1", "b,2", "c,3"}));
  const auto validate = [&](const std::string& run) {
    folder.write("case/check.toml", "source = \"made\"\n[[run]]\nname = \"a\"\n" + run +
                                        "\n[[figure]]\nname = \"b\"\nrun = \"a\"\nvalue = \"rate_exponent_D80\"\nreference = 0.9\nkind = \"closed form\"\nband = [0.89, 0.91]\n");
    const std::string command = std::string("'") + quern::program + "' validate '" + (folder.path / "case").string() + "' --out '" + (folder.path / "out").string() + "' > '" + (folder.path / "log").string() + "' 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  CHECK(validate("grinding = \"sizes.csv\"") == 0);
  CHECK_THAT(folder.read("log"), Catch::Contains("pass") && Catch::Contains("b: 0.9 ("));
  CHECK(validate("grinding = \"sizes.csv\"\nset = [\"mill.speed=1\"]") == 2);
  CHECK_THAT(folder.read("log"), Catch::Contains("check.toml:4: run.grinding: stands alone"));
  CHECK(validate("against = \"speed\"") == 2);
  CHECK_THAT(folder.read("log"), Catch::Contains("run.grinding: is missing"));
}

TEST_CASE("the measured kinetics of cases/kinetics_real come out as its page says", "[cli]") {
  const GrindingFolder folder;
  const std::string source = std::string(quern::source_directory) + "/cases/kinetics_real/";
  REQUIRE(folder.grind("'" + source + "shear_psd.csv' --against speed --limit 0 --no-pictures --out '" + (folder.path / "shear").string() + "'") == 0);
  const nlohmann::json shear = folder.summary("shear");
  CHECK(shear["rate_exponent_D80"]["value"].get<double>() == Approx(2.68).epsilon(0.01));
  CHECK(shear["series_not_first_order_D80"]["value"] == 3);
  CHECK(shear["series_not_first_order_D50"]["value"] == 4);
  REQUIRE(folder.grind("'" + source + "knife_mill_psd.csv' --against frequency --limit 0 --no-pictures --out '" + (folder.path / "knife").string() + "'") == 0);
  const nlohmann::json knife = folder.summary("knife");
  CHECK(knife["rate_exponent_D80"]["value"].get<double>() == Approx(0.245).epsilon(0.01));
  CHECK(knife["rate_exponent_D80"]["ci95"][0].get<double>() < 0);
}
