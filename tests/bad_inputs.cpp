#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>
#include "src/base/random.hpp"
#include "tests/places.hpp"

namespace fs = std::filesystem;

namespace {

struct Answer {
  int status = -1;  // of exit; −1: it crashed
  std::string errors;
};

Answer run_quern(const std::string& arguments) {
  const std::string command = std::string("'") + quern::program + "' " + arguments + " 2>&1 >/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  Answer answer;
  std::array<char, 4096> buffer;
  for (std::size_t got; (got = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) answer.errors.append(buffer.data(), got);
  const int status = pclose(pipe);
  if (WIFEXITED(status) && WEXITSTATUS(status) < 126) answer.status = WEXITSTATUS(status);
  return answer;
}

// Exit 2, and one line of one or two sentences that names the file.
void check_refused(const fs::path& file, const std::vector<std::string>& expected) {
  INFO(file);
  const Answer answer = run_quern("check '" + file.string() + "'");
  INFO(answer.errors);
  CHECK(answer.status == 2);
  CHECK(answer.errors.size() < 800);
  REQUIRE(answer.errors.size() > 10);
  CHECK(answer.errors.find('\n') == answer.errors.size() - 1);
  CHECK(std::string(".?").find(answer.errors[answer.errors.size() - 2]) != std::string::npos);
  CHECK(answer.errors.find(file.filename().string()) != std::string::npos);
  for (const std::string& text : expected) CHECK_THAT(answer.errors, Catch::Contains(text));
}

struct Folder {
  fs::path path = fs::temp_directory_path() / ("quern_bad_" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("Each bad case exits 2 with one or two sentences that say what and where", "[bad]") {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(std::string(quern::source_directory) + "/tests/bad_cases")) {
    if (entry.path().extension() != ".toml") continue;
    // Its first lines say what the answer must contain.
    std::ifstream stream(entry.path());
    std::vector<std::string> expected;
    const std::string mark = "# expects: ";
    for (std::string line; std::getline(stream, line) && line.rfind(mark, 0) == 0;) expected.push_back(line.substr(mark.size()));
    REQUIRE(!expected.empty());
    check_refused(entry.path(), expected);
    ++count;
  }
  CHECK(count >= 40);
}

TEST_CASE("What is no case file at all exits 2 with one sentence", "[bad]") {
  const Folder folder;
  check_refused(folder.path / "no_such_file.toml", {"no such file"});
  check_refused(folder.path, {"is a directory"});

  std::ofstream(folder.path / "empty.toml");
  check_refused(folder.path / "empty.toml", {"is empty"});

  quern::RandomStream random(7);
  std::string noise(10 << 20, ' ');
  for (char& c : noise) c = static_cast<char>(random.next());
  std::ofstream(folder.path / "noise.toml", std::ios::binary) << noise;
  check_refused(folder.path / "noise.toml", {"MB"});
  std::ofstream(folder.path / "binary.toml", std::ios::binary) << noise.substr(0, 100000);
  check_refused(folder.path / "binary.toml", {"binary"});

  for (char& c : noise) c = static_cast<char>(33 + (static_cast<unsigned char>(c) % 94));
  std::ofstream(folder.path / "text_noise.toml") << noise.substr(0, 1 << 20);
  check_refused(folder.path / "text_noise.toml", {});
  std::ofstream(folder.path / "deep.toml") << "a = " + std::string(100000, '[');
  check_refused(folder.path / "deep.toml", {});
  std::ofstream dotted(folder.path / "dotted.toml");
  for (int k = 0; k < 100000; ++k) dotted << "a.";
  dotted << "b = 1\n";
  dotted.close();
  check_refused(folder.path / "dotted.toml", {"dotted.toml:1", "parts"});
  std::ofstream(folder.path / "latin.toml") << "title = \"M\xfchle\"\n";
  check_refused(folder.path / "latin.toml", {"latin.toml:1"});
}

TEST_CASE("A wrong command line exits 2", "[bad]") {
  for (const char* arguments : {"", "rnu", "run", "check --nonsense x", "list everything", "linearize -k 1 -q 1 -m 1", "linearize -k 1 -q 1 -m '1 m' -v 1"}) {
    INFO(arguments);
    const Answer answer = run_quern(arguments);
    INFO(answer.errors);
    CHECK(answer.status == 2);
    CHECK(!answer.errors.empty());
  }
  CHECK(run_quern("--help").status == 0);
  CHECK(run_quern("run --help").status == 0);
  CHECK(run_quern("list laws").status == 0);
}
