#include "src/base/units.hpp"
#include <catch2/catch.hpp>
#include "src/base/error.hpp"

using namespace quern;

TEST_CASE("A quantity with its unit is read into SI", "[units]") {
  const Units units;
  CHECK(units.read("54.5 cm", "m") == Approx(0.545).epsilon(1e-14));
  CHECK(units.read("206 GPa", "Pa") == Approx(206e9).epsilon(1e-14));
  CHECK(units.read("0.5 %", "1") == Approx(0.005).epsilon(1e-14));
  CHECK(units.read("7.8 g/cm3", "kg/m3") == Approx(7800).epsilon(1e-14));
  CHECK(units.read("400kN/m", "N/m") == Approx(4e5).epsilon(1e-14));
  CHECK(units.read(" +1.5e-3 ", "s") == 1.5e-3);
  CHECK(units.read("20 µm", "m") == Approx(2e-5).epsilon(1e-14));
  CHECK(units.read("-3 mm", "m") == Approx(-3e-3).epsilon(1e-14));
}

TEST_CASE("A revolution per minute is 2π/60 rad/s, a degree π/180 rad", "[units]") {
  const Units units;
  const double pi = 3.14159265358979323846;
  for (const char* speed : {"60 rpm", "60 rev/min", "1 rev/s", "360 deg/s", "60 revolution/min"}) CHECK(units.read(speed, "rad/s") == Approx(2 * pi).epsilon(1e-14));
  for (const char* angle : {"180 deg", "180 degree", "180°", "0.5 turn"}) CHECK(units.read(angle, "rad") == Approx(pi).epsilon(1e-14));
}

TEST_CASE("A unit of another kind is refused with what was found and what is allowed", "[units]") {
  const Units units;
  CHECK_THROWS_WITH(units.read("54.5 kg", "m"), Catch::Contains("\"54.5 kg\"") && Catch::Contains("54.5 cm"));
  CHECK_THROWS_WITH(units.read("3 parsnips", "m"), Catch::Contains("\"parsnips\" is not known"));
  for (const char* wrong : {"5 Hz", "5 1/s", "5 m/s", "5 min"}) CHECK_THROWS_AS(units.read(wrong, "rad/s"), InputError);
  for (const char* wrong : {"", "cm", "nan", "inf m", "1e999 m", "1 dB", "2 1/m", "1..2 m", "0x10 m"}) CHECK_THROWS_AS(units.read(wrong, "m"), InputError);
  for (const char* wrong : {"30 deg", "1 rad", "1 m"}) CHECK_THROWS_AS(units.read(wrong, "1"), InputError);
}
