// results.h5: trajectories in H5MD 1.1 layout (de Buyl et al. 2014, nongnu.org/h5md), observables with units and descriptions,
// and the case. Whole after every frame: a killed run leaves a readable file.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>
#include "src/base/error.hpp"
#include "src/engine/simulation.hpp"
#include "src/observe/table.hpp"

namespace quern {

class ResultsFile {
 public:
  // Replaces a file of that name. Throws WriteError where it cannot be written, as all functions here: on disk it then stays as the last
  // flush left it, and whatever is written later is ignored. Throws InputError where another program has the file open for writing.
  ResultsFile(const std::string& path, const Simulation& simulation, const std::string& title, const std::string& case_text);
  // Goes on with a file of which the first `frames` frames of `particles` particles count: later ones, and all observables, are dropped.
  // Throws InputError, and leaves the file alone, where it is missing, locked, damaged, of another case or holds less than that.
  static ResultsFile reopen(const std::string& path, const std::string& case_text, std::uint64_t frames, std::uint64_t particles);
  ResultsFile(ResultsFile&&) noexcept;
  ~ResultsFile();
  ResultsFile(const ResultsFile&) = delete;
  ResultsFile& operator=(const ResultsFile&) = delete;

  // Row k of every array is the particle with id k. Particles may join during a run; where one is missing, its id is −1 and
  // its numbers are not-a-number.
  void append_frame(const Simulation& simulation);

  // Adds the table's rows from `first_row` on to /observables/<table>/<column>, all of them against the table's first column.
  void append_rows(const Table& table, std::size_t first_row);

  // A table that is complete: packed more tightly.
  void write_table(const Table& table);

  // Under /observables/summary.
  void write_headlines(const std::vector<Headline>& headlines);

  void flush();
  // What was written outlives a power cut.
  void sync();

  std::uint64_t frames() const;
  std::uint64_t particles() const;

 private:
  ResultsFile();
  static ResultsFile go_on(const std::string& path, const std::string& case_text, std::uint64_t frames, std::uint64_t particles,
                           const std::function<InputError(const std::string&)>& refuse, bool rehearsal);
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace quern
