#include "bench/options.hpp"
#include <CLI/CLI.hpp>

namespace bench {

Options read_options(int argc, char** argv) {
  Options o;
  CLI::App app{"Times quern's engine on a rotating drum, a resting bed of 10 mm balls, or an agglomerate that hits a wall"};
  app.add_option("--work", o.work, "drum, bed or agglomerate")->check(CLI::IsMember({"drum", "bed", "agglomerate"}))->capture_default_str();
  app.add_option("--balls", o.balls, "number of balls")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--threads", o.threads, "threads")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--steps", o.steps, "timed steps")->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--warm", o.warm, "steps before the timed ones")->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--isa", o.isa, "portable, avx2 or avx512 (default: the best of this processor)");
  app.add_option("--mesh", o.mesh, "triangles of the drum's wall; 0: a cylinder")->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--settle", o.settle, "seconds simulated before anything else")->check(CLI::NonNegativeNumber)->capture_default_str();
  app.add_option("--copies", o.copies, "settle the drum with 1/copies of its balls and set copies side by side")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--sample", o.sample, "steps between readings of energy, contacts and torque; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--start", o.start, "LAMMPS data file to begin from")->check(CLI::ExistingFile);
  app.add_option("--write", o.write, "LAMMPS data file of the state after settling");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::exit(app.exit(e));
  }
  return o;
}

}  // namespace bench
