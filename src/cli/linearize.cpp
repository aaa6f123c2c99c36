#include "src/contact/linearize.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <cmath>
#include <memory>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/cli/commands.hpp"

namespace quern {
namespace {

struct LinearizeWords {
  double k = 0, q = 0, r = 1.6, s = 0.8;
  std::string mass, speed, height;
};

double read(const Units& units, const char* option, const std::string& text, const char* unit) {
  try {
    return units.read(text, unit);
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: {}.", option, e.what()));
  }
}

int print_linearization(const LinearizeWords& words) {
  const Units units;
  if (words.speed.empty() == words.height.empty()) throw InputError("quern linearize needs --speed or --height, one of the two.");
  const double mass = read(units, "--mass", words.mass, "kg");
  const double speed = words.speed.empty() ? std::sqrt(2 * 9.81 * read(units, "--height", words.height, "m")) : read(units, "--speed", words.speed, "m/s");
  if (!(speed > 0)) throw InputError("quern linearize: the height or speed must be more than 0.");
  const Linearization l = linearize(PowerLaw{words.k, words.r, words.q, words.s, 0, 0}, mass, speed);
  fmt::print("power law       F = k δ^{} + q δ^{} v, k = {:g} N/m^{}, q = {:g}\n", words.r, words.s, words.k, words.r, words.q);
  fmt::print("impact          {:g} kg at {:.4g} m/s, {:.4g} J\n", mass, speed, 0.5 * mass * speed * speed);
  fmt::print("stiffness k'    {:.4g} N/m\n", l.stiffness);
  fmt::print("damping q'      {:.5g} kg/s\n", l.damping);
  fmt::print("energy loss     {:.4g} J (power law), {:.4g} J (linearized)\n", l.loss, l.linear_loss);
  fmt::print("restitution     {:.4g} (power law), {:.4g} (linearized)\n", l.restitution, std::sqrt(std::max(0.0, 1 - 2 * l.linear_loss / (mass * speed * speed))));
  fmt::print("contact time    {:.4g} s\n", l.duration);
  return 0;
}

}  // namespace

void add_linearize(CLI::App& program, Action& action) {
  auto words = std::make_shared<LinearizeWords>();
  CLI::App* command = program.add_subcommand("linearize", "The linear spring and dashpot equivalent to a power law (Mishra & Murty 2001, eqs. 23–24)");
  command->add_option("-k,--stiffness", words->k, "k of F = k δ^r + q δ^s v [N/m^r]")->required();
  command->add_option("-q,--damping", words->q, "q [N s/m^(s+1)]")->required();
  command->add_option("-r,--stiffness-exponent", words->r, "r")->capture_default_str();
  command->add_option("-s,--damping-exponent", words->s, "s")->capture_default_str();
  command->add_option("-m,--mass", words->mass, "effective mass of the impact [kg], or a text such as \"96 g\"")->required();
  command->add_option("-v,--speed", words->speed, "speed of the impact [m/s]");
  command->add_option("--height", words->height, "instead of the speed: height of the drop [m]");
  command->callback([words, &action] { action = [words] { return print_linearization(*words); }; });
}

}  // namespace quern
