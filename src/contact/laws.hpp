// The list of contact laws. A new law is one header in laws/ and one word here.
#pragma once
#include <variant>
#include "src/contact/extras.hpp"
#include "src/contact/laws/deresiewicz.hpp"
#include "src/contact/laws/hertz_mindlin.hpp"
#include "src/contact/laws/linear.hpp"
#include "src/contact/laws/linearized.hpp"
#include "src/contact/laws/power_law.hpp"
#include "src/contact/rolling.hpp"

namespace quern {

using ContactLaw = std::variant<Linear, HertzMindlin, Deresiewicz, PowerLaw, Linearized>;

// All that two materials do to each other. The same whichever of them is the ball and whichever the wall.
struct PairLaw {
  ContactLaw law;
  Rolling rolling;
  Extras extras;
  double reach = 0;  // how far beyond touch it acts [m]; Simulation::start fills it in
};

}  // namespace quern
