// What a run writes: it must read back as it was, be whole at every moment, and be found where the documentation says.
#include <hdf5.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include "src/base/error.hpp"
#include "src/base/random.hpp"
#include "src/engine/simulation.hpp"
#include "src/observe/observers.hpp"
#include "src/output/chart.hpp"
#include "src/output/ledger_table.hpp"
#include "src/output/pictures.hpp"
#include "src/output/results_file.hpp"
#include "src/output/run.hpp"
#include "src/output/tables.hpp"
#include "src/output/vtk_frames.hpp"
#include "src/output/wall_facets.hpp"

using namespace quern;
namespace fs = std::filesystem;

namespace {

// A directory of its own that goes when the test ends.
struct Scratch {
  std::string path;
  Scratch() {
    std::string name = (fs::temp_directory_path() / "quern_output_XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Scratch() { fs::remove_all(path); }
  std::string operator/(const std::string& file) const { return path + "/" + file; }
};

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream all;
  all << file.rdbuf();
  return all.str();
}

// Balls falling in a drum across gravity; linear contacts.
Simulation drum(int balls) {
  Simulation s;
  s.materials = {{"steel", 7800, 0, 0}};
  s.species = {{"ball", 0}};
  s.pair_laws = {PairLaw{Linear{}, Rolling{}}};
  s.pair_kind = {0};
  Linear law;
  law.normal_stiffness = 1e5;
  s.pair_laws[0].law = law;
  s.clock.time_step = 1e-5;
  Wall shell;
  shell.name = "shell";
  shell.surface = Revolved{0.1, -0.05, 0.1, 0.05, Revolved::Side::inside};
  shell.rest.axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  Wall front = shell, back = shell;
  front.surface = Revolved{0, -0.05, 0.1, -0.05, Revolved::Side::both};
  back.surface = Revolved{0, 0.05, 0.1, 0.05, Revolved::Side::both};
  s.frames = {{"turn", -1, Rotating{Vec3::Zero(), Vec3::UnitY(), 5.0}}};
  for (Wall* wall : {&shell, &front, &back}) {
    wall->frame = 0, wall->pose = wall->rest;
    s.walls.push_back(*wall);
  }
  RandomStream random(7);
  for (int k = 0; k < balls; ++k) {
    const double x = -0.06 + 0.02 * (k % 7), y = -0.03 + 0.02 * (k / 7 % 4), z = -0.05 + 0.02 * (k / 28);
    s.particles.add_sphere({x, y, z}, 0.006 + 0.002 * random.uniform(), 7800, 0, 0);
  }
  return s;
}

ObserverSettings nothing() {
  ObserverSettings settings;
  settings.power = settings.shell_force = settings.spectrum = settings.charge = false;
  return settings;
}

OutputSettings plain() {
  OutputSettings settings;
  settings.name = "drum";
  settings.case_text = "name = \"drum\"\n";
  settings.pictures = false;
  return settings;
}

RunOptions into(const Scratch& scratch) {
  RunOptions options;
  options.directory = scratch / "out";
  options.quiet = true;
  return options;
}

// Reading with HDF5 alone, as a user would.
std::vector<double> read(const std::string& path, const std::string& set, std::vector<hsize_t>* extent = nullptr) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  REQUIRE(file >= 0);
  const hid_t data = H5Dopen2(file, set.c_str(), H5P_DEFAULT);
  REQUIRE(data >= 0);
  const hid_t space = H5Dget_space(data);
  std::vector<hsize_t> dims(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  if (!dims.empty()) H5Sget_simple_extent_dims(space, dims.data(), nullptr);
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  REQUIRE(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
  if (extent) *extent = dims;
  H5Sclose(space), H5Dclose(data), H5Fclose(file);
  return values;
}

std::string read_text(const std::string& path, const std::string& set, const char* attribute = nullptr) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  REQUIRE(file >= 0);
  const hid_t object = H5Oopen(file, set.c_str(), H5P_DEFAULT);
  REQUIRE(object >= 0);
  const hid_t source = attribute ? H5Aopen(object, attribute, H5P_DEFAULT) : object;
  REQUIRE(source >= 0);
  const hid_t type = attribute ? H5Aget_type(source) : H5Dget_type(source);
  std::string text(H5Tget_size(type), '\0');
  if (attribute) H5Aread(source, type, text.data()), H5Aclose(source);
  else H5Dread(source, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data());
  H5Tclose(type), H5Oclose(object), H5Fclose(file);
  return text;
}

}  // namespace

TEST_CASE("a CSV has units in its header and numbers that read back to the same bits") {
  Table table{"t", "", {{"time", "s", "", {0.1, 1.0 / 3, 1e-300}, {}}, {"pair", "1", "", {}, {"a,b", "say \"c\"", "d"}},
                        {"fraction", "1", "", {std::numeric_limits<double>::quiet_NaN(), -0.0, 2}, {}}}};
  const std::string text = csv_of(table);
  CHECK(text.substr(0, text.find('\n')) == "time [s],pair,fraction");
  CHECK(text.find("0.1,\"a,b\",\n") != std::string::npos);
  CHECK(text.find("\"say \"\"c\"\"\"") != std::string::npos);
  std::istringstream lines(text);
  std::string line;
  for (const double expected : {-1.0, 0.1, 1.0 / 3, 1e-300}) {
    REQUIRE(std::getline(lines, line));
    if (expected > 0) CHECK(std::stod(line) == expected);
  }
}

TEST_CASE("summary numbers carry unit and interval, and what is not a number is null") {
  const auto json = nlohmann::json::parse(json_of({{"power", 1930.5, "W", std::array{1900.0, 1961.0}, "of the drive"},
                                                   {"toe_angle", std::numeric_limits<double>::quiet_NaN(), "deg", std::nullopt, ""}}));
  CHECK(json["power"]["value"] == 1930.5);
  CHECK(json["power"]["unit"] == "W");
  CHECK(json["power"]["ci95"] == nlohmann::json::array({1900.0, 1961.0}));
  CHECK(json["toe_angle"]["value"].is_null());
  CHECK_FALSE(json["toe_angle"].contains("ci95"));
}

TEST_CASE("a frame gives each particle the row of its id, whatever the order in memory, also of those that joined late") {
  const Scratch scratch;
  Simulation s = drum(10);
  const std::string path = scratch / "results.h5";
  {
    ResultsFile file(path, s, "", "");
    file.append_frame(s);
    s.particles.reorder({9, 3, 1, 0, 2, 4, 8, 7, 6, 5});
    s.particles.add_sphere({0.5, 0.25, 0.125}, 0.004, 1000, 0, 0);
    ++s.clock.step;
    file.append_frame(s);
  }
  std::vector<hsize_t> extent;
  const std::vector<double> position = read(path, "particles/balls/position/value", &extent);
  REQUIRE(extent == std::vector<hsize_t>{2, 11, 3});
  for (std::size_t i = 0; i < 11; ++i) {
    const auto row = static_cast<std::size_t>(s.particles.id[i]);
    CHECK(position[(11 + row) * 3 + 1] == s.particles.position[i].y);
    if (row < 10) CHECK(position[row * 3 + 1] == s.particles.position[i].y);
  }
  CHECK(std::isnan(position[10 * 3]));
  CHECK(read(path, "particles/balls/id/value")[10] == -1);
  CHECK(read(path, "particles/balls/radius")[10] == 0.004);
  CHECK(read(path, "particles/balls/velocity/step") == std::vector<double>{0, 1});
  CHECK(read(path, "particles/balls/position/time") == std::vector<double>{0, 1e-5});
}

TEST_CASE("a run killed in the middle of writing leaves a file that holds every finished frame") {
  const Scratch scratch;
  const std::string path = scratch / "results.h5";
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    Simulation s = drum(60);
    ResultsFile file(path, s, "", "name = \"killed\"\n");
    Table energy = empty_ledger_table();
    for (s.clock.step = 0; s.clock.step < 40; ++s.clock.step) {
      file.append_frame(s);
      append_row(energy, s.clock.time(), s.ledger);
      file.append_rows(energy, energy.columns[0].values.size() - 1);  // never flushed by itself
    }
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));
  std::vector<hsize_t> extent;
  read(path, "particles/balls/position/value", &extent);
  CHECK(extent == std::vector<hsize_t>{40, 60, 3});
  CHECK(read(path, "particles/balls/id/step").back() == 39);
  CHECK(read(path, "observables/energy/time").size() == 39);
  CHECK(read_text(path, "parameters/case") == "name = \"killed\"\n");
}

TEST_CASE("a writer killed at any moment leaves a file that goes on from its last whole state") {
  const Scratch scratch;
  const std::string path = scratch / "results.h5", text = "name = \"killed\"\n";
  RandomStream random(3);
  std::uint64_t frames = 0;
  int begun[2];  // the writer tells through it that its first frame is written
  REQUIRE(pipe(begun) == 0);
  for (int round = 0; round < 40; ++round) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      Simulation s = drum(60);
      ResultsFile file = frames == 0 ? ResultsFile(path, s, "", text) : ResultsFile::reopen(path, text, frames, 60);
      Table energy = empty_ledger_table();
      for (s.clock.step = static_cast<std::int64_t>(frames);; ++s.clock.step) {
        append_row(energy, s.clock.time(), s.ledger);
        file.append_rows(energy, energy.columns[0].values.size() - 1);
        s.particles.position[0].x = static_cast<double>(s.clock.step);
        file.append_frame(s);
        if (s.clock.step == static_cast<std::int64_t>(frames) && ::write(begun[1], "x", 1) != 1) _exit(1);
      }
    }
    char byte;
    REQUIRE(::read(begun[0], &byte, 1) == 1);
    usleep(static_cast<useconds_t>(5000 * random.uniform()));
    kill(child, SIGKILL);
    REQUIRE(waitpid(child, nullptr, 0) == child);
    { const ResultsFile again = ResultsFile::reopen(path, text, 1, 60); }  // drops all but the first frame
    frames = 1;
    std::vector<hsize_t> extent;
    const std::vector<double> position = read(path, "particles/balls/position/value", &extent);
    REQUIRE(extent == std::vector<hsize_t>{1, 60, 3});
    CHECK(position[0] == 0);
    CHECK_FALSE(fs::exists(path + ".journal"));
  }
}

TEST_CASE("what cannot be written leaves the results as they last were, and says which file and why") {
  const Scratch scratch;
  const std::string path = scratch / "results.h5";
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    Simulation s = drum(60);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{200000, 200000};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::string said;
    try {
      ResultsFile file(path, s, "", "");
      for (;; ++s.clock.step) file.append_frame(s);
    } catch (const WriteError& error) {
      said = error.what();
    }
    _exit(said == "The file " + path + " cannot be written: File too large." ? 0 : 1);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  std::vector<hsize_t> extent;
  const std::vector<double> position = read(path, "particles/balls/position/value", &extent), step = read(path, "particles/balls/id/step");
  REQUIRE(extent[0] > 10);
  CHECK(step.size() == extent[0]);
  CHECK(step.back() == static_cast<double>(extent[0] - 1));
  CHECK(std::none_of(position.begin(), position.end(), [](double x) { return std::isnan(x); }));
}

TEST_CASE("a run writes what the documentation promises, in the H5MD layout") {
  const Scratch scratch;
  Simulation s = drum(28);
  Observers observers(nothing());
  s.start(observers.needs_collisions());
  OutputSettings settings = plain();
  settings.frame_interval = 2e-3;
  settings.energy_interval = 1e-3;
  settings.headlines = {{"critical_speed", 1.5, "rad/s", std::nullopt, ""}};
  const RunSummary summary = run_simulation(s, observers, settings, into(scratch), 0.01);
  CHECK(summary.finished);
  CHECK(summary.time == Approx(0.01));
  CHECK(summary.steps == 1000);
  const std::string out = scratch / "out/";
  for (const char* file : {"case.toml", "summary.json", "energy.csv", "results.h5", "frames.pvd", "frames/balls_000005.vtp", "frames/walls_000005.vtp"})
    CHECK(fs::exists(out + file));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(out)) CHECK(entry.path().extension() != ".part");

  const auto json = nlohmann::json::parse(contents(out + "summary.json"));
  for (const char* key : {"critical_speed", "time_step", "energy_closure", "particle_steps_per_second", "wall_clock"}) CHECK(json.contains(key));
  CHECK(std::abs(json["energy_closure"]["value"].get<double>()) < 1e-3);

  const std::string h5 = out + "results.h5";
  CHECK(read_text(h5, "h5md/creator", "name") == "quern");
  CHECK_FALSE(read_text(h5, "h5md/author", "name").empty());
  CHECK(read_text(h5, "particles/balls/position/value", "unit") == "m");
  CHECK(read_text(h5, "observables/energy/kinetic", "unit") == "J");
  CHECK(read_text(h5, "parameters/case") == settings.case_text);
  CHECK(read(h5, "particles/balls/box/edges") == std::vector<double>{0, 0, 0});
  std::vector<hsize_t> extent;
  const std::vector<double> position = read(h5, "particles/balls/position/value", &extent);
  REQUIRE(extent == std::vector<hsize_t>{6, 28, 3});
  for (std::size_t i = 0; i < 28; ++i)
    CHECK(position[(5 * 28 + static_cast<std::size_t>(s.particles.id[i])) * 3 + 2] == s.particles.position[i].z);
  const std::vector<double> time = read(h5, "particles/balls/position/time");
  for (std::size_t k = 0; k < time.size(); ++k) CHECK(time[k] == Approx(2e-3 * static_cast<double>(k)).margin(1e-12));
  CHECK(read(h5, "observables/energy/time").size() == 11);
  CHECK(read(h5, "observables/summary/critical_speed") == std::vector<double>{1.5});
}

TEST_CASE("writing changes nothing: the same state with and without frames") {
  const auto run = [](double frame_interval) {
    const Scratch scratch;
    Simulation s = drum(28);
    Observers observers(nothing());
    s.start(observers.needs_collisions());
    OutputSettings settings = plain();
    settings.frame_interval = frame_interval;
    settings.energy_interval = frame_interval;
    run_simulation(s, observers, settings, into(scratch), 0.02);
    return s.particles;
  };
  const Particles often = run(5e-4), never = run(0);
  for (std::size_t i = 0; i < often.position.size(); ++i) CHECK(often.position[i].z == never.position[i].z);
}

TEST_CASE("a stop signal ends the run after its step and everything so far is written") {
  const Scratch scratch;
  Simulation s = drum(10);
  Observers observers(nothing());
  s.start(observers.needs_collisions());
  const std::atomic<int> stop{SIGTERM};
  RunOptions options = into(scratch);
  options.stop_signal = &stop;
  const RunSummary summary = run_simulation(s, observers, plain(), options, 1.0);
  CHECK_FALSE(summary.finished);
  CHECK(summary.stopped_by == SIGTERM);
  CHECK(summary.steps == 1);
  CHECK(fs::exists(scratch / "out/summary.json"));
}

TEST_CASE("a run that fails says when, on which particle and what was saved") {
  const auto failure_of = [](auto&& spoil, auto&& arrange) -> std::string {
    const Scratch scratch;
    Simulation s = drum(10);
    arrange(s);
    Observers observers(nothing());
    s.start(observers.needs_collisions());
    spoil(s);
    try {
      run_simulation(s, observers, plain(), into(scratch), 0.02);
    } catch (const RunError& error) {
      CHECK(fs::exists(scratch / "out/summary.json"));
      CHECK(fs::exists(scratch / "out/results.h5"));
      return error.what();
    }
    return "";
  };
  const auto row = [](const Simulation& s, Index id) {
    return static_cast<std::size_t>(std::find(s.particles.id.begin(), s.particles.id.end(), id) - s.particles.id.begin());
  };
  const auto as_it_is = [](Simulation&) {};
  const auto names = [](const std::string& message, const std::string& words) { return message.find(words) != std::string::npos; };
  const std::string broken = failure_of([&](Simulation& s) { s.particles.velocity[row(s, 4)].x = std::numeric_limits<double>::quiet_NaN(); }, as_it_is);
  INFO(broken);
  CHECK((names(broken, "particle 4") && names(broken, "t = ") && names(broken, "Saved in")));
  const std::string left = failure_of(as_it_is, [](Simulation& s) { s.particles.position[6].x = 0.2, s.particles.velocity[6].x = 50; });
  INFO(left);
  CHECK((names(left, "particle 6 has left the walls") && names(left, "summary.json")));
  const std::string energy = failure_of([&](Simulation& s) { s.particles.velocity[row(s, 2)].y = 20; }, as_it_is);
  INFO(energy);
  CHECK((names(energy, "more than was ever put in") && names(energy, "particle 2")));
}

TEST_CASE("a directory that cannot be made is the user's mistake, not a failed run") {
  const Scratch scratch;
  std::ofstream(scratch / "out") << "a file";
  Simulation s = drum(1);
  Observers observers(nothing());
  s.start(false);
  CHECK_THROWS_AS(run_simulation(s, observers, plain(), into(scratch), 1e-4), InputError);
}

TEST_CASE("a frame is a VTK file of XML with all arrays and the walls turn with their frame") {
  const Scratch scratch;
  Simulation s = drum(5);
  s.start(false);
  VtkFrames frames(scratch.path);
  frames.append(s);
  const std::string balls = contents(scratch / "frames/balls_000000.vtp");
  for (const char* name : {"\"velocity\"", "\"diameter\"", "\"species\"", "\"id\"", "NumberOfPoints=\"5\"", "vtkZLibDataCompressor", "encoding=\"raw\""})
    CHECK(balls.find(name) != std::string::npos);
  CHECK(contents(scratch / "frames.pvd").find("file=\"frames/walls_000000.vtp\"") != std::string::npos);

  Wall quarter = s.walls[0];
  const Surroundings shown = surroundings(s.walls, s.particles.position);
  const Vec3 before = facets_of(quarter, shown).points[0];
  quarter.pose.axes = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix() * quarter.pose.axes;
  const Vec3 after = facets_of(quarter, shown).points[0];
  CHECK((after - Vec3(before.z(), before.y(), -before.x())).norm() < 1e-15);
}

TEST_CASE("the facets of a wall lie on its surface and cover it") {
  Wall wall;
  wall.surface = Revolved{0.2, -0.1, 0.2, 0.3, Revolved::Side::inside};
  const Facets facets = facets_of(wall, {}, 96);
  double area = 0;
  for (const auto& t : facets.triangles) {
    const auto p = [&](int k) { return facets.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
    area += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    CHECK(std::abs(std::get<Revolved>(wall.surface).touch(p(0)).distance) < 1e-12);
  }
  // A regular polygon of n sides in a circle is shorter by (π/n)²/6.
  CHECK(area == Approx(2 * std::numbers::pi * 0.2 * 0.4).epsilon(2e-4));
}

TEST_CASE("pictures are drawn without a screen, or a sentence says that they are not") {
  const Scratch scratch;
  Simulation s = drum(40);
  s.start(false);
  Table energy = empty_ledger_table();
  for (int k = 0; k < 5; ++k) append_row(energy, 0.1 * k, s.ledger);
  const char* display = std::getenv("DISPLAY");
  const std::string before = display ? display : "";
  const Drawn drawn = draw_pictures({scratch.path, "drum", Vec3::Zero(), &s, {}, {energy}, {}});
  const char* now = std::getenv("DISPLAY");
  CHECK((now ? now : "") == before);
  if (drawn.files.empty()) {
    REQUIRE(drawn.remarks.size() == 1);
    CHECK(drawn.remarks[0].find("Xvfb") != std::string::npos);
  } else {
    CHECK(drawn.files == std::vector<std::string>{"charge.png", "energy.png"});
    for (const std::string& file : drawn.files) CHECK(contents(scratch / file).substr(1, 3) == "PNG");
  }
}
