// Recordings as people hand them over: kinds, units, gaps, orientations, and what is refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <fmt/format.h>
#include "src/base/error.hpp"
#include "src/diagnose/recording.hpp"
#include "tests/folder.hpp"

using namespace quern;
using Catch::Contains;

namespace {

Recording read_text(const std::string& text) {
  const Folder folder("recordings");
  return read_recordings({folder.write("r.csv", text)});
}

std::string refusal_of(const std::string& text) {
  try {
    read_text(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a trajectory is read into SI units, with gaps, in the order of time", "[diagnose][recording]") {
  const Recording recording = read_text(
      "# a ball\n"
      "run,t [ms],z [mm],z_sd [mm],vx [cm/s],mass [g],held_out\n"
      "a,20,5,0.5,100,2.7,1\n"
      "a,10,7,0.5,,,\n"
      "b,0,1,1,3,4,0\n"
      "b,5,nan,1,4,,\n"
      "b,10,2,2,NA,,\n");
  CHECK(recording.kind == RecordingKind::trajectory);
  REQUIRE(recording.runs.size() == 2);
  const RecordedRun &a = recording.runs[0], &b = recording.runs[1];
  CHECK(a.label == "a");
  CHECK(a.held_out == std::optional(true));
  CHECK(b.held_out == std::optional(false));
  CHECK(a.conditions.at("mass") == Approx(2.7e-3));
  CHECK_THAT(a.where, Contains("r.csv:3"));
  const Series* z = a.find(Channel::z);
  REQUIRE(z != nullptr);
  REQUIRE(z->t.size() == 2);
  CHECK(z->t[0] == Approx(0.01));
  CHECK(z->t[1] == Approx(0.02));
  CHECK(z->value[0] == Approx(7e-3));
  CHECK(z->deviation[1] == Approx(5e-4));
  REQUIRE(a.find(Channel::vx)->t.size() == 1);
  CHECK(a.find(Channel::vx)->t[0] == Approx(0.02));
  CHECK(a.find(Channel::vx)->value[0] == Approx(1));
  CHECK(b.find(Channel::z)->t.size() == 2);
  CHECK(b.find(Channel::vx)->t.size() == 2);
  CHECK(a.first_time() == Approx(0.01));
  CHECK(b.last_time() == Approx(0.01));
}

TEST_CASE("contacts, impact times and conditions that are keys of the case are told by their columns", "[diagnose][recording]") {
  const Recording contact = read_text("run,t [us],force [kN],displacement [um],impact_speed [m/s],impact_angle [deg],medium.density [g/cm3]\n1,0,0,0,2,30,1\n1,5,0.25,8,,,\n");
  CHECK(contact.kind == RecordingKind::contact);
  CHECK(contact.runs[0].find(Channel::force)->value[1] == Approx(250));
  CHECK(contact.runs[0].find(Channel::displacement)->value[1] == Approx(8e-6));
  CHECK(contact.runs[0].conditions.at("impact_angle") == Approx(M_PI / 6));
  CHECK(contact.runs[0].conditions.at("medium.density") == Approx(1000));
  // In the order of time; an impact that was missed is a gap in the numbers. Without run and units: one run, in SI units.
  const Recording impacts = read_text("impact,t [ms],t_sd [ms]\n2,90,0.1\n1,50,0.2\n4,130,0.1\n");
  CHECK(impacts.kind == RecordingKind::impacts);
  REQUIRE(impacts.runs.size() == 1);
  const Series& series = impacts.runs[0].series.front();
  CHECK(series.t == std::vector<double>{1, 2, 4});
  CHECK(series.value[2] == Approx(0.13));
  CHECK(series.deviation[0] == Approx(2e-4));
  CHECK(impacts.runs[0].last_time() == Approx(0.13));
}

TEST_CASE("the turning of an orientation is its mean spin between two samples, whichever sign the quaternions have", "[diagnose][recording]") {
  const double spin = 40;  // about y
  std::string text = "t [s],qw,qx,qy,qz\n";
  for (int k = 0; k < 30; ++k) {
    if (k == 7) continue;  // a gap
    const double half = 0.5 * spin * 0.01 * k, scale = k % 3 == 0 ? -1.02 : 1.0;
    text += fmt::format("{:.2f},{:.6f},0,{:.6f},0\n", 0.01 * k, scale * std::cos(half), scale * std::sin(half));
  }
  text += "0.30,,,,\n";
  const Recording recording = read_text(text);
  const Series* wy = recording.runs[0].find(Channel::wy);
  REQUIRE(wy != nullptr);
  CHECK(wy->t.size() == 28);
  CHECK(wy->t[0] == Approx(0.005));
  // Two orientations of six decimals, 0.01 s apart.
  for (const double w : wy->value) CHECK(w == Approx(spin).margin(2 * 2e-6 / 0.01));
  for (const double w : recording.runs[0].find(Channel::wx)->value) CHECK(std::abs(w) < 1e-3);
  CHECK(recording.remarks.size() == 1);
}

TEST_CASE("several files are one recording of one kind", "[diagnose][recording]") {
  const Folder folder("recordings");
  const std::string a = folder.write("a.csv", "run,t [s],z [m]\na,0,1\n"), b = folder.write("b.csv", "run,t [s],x [m],z [m]\nb,0,1,2\n");
  const std::string contact = folder.write("c.csv", "run,t [s],force [N]\nc,0,1\n");
  CHECK(read_recordings({a, b}).runs.size() == 2);
  CHECK_THROWS_WITH(read_recordings({a, a}), Contains("a.csv:1") && Contains("run a stands in another file too"));
  CHECK_THROWS_WITH(read_recordings({a, contact}), Contains("c.csv:1") && Contains("a contact") && Contains("files of one kind"));
  CHECK_THROWS_WITH(read_recordings({folder.path.string()}), Contains("cannot be read"));
}

TEST_CASE("a bad recording is refused with one sentence that says where and what", "[diagnose][recording]") {
  struct Bad {
    const char *text, *where, *what;
  };
  const Bad bad[] = {
      {"", "r.csv", "empty"},
      {"t [s],z [m]\n", "r.csv", "empty"},
      {"z [m]\n1\n", "r.csv:1", "no column t [s]"},
      {"# c\nt [s],u [m]\n0,1\n", "r.csv:2", "found the column u"},
      {"t [s],froce [N]\n0,1\n", "r.csv:1", "did you mean force?"},
      {"t [s],z [kg]\n0,1\n", "r.csv:1", "[kg]"},
      {"t [s],z [m],z [m]\n0,1,2\n", "r.csv:1", "two columns z"},
      {"t [s],z [m],force [N]\n0,1,2\n", "r.csv:1", "columns of one kind"},
      {"t [s],mass [kg]\n0,1\n", "r.csv:1", "columns of one kind"},
      {"t [s],z [m]\n0,1\n1,2,3\n", "r.csv:3", "found 3 cells"},
      {"t [s],z [m]\n0,1\n1,two\n", "r.csv:3", "\"two\""},
      {"t [s],z [m]\n0,1\n1,inf\n", "r.csv:3", "finite"},
      {"t [s],z [m]\n0,1\n,2\n", "r.csv:3", "allowed is a time"},
      {"run,t [s],z [m]\n,0,1\n", "r.csv:2", "label of a run"},
      {"run,t [s],z [m]\na,0,\n", "r.csv:2", "holds no numbers"},
      {"t [s],z [m],z_sd [m]\n0,1,0\n", "r.csv:2", "standard deviation above 0"},
      {"t [s],z [m],z_sd [m]\n0,1,0.1\n1,1,\n", "r.csv:3", "standard deviation above 0"},
      {"t [s],z [m],held_out\n0,1,2\n", "r.csv:2", "0 and 1"},
      {"t [s],z [m],held_out\n0,1,0\n1,1,1\n", "r.csv:3", "held out whole or not at all"},
      {"t [s],z [m],mass [kg]\n0,1,1\n1,1,2\n", "r.csv:3", "two values within run"},
      {"t [s],impact\n0,1.5\n", "r.csv:2", "number of the impact"},
      {"t [s],impact\n0,2\n1,1\n", "r.csv:3", "grow with the time"},
      {"t [s],qw,qx,qz\n0,1,0,0\n", "r.csv", "all four or none"},
      {"t [s],qw,qx,qy,qz\n0,1,0,0,0\n1,9,0,0,0\n", "r.csv:3", "far from length 1"},
  };
  for (const Bad& one : bad) {
    INFO(one.text);
    const std::string words = refusal_of(one.text);
    INFO(words);
    CHECK_THAT(words, Contains(one.where) && Contains(one.what));
    CHECK(words.find('\n') == words.npos);
    REQUIRE_FALSE(words.empty());
    CHECK((words.back() == '.' || words.back() == '?'));
  }
}
