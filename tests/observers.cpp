#include "src/observe/observers.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <type_traits>

#include "scene.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

double value(const std::vector<Headline>& lines, const std::string& key) {
  for (const Headline& line : lines)
    if (line.key == key) return line.value;
  return NAN;
}

// A periodic drum of 0.2 m whose rough shell carries sixty balls.
Simulation drum(double speed, ObserverSettings& settings) {
  Simulation s = scene::free_space({"steel", 7800, 0, 0}, scene::linear(2e4, 0.5, 0.8), 5e-5);
  settings.mill = scene::add_drum(s, speed);
  for (int k = 0; k < 60; ++k) {
    const int layer = k / 15, place = k % 15;
    scene::add_ball(s, {-0.04 + 0.02 * (place % 5), 0.01 + 0.02 * (place / 5), -0.07 + 0.02 * layer}, 0.009, {0, 0, 0});
  }
  return s;
}

// Bytes in, bytes out.
struct Bytes {
  std::vector<char> data;
  std::size_t at = 0;
  bool reading = false;
  template <class... T>
  void operator()(T&... items) {
    (item(items), ...);
  }
  template <class T>
  void item(T& x) {
    if constexpr (std::is_trivially_copyable_v<T> && !requires { x.archive(*this); }) raw(&x, sizeof x);
    else x.archive(*this);
  }
  void item(std::string& s) {
    std::size_t n = s.size();
    item(n);
    s.resize(n);
    raw(s.data(), n);
  }
  template <class T>
  void item(std::vector<T>& v) {
    std::size_t n = v.size();
    item(n);
    v.resize(n);
    for (T& x : v) item(x);
  }
  template <class K, class V>
  void item(std::map<K, V>& m) {
    std::size_t n = m.size();
    item(n);
    if (reading) {
      m.clear();
      for (std::size_t k = 0; k < n; ++k) {
        K key;
        item(key);
        item(m[key]);
      }
      return;
    }
    for (auto& [key, value] : m) {
      K copy = key;
      item(copy);
      item(value);
    }
  }
  template <class T>
  void item(std::optional<T>& o) {
    bool there = o.has_value();
    item(there);
    if (there && !o) o.emplace();
    if (!there) o.reset();
    if (there) item(*o);
  }
  void raw(void* p, std::size_t n) {
    if (reading) {
      std::memcpy(p, data.data() + at, n);
      at += n;
    } else {
      data.insert(data.end(), static_cast<const char*>(p), static_cast<const char*>(p) + n);
    }
  }
};

}  // namespace

TEST_CASE("power by torque, by the walls' work and by the ledger agree in a drum that turns either way") {
  for (double speed : {8.0, -8.0}) {
    ObserverSettings settings;
    settings.start_time = 0.5;
    Simulation s = drum(speed, settings);
    s.start(true);
    Observers observers(settings);
    observers.see(s);
    while (s.clock.time() < 0.5) s.step(), observers.see(s);
    const double lost_before = s.ledger.dissipated();
    while (s.clock.time() < 2.0) s.step(), observers.see(s);
    observers.finish(s);
    const auto lines = observers.headlines();
    const double power = value(lines, "power");
    CHECK(power > 0);
    CHECK(value(lines, "torque") * 8.0 == Approx(power).epsilon(1e-9));
    CHECK(value(lines, "power_walls") == Approx(power).epsilon(2e-3));  // forces at the step's end against work over the step
    CHECK(value(lines, "power_ledger") == Approx(power).epsilon(5e-3));  // closure of the ledger
    CHECK(value(lines, "contact_power") == Approx((s.ledger.dissipated() - lost_before) / 1.5).epsilon(1e-3));  // the window is a step off
    CHECK(value(lines, "shell_force_vertical") == Approx(-9.81 * 60 * s.particles.mass(0)).epsilon(0.02));
    CHECK(value(lines, "toe_angle") < 200);
    CHECK(value(lines, "shoulder_angle") > 220);
    CHECK(value(lines, "bed_porosity") > 0.36);  // denser than any random packing it cannot be
    CHECK(value(lines, "bed_porosity") < 0.75);
  }
}

TEST_CASE("observers taken up from an archive go on as if nothing had been") {
  ObserverSettings settings;
  Simulation s = drum(8.0, settings);
  s.start(true);
  Observers unbroken(settings), broken(settings);
  unbroken.see(s);
  broken.see(s);
  const auto watch = [&](double until) {
    while (s.clock.time() < until) s.step(), unbroken.see(s), broken.see(s);
  };
  watch(0.2);
  Bytes bytes;
  broken.archive(bytes);
  Observers fresh(settings);
  bytes.reading = true;
  fresh.archive(bytes);
  CHECK(bytes.at == bytes.data.size());
  broken = fresh;
  watch(0.4);
  unbroken.finish(s);
  broken.finish(s);
  const auto a = unbroken.headlines(), b = broken.headlines();
  REQUIRE(a.size() == b.size());
  REQUIRE(a.size() > 15);
  for (std::size_t k = 0; k < a.size(); ++k) CHECK(a[k].value == b[k].value);
  const auto ta = unbroken.tables(), tb = broken.tables();
  REQUIRE(ta.size() == tb.size());
  for (std::size_t t = 0; t < ta.size(); ++t)
    for (std::size_t c = 0; c < ta[t].columns.size(); ++c) {
      CHECK(ta[t].columns[c].values == tb[t].columns[c].values);
      CHECK(ta[t].columns[c].labels == tb[t].columns[c].labels);
      CHECK(ta[t].columns[c].values.size() + ta[t].columns[c].labels.size() == ta[t].columns[0].values.size() + ta[t].columns[0].labels.size());
    }
}

TEST_CASE("torque is taken about the mill's axis, wherever the wall's origin is") {
  ObserverSettings settings;
  MillAxis mill;
  mill.centre = {1, 0.5, 0};
  mill.axis = Vec3::UnitZ();
  mill.speed = -3;
  settings.mill = mill;
  settings.power_interval = 0.1;
  Simulation s;
  s.clock.time_step = 0.01;
  Wall wall;
  wall.frame = 0;
  wall.pose.origin = {1, 2, 0};
  wall.pose.angular_velocity = {0, 0, -3};
  wall.force = {5, 0, 0};    // about the axis: 1.5 × 5 against +z
  wall.torque = {0, 0, 17};  // in all 9.5 about +z: braked by what is in it
  s.walls = {wall};
  TorquePower power;
  power.see(s, settings);
  for (s.clock.step = 1; s.clock.step <= 20; ++s.clock.step) power.see(s, settings);
  REQUIRE(power.torque.size() == 2);
  CHECK(power.torque[1] == Approx(17 - 7.5));
  CHECK(power.power[1] == Approx(3 * 9.5));
}

TEST_CASE("the amplitude spectrum finds a sine in its line, and its root mean square in the band") {
  std::vector<double> series;
  const double interval = 1e-3;
  for (int k = 0; k < 5000; ++k) {
    const double from = k * interval, to = from + interval;
    const auto integral = [](double t) { return -4 * std::cos(2 * pi * 120 * t) / (2 * pi * 120) - 50 * std::cos(2 * pi * 7 * t) / (2 * pi * 7); };
    series.push_back(1000 + (integral(to) - integral(from)) / interval);
  }
  const AmplitudeSpectrum spectrum = amplitude_spectrum(series, interval, 20, 150);
  REQUIRE(spectrum.frequency.size() == 131);
  const auto peak = std::max_element(spectrum.amplitude.begin(), spectrum.amplitude.end());
  CHECK(spectrum.frequency[static_cast<std::size_t>(peak - spectrum.amplitude.begin())] == Approx(120));
  CHECK(*peak == Approx(4).epsilon(1e-3));
  CHECK(spectrum.band_rms == Approx(4 / std::sqrt(2.0)).epsilon(1e-2));
}
