// Oblique impacts as measured: a 5 mm alumina ball on a glass anvil at 3.9 m/s (Kharaz, Gorham & Salman 2001, Powder Technology 120,
// 281–291), in the set-up of Chung & Ooi (2011), test 4: ball of 380 GPa on a rigid plane, μ = 0.092, e = 0.98.
#include <catch2/catch.hpp>
#include "tests/scene.hpp"

using namespace quern;

namespace {

struct Point {
  double angle, spin;  // from the normal [deg]; after the impact [rad/s]
};

// Digitized by others from the figure of Kharaz et al.
constexpr Point measured[] = {{5.90, 134.9},  {10.87, 261.2}, {21.12, 573.7}, {31.14, 612.2}, {38.95, 595.1},
                              {50.24, 449.5}, {60.10, 375.7}, {69.96, 243.0}, {78.56, 142.4}, {84.32, 70.6}};
// The codes of Chung & Ooi (2011), aluminium oxide.
constexpr Point codes[] = {{4.95, 19.27},  {10.08, 213.0}, {14.97, 377.8}, {19.94, 510.6}, {24.91, 599.4}, {29.96, 616.5}, {34.93, 582.3},
                           {39.98, 544.8}, {50.0, 457.0},  {60.02, 357.5}, {69.96, 246.2}, {80.06, 126.3}, {85.03, 63.15}};

double codes_at(double angle) {
  for (std::size_t k = 1; k < std::size(codes); ++k)
    if (angle <= codes[k].angle)
      return codes[k - 1].spin + (codes[k].spin - codes[k - 1].spin) * (angle - codes[k - 1].angle) / (codes[k].angle - codes[k - 1].angle);
  return codes[std::size(codes) - 1].spin;
}

double spin_after(const ContactLaw& law, const Material& ball, double angle) {
  const double radius = 0.0025, speed = 3.9, a = angle * 0.017453292519943295;
  Simulation s = scene::free_space(ball, {law, {}}, 1e-8);
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, radius + 1e-8}, radius, {speed * std::sin(a), 0, -speed * std::cos(a)});
  s.start(false);
  scene::run_collision(s);
  return s.particles.spin[0].y;
}

}  // namespace

TEST_CASE("the measured spin after oblique impacts is met: by Deresiewicz closer than by the published codes, by Mindlin as by them") {
  const Material alumina{"alumina", 4000, 3.8e11, 0.23}, rigid{"rigid", 4000, 1e22, 0.23};
  const ContactLaw mindlin = HertzMindlin{effective_young(alumina, rigid), effective_shear(alumina, rigid), hertz_damping_ratio(0.98), 0.092};
  const ContactLaw deresiewicz = Deresiewicz{effective_young(alumina, rigid), 0, 0.092 * (2 - 0.23) / (2 * (1 - 0.23)), 0.092};
  double of_deresiewicz = 0, of_codes = 0;
  for (const Point& m : measured) {
    CAPTURE(m.angle, m.spin);
    const double ours = spin_after(mindlin, alumina, m.angle), other = spin_after(deresiewicz, alumina, m.angle), theirs = codes_at(m.angle);
    of_deresiewicz += (other - m.spin) * (other - m.spin);
    of_codes += (theirs - m.spin) * (theirs - m.spin);
    // Beyond 15° the Mindlin law of quern and that of the codes are one within the reading of the figure, some 3 %. Nearer to the
    // normal, where all codes miss the measurement by half, ours shortens the spring as the contact stiffens and the codes do not.
    if (m.angle > 15) CHECK(ours == Approx(theirs).epsilon(0.04));
  }
  CHECK(std::sqrt(of_deresiewicz) < 0.7 * std::sqrt(of_codes));  // 18 rad/s against 33 rad/s, root mean square
}
