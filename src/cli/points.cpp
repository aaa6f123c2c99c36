#include "src/cli/points.hpp"
#include <fcntl.h>
#include <fmt/format.h>
#include <boost/crc.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>
#include "src/base/error.hpp"
#include "src/base/say.hpp"
#include "src/base/whole_file.hpp"
#include "src/cli/stop_signal.hpp"

extern char** environ;

namespace quern {
namespace {

namespace fs = std::filesystem;

std::string mark_of(const Point& point) { return point.directory + "/finished.toml"; }

std::string words_of(const Point& point) {
  if (!point.label.empty()) return point.label;
  return point.overrides.empty() ? point.file : fmt::format("{}", fmt::join(point.overrides, " "));
}

void start(Point& point, int threads) {
  fs::create_directories(point.directory);
  std::vector<std::string> arguments = {"quern", "run", point.file, "--out", point.directory, "--quiet", "--no-report"};
  if (threads > 0) arguments.insert(arguments.end(), {"--threads", std::to_string(threads)});
  for (const std::string& one : point.overrides) arguments.push_back("--set=" + one);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  const std::string log = point.directory + "/log.txt";
  posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&files, 1, 2);
  const int problem = posix_spawn(&point.process, "/proc/self/exe", &files, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (problem != 0) throw RunError(fmt::format("A run could not be started: {}.", std::strerror(problem)));
}

// No run outlives whoever waits for it, also where a table cannot be written.
struct Ending {
  const std::vector<Point*>& running;
  ~Ending() {
    for (const Point* point : running) kill(point->process, SIGTERM);
    for (const Point* point : running) waitpid(point->process, nullptr, 0);
  }
};

}  // namespace

std::string content_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_aside(const std::string& file, const std::string& content) { write_whole_file(file, content); }

std::string folder_name(const std::vector<SweptKey>& swept, const std::vector<std::string>& overrides) {
  std::string name;
  for (std::size_t k = 0; k < swept.size(); ++k)
    if (swept[k].values.size() > 1) name += (name.empty() ? "" : "__") + overrides[k];
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && std::string_view("=._-+").find(c) == std::string_view::npos) c = '_';
  constexpr std::size_t longest = 200;  // file systems allow 255 bytes
  if (name.size() > longest) {
    boost::crc_32_type crc;
    crc.process_bytes(name.data(), name.size());
    name = fmt::format("{}__{:08x}", name.substr(0, longest), crc.checksum());
  }
  return name.empty() ? "run" : name;
}

std::size_t keep_finished(std::vector<Point>& points) {
  std::size_t kept = 0;
  for (Point& point : points)
    if (content_of(mark_of(point)) == point.text) point.finished = true, ++kept;
  return kept;
}

int run_points(std::vector<Point>& points, int wanted, const std::function<void()>& after, std::optional<int> given) {
  const std::atomic<int>* stop = watch_stop_signals();
  const auto jobs = static_cast<std::size_t>(wanted > 0 ? wanted : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  const auto waiting =
      static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [](const Point& point) { return !point.finished; }));
  const int threads = given.value_or(std::max(1, static_cast<int>(jobs / std::max<std::size_t>(1, waiting))));
  std::vector<Point*> running;
  const Ending ending{running};
  std::size_t next = 0, done = points.size() - waiting, failed = 0;
  bool told = false;
  while (!running.empty() || (next < points.size() && *stop == 0)) {
    while (*stop == 0 && running.size() < jobs && next < points.size()) {
      Point& point = points[next++];
      if (point.finished) continue;
      start(point, threads);
      running.push_back(&point);
    }
    if (*stop != 0 && !told) {
      for (const Point* point : running) kill(point->process, *stop);
      told = true;
    }
    for (std::size_t k = 0; k < running.size();) {
      Point& point = *running[k];
      int status = 0;
      if (waitpid(point.process, &status, WNOHANG) != point.process) {
        ++k;
        continue;
      }
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(k));
      point.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      if (point.status == 0) {
        write_aside(mark_of(point), point.text);
        point.finished = true;
        fmt::print("{}/{}  {}\n", ++done, points.size(), words_of(point));
        std::fflush(stdout);
        after();
      } else if (*stop == 0) {
        ++failed;
        std::string log = content_of(fs::path(point.directory) / "log.txt");
        while (!log.empty() && log.back() == '\n') log.pop_back();
        say(fmt::format("The run {} failed (exit status {}): {}\n", words_of(point), point.status, log.substr(log.rfind('\n') + 1)));
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  if (*stop != 0) return 128 + *stop;
  return failed > 0 ? 1 : 0;
}

}  // namespace quern
