#include "src/cli/soften.hpp"
#include <fmt/format.h>
#include <cmath>
#include <filesystem>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/case/softening.hpp"
#include "src/cli/points.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct Prepared {
  Case c;
  SoftRun run;
  Index particles = 0;
};

Prepared prepare(const std::string& file, const std::vector<std::string>& overrides) {
  Prepared p{read_case(file, overrides), {}, 0};
  const Built built = build_case(p.c);
  p.run.time_step = built.simulation.clock.time_step;
  p.run.limit = built.limit.limit;
  p.run.steps = std::ceil(p.c.duration / p.run.time_step);
  p.particles = built.simulation.particles.owned;
  return p;
}

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

void print_run(const char* name, const SoftRun& run) {
  fmt::print("{:10}  time step {:.4g} s, {:.3g} of its limit; {:.0f} steps\n", name, run.time_step, run.time_step / run.limit, run.steps);
}

}  // namespace

int soften(const SoftenWords& words) {
  // Neither run draws; both watch contacts, or there would be no overlap to tell of.
  std::vector<std::string> common = joined(words.overrides, {"output.pictures=false", "output.paraview=false", "output.trajectory=false", "output.frames=0", "observe.spectrum=true"});
  Prepared as_is = prepare(words.file, common);
  SoftReport report;
  report.factor = words.factor;
  constexpr Index few = 10;
  report.exact = !as_is.c.mill && as_is.particles <= few;
  if (report.exact) {
    std::vector<int> all(static_cast<std::size_t>(as_is.particles));
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
    common.push_back(fmt::format("observe.track=[{}]", fmt::join(all, ", ")));
    as_is = prepare(words.file, common);
  }
  std::vector<std::string> soft_overrides = joined(common, softened(as_is.c, words.factor));
  Prepared softer = prepare(words.file, soft_overrides);
  if (as_is.c.time_step) {
    soft_overrides.push_back(fmt::format("time_step.value={}", *as_is.c.time_step * softer.run.limit / as_is.run.limit));
    softer = prepare(words.file, soft_overrides);
  }
  report.as_is = as_is.run;
  report.softer = softer.run;

  const std::string directory = words.directory.empty() ? "out/" + as_is.c.name + "_soften" : words.directory;
  std::error_code problem;
  fs::create_directories(directory, problem);
  if (problem) throw InputError(fmt::format("{}: this directory cannot be made: {}.", directory, problem.message()));

  fmt::print("Case        {}, {:.4g} s, {} particles\n", as_is.c.name, as_is.c.duration, as_is.particles);
  print_run("As it is", report.as_is);
  print_run("Softer", report.softer);
  if (!as_is.c.bonds.empty()) fmt::print("Bonds       are not softened: the energy at which they fail, and with it what breaks, follows from their stiffness.\n");
  std::fflush(stdout);
  const std::string softer_name = fmt::format("softer_{:.6g}", words.factor);
  std::vector<Point> points = {{words.file, common, (fs::path(directory) / "as_is").string(), as_is.c.text, false, 0, 0, "as it is"},
                               {words.file, soft_overrides, (fs::path(directory) / softer_name).string(), softer.c.text, false, 0, 0, "softer"}};
  if (const std::size_t kept = keep_finished(points); kept > 0) fmt::print("{} of 2 runs are finished already and are kept.\n", kept);
  // One after the other: their speeds are compared.
  constexpr int at_a_time = 1;
  if (const int status = run_points(points, at_a_time, [] {}, words.threads); status != 0) return status;

  compare(report, points[0].directory, points[1].directory);
  const fs::path folder(directory);
  write_aside((folder / "soften.json").string(), softening_json(report));
  write_aside((folder / "soften.csv").string(), softening_csv(report));
  constexpr double worth_comparing = 0.5;  // [s]; shorter runs are mostly their own beginning
  fmt::print("Speed       {:.3g} times fewer steps", report.as_is.steps / report.softer.steps);
  if (report.as_is.wall_clock > worth_comparing)
    fmt::print("; {:.3g} s instead of {:.3g} s, {:.3g} times as fast", report.softer.wall_clock, report.as_is.wall_clock, report.as_is.wall_clock / report.softer.wall_clock);
  fmt::print("\n\n");
  fmt::print("{}\n", softening_table(report));
  for (const std::string& warning : report.warnings) fmt::print("Warning     {}\n", warning);
  fmt::print("{}\n", softening_sentence(report));
  fmt::print("The table is in {} and soften.json\n", (folder / "soften.csv").string());
  return 0;
}

}  // namespace quern
