// The example of docs/extending.md compiles, works, and is the text of that page.
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>
#include "src/base/triple.hpp"
#include "tests/extending_law.hpp"
#include "tests/places.hpp"

using namespace quern;

namespace {

std::string text_of(const std::string& file) {
  std::ifstream in(std::string(quern::source_directory) + "/" + file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("the example law of the documentation is the one that is compiled and collides as its closed form says") {
  REQUIRE(text_of("docs/extending.md").find("```cpp\n" + text_of("tests/extending_law.hpp") + "```") != std::string::npos);
  // Greatest overlap of k δ²: ½ m v² = k δ³/3.
  const Quadratic law{1e9, 0, 0};
  const double mass = 0.01, speed = 2, dt = 1e-8;
  double overlap = 0, closing = speed, greatest = 0;
  for (int step = 0; step < 100000 && overlap >= 0; ++step) {
    TangentialSpring<double> spring{};
    const Approach<double> approach = head_on(overlap, -closing, 0.01, mass, dt);
    closing -= dt * act(law, approach, spring).normal / mass;
    overlap += dt * closing;
    greatest = std::max(greatest, overlap);
  }
  CHECK(greatest == Approx(std::cbrt(1.5 * mass * speed * speed / 1e9)).epsilon(1e-4));
  CHECK(closing == Approx(-speed).epsilon(1e-4));
}
