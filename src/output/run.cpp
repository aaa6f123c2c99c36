#include "src/output/run.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include "src/base/archive.hpp"
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/engine/checkpoint.hpp"
#include "src/engine/simulation.hpp"
#include "src/observe/angles.hpp"
#include "src/observe/observers.hpp"
#include "src/observe/seat.hpp"
#include "src/observe/soundness.hpp"
#include "src/output/claim.hpp"
#include "src/output/health.hpp"
#include "src/output/ledger_table.hpp"
#include "src/output/pictures.hpp"
#include "src/output/progress.hpp"
#include "src/output/results_file.hpp"
#include "src/output/run_plan.hpp"
#include "src/output/tables.hpp"
#include "src/output/vtk_frames.hpp"

namespace quern {
namespace {

// Says when something that happens every `interval` is due; counted in whole intervals, so that it does not drift.
class Schedule {
 public:
  Schedule(double interval, double start) : interval_(interval), next_(interval > 0 ? std::floor(start / interval * (1 + 1e-12)) + 1 : 0) {}
  bool due(double time, double time_step) {
    if (interval_ <= 0 || time < next_ * interval_ - 0.5 * time_step) return false;
    next_ = std::max(next_ + 1, std::floor((time + 0.5 * time_step) / interval_) + 1);
    return true;
  }
  template <class Archive>
  void archive(Archive& a) {
    a(next_);
  }

 private:
  double interval_, next_;
};

// Everything that one run writes.
class Writer {
 public:
  Writer(const OutputSettings& settings, const std::string& directory)
      : settings_(settings), directory_(directory), energy_(empty_ledger_table()) {
    copy_files(settings.case_files, directory);
    if (!settings.case_text.empty()) save("case.toml", settings.case_text);
    files_.push_back("results.h5");
    if (settings.vtk_frames) frames_.emplace(directory);
  }

  void begin(const Simulation& s) { results_ = std::make_unique<ResultsFile>(path("results.h5"), s, settings_.title, settings_.case_text); }

  // What has been written so far, and going on from there: what was written later is dropped.
  template <class Archive>
  void archive(Archive& a) {
    std::uint64_t frames = results_ ? results_->frames() : 0, particles = results_ ? results_->particles() : 0;
    a(energy_, last_frame_, frames, particles);
    if (!same_columns(energy_, empty_ledger_table())) throw UnfitData("its ledger has other columns");
    if (frames_) a(*frames_);
    if (!results_)
      results_ = std::make_unique<ResultsFile>(ResultsFile::reopen(path("results.h5"), settings_.case_text, frames, particles));
  }

  void sync() { results_->sync(); }

  void energy(Simulation& s) { append_row(energy_, s.clock.time(), s.ledger); }

  void frame(const Simulation& s) {
    if (last_frame_ == s.clock.step) return;
    flush_energy();
    if (settings_.trajectory) results_->append_frame(s);
    if (frames_) frames_->append(s);
    last_frame_ = s.clock.step;
  }

  // Tables and headline numbers; complete after every call.
  void results(const std::vector<Table>& tables, const std::vector<Headline>& headlines) {
    save("energy.csv", csv_of(energy_));
    flush_energy();
    for (const Table& table : tables) {
      save(table.name + ".csv", csv_of(table));
      results_->write_table(table);
    }
    results_->write_headlines(headlines);
    results_->flush();
    save("summary.json", json_of(headlines));
    if (frames_) note("frames.pvd");
  }

  const Table& energy() const { return energy_; }
  std::vector<std::string>& files() { return files_; }

 private:
  std::string path(const std::string& file) const { return directory_ + "/" + file; }
  void note(const std::string& file) {
    if (std::find(files_.begin(), files_.end(), file) == files_.end()) files_.push_back(file);
  }
  void save(const std::string& file, const std::string& contents) {
    write_whole_file(path(file), contents);
    note(file);
  }
  void flush_energy() {
    const std::size_t rows = energy_.columns.front().values.size();
    results_->append_rows(energy_, rows_in_file_);
    rows_in_file_ = rows;
    results_->flush();
  }

  const OutputSettings& settings_;
  std::string directory_;
  Table energy_;
  std::size_t rows_in_file_ = 0;
  std::int64_t last_frame_ = -1;
  std::unique_ptr<ResultsFile> results_;
  std::optional<VtkFrames> frames_;
  std::vector<std::string> files_;
};

std::vector<Headline> headlines_of(const Simulation& s, const Observers& observers, const OutputSettings& settings,
                                   const RunSummary& summary) {
  std::vector<Headline> all = observers.headlines();
  all.insert(all.end(), settings.headlines.begin(), settings.headlines.end());
  const double particle_steps = static_cast<double>(summary.steps) * static_cast<double>(s.particles.owned);
  const auto add = [&](const char* key, double value, const char* unit, const char* description) {
    all.push_back({key, value, unit, std::nullopt, description});
  };
  add("time_step", s.clock.time_step, "s", "of the integration");
  add("simulated_time", s.clock.time(), "s", "reached by the run");
  add("particle_count", s.particles.owned, "1", "particles at the end");
  add("energy_closure", s.ledger.closure(), "1", "what the energy ledger misses, as a fraction of the energy that passed through it");
  add("particle_steps_per_second", summary.wall_clock > 0 ? particle_steps / summary.wall_clock : 0, "1/s", "speed of the run");
  add("wall_clock", summary.wall_clock, "s", "how long the run took");
  return all;
}

// After the sentence that says what could not be written.
std::string aftermath(double time, std::optional<double> last_checkpoint) {
  const std::string stopped = fmt::format(" The run stopped at t = {:.6g} s; what was written before can be read", time);
  if (!last_checkpoint) return stopped + ", and there was no checkpoint yet: begin anew once this is put right.";
  return stopped + fmt::format(", and --resume goes on from the checkpoint at t = {:.6g} s once this is put right.", *last_checkpoint);
}

// Why a run that was to end when the spectrum is known well enough has ended; empty where that was not asked for.
std::string of_convergence(const Observers& observers, double time) {
  const ObserverSettings& asked = observers.settings;
  if (asked.stop_at_interval <= 0 && asked.stop_at_bin_interval <= 0) return "";
  std::string wanted;
  if (asked.stop_at_interval > 0) wanted += fmt::format("observe.stop_at_interval = {:g}", asked.stop_at_interval);
  if (asked.stop_at_bin_interval > 0) wanted += fmt::format("{}observe.stop_at_bin_interval = {:g}", wanted.empty() ? "" : ", ", asked.stop_at_bin_interval);
  const std::string widths = observers.convergence.widths();
  if (observers.convergence.reached) return fmt::format("Ended at t = {:.6g} s, as the spectrum is known well enough ({}): {}.", time, wanted, widths);
  return fmt::format("Reached its duration before the spectrum was known well enough ({}){}{}.", wanted, widths.empty() ? "" : ": ", widths);
}

std::string listed(const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t k = 0; k < words.size(); ++k) out += (k == 0 ? "" : k + 1 == words.size() ? " and " : ", ") + words[k];
  return out;
}

std::vector<ShellMark> shell_marks(const MillView& view, const std::vector<Headline>& headlines) {
  std::vector<ShellMark> marks;
  for (const auto& [key, label] : {std::pair("shoulder_angle", "shoulder"), std::pair("toe_angle", "toe")}) {
    for (const Headline& headline : headlines) {
      if (headline.key != key || !std::isfinite(headline.value)) continue;
      const double angle = headline.value * degree;
      marks.push_back({fmt::format("{} {:.0f}°", label, headline.value), std::cos(angle) * view.up + std::sin(angle) * view.ahead});
    }
  }
  return marks;
}

// What pictures of the charge show, and from where. `vial`: a place for the first one of a planetary mill.
PictureRequest pictures_of(const Simulation& s, const ObserverSettings& observed, const OutputSettings& settings, const RunOptions& options,
                           const std::vector<Headline>& headlines, Simulation& vial) {
  PictureRequest pictures;
  pictures.directory = options.directory;
  pictures.title = settings.title.empty() ? settings.name : settings.title;
  pictures.view_axis = settings.view_axis;
  pictures.simulation = &s;
  pictures.headlines = headlines;
  const auto seat = Seat::of(observed, s);
  if (!seat) return pictures;
  if (pictures.view_axis.isZero()) pictures.view_axis = seat->view.axis;
  if (seat->planetary) {
    vial = first_vial(s, *seat->planetary);
    pictures.simulation = &vial;
    pictures.view_up = seat->view.up;
    if (seat->planetary->vials > 1) pictures.of = fmt::format("one of {} vials", seat->planetary->vials);
  }
  pictures.marks = shell_marks(seat->view, headlines);
  return pictures;
}

void add(const Drawn& drawn, Writer& writer, RunSummary& summary) {
  writer.files().insert(writer.files().end(), drawn.files.begin(), drawn.files.end());
  summary.remarks.insert(summary.remarks.end(), drawn.remarks.begin(), drawn.remarks.end());
}

// Tables and pictures of what has been reached; called at the end, also of a run that fails.
void conclude(Simulation& s, Observers& observers, const OutputSettings& settings, const RunOptions& options, Writer& writer,
              RunSummary& summary, bool may_draw) {
  observers.finish(s);
  summary.headlines = headlines_of(s, observers, settings, summary);
  std::vector<Table> tables = observers.tables();
  writer.results(tables, summary.headlines);
  if (settings.pictures && may_draw) {
    tables.push_back(writer.energy());
    Simulation vial;
    PictureRequest pictures = pictures_of(s, observers.settings, settings, options, summary.headlines, vial);
    pictures.tables = std::move(tables);
    add(draw_pictures(pictures), writer, summary);
  }
  summary.files = writer.files();
}

}  // namespace

RunSummary run_simulation(Simulation& s, Observers& observers, const OutputSettings& settings, const RunOptions& options, double duration) {
  if (options.threads > 0 && options.threads != s.team->size()) s.team = std::make_shared<ThreadTeam>(options.threads);

  const double dt = s.clock.time_step;
  const std::int64_t end = last_step(duration, dt);
  Schedule frame_due(settings.frame_interval, s.clock.time());
  Schedule energy_due(settings.energy_interval > 0 ? settings.energy_interval : duration / 1000, s.clock.time());

  RunSummary summary;
  s.measure_energy();
  const Health health(s);
  const std::string checkpoint_path = options.directory + "/checkpoint";
  Checkpoint checkpoint;
  std::optional<double> checkpoint_time;
  if (options.resume && !std::filesystem::exists(options.directory))
    throw InputError("The directory " + options.directory + " is missing: there is no run to go on with.");
  make_directory(options.directory);
  const Claim claim(options.directory);
  if (options.resume) checkpoint = read_checkpoint(checkpoint_path, settings.case_text);
  Writer writer(settings, options.directory);
  const auto archive_run = [&](auto& archive) {
    archive(observers, writer, frame_due, energy_due);
    archive_state(archive, s);
  };
  if (options.resume) {
    ArchiveReader reader(checkpoint.bytes());
    try {
      archive_run(reader);
      if (!reader.at_end()) throw UnfitData("there is more of it than that");
      if (!sound(observers, s)) throw UnfitData("what was observed does not fit it");
    } catch (const UnfitData& error) {
      throw InputError(fmt::format("{} does not hold a state of this case: {}; run without --resume to begin anew.", checkpoint_path, error.what()));
    }
    checkpoint.file = {};
    checkpoint_time = s.clock.time();
    if (!checkpoint.remark.empty()) summary.remarks.push_back(checkpoint.remark + ".");
  } else {
    writer.begin(s);
    remove_checkpoints(checkpoint_path);
    writer.energy(s);
    writer.frame(s);
    observers.see(s);
  }
  Progress progress(s.clock.time(), duration, options.quiet);
  const auto save_checkpoint = [&] {
    writer.sync();  // the checkpoint counts on what the results hold
    write_checkpoint(checkpoint_path, settings.case_text, ArchiveWriter::written_by(archive_run));
    checkpoint_time = s.clock.time();
  };
  double next_checkpoint = options.checkpoint_interval;

  // Those before this moment were drawn by the run that wrote the checkpoint.
  std::size_t stage = 0;
  while (stage < settings.stages.size() && settings.stages[stage] < s.clock.time() - 0.5 * dt) ++stage;
  std::string failure, unwritten;
  const std::int64_t first_step = s.clock.step;
  try {
    while (s.clock.step < end && !observers.convergence.reached) {
      s.step();
      observers.see(s);
      const double time = s.clock.time();
      const bool last = s.clock.step >= end || observers.convergence.reached, sample = energy_due.due(time, dt), frame = frame_due.due(time, dt);
      const bool check = s.clock.step % steps_between_checks == 0;
      if (sample || frame || last || check) {
        s.measure_energy();
        if (const auto complaint = health.complaint(s)) throw RunError(*complaint);
      }
      if (sample || last) writer.energy(s);
      if (frame) writer.frame(s);
      if (stage < settings.stages.size() && time >= settings.stages[stage] - 0.5 * dt) {
        Simulation vial;
        if (settings.pictures) add(draw_stage(pictures_of(s, observers.settings, settings, options, {}, vial), static_cast<int>(stage) + 1), writer, summary);
        ++stage;
      }
      progress.show(time);
      if (options.stop_signal) summary.stopped_by = options.stop_signal->load(std::memory_order_relaxed);
      if (summary.stopped_by != 0) {
        save_checkpoint();
        break;
      }
      if (check && progress.wall_clock() >= next_checkpoint) {
        save_checkpoint();
        next_checkpoint = progress.wall_clock() + options.checkpoint_interval;
      }
    }
  } catch (const WriteError& error) {
    unwritten = error.what();
  } catch (const RunError& error) {
    failure = error.what();
  } catch (const std::bad_alloc&) {
    failure = fmt::format("at t = {:.6g} s: the memory of this machine is not enough; fewer particles or frames need less", s.clock.time());
  }
  progress.end();
  summary.finished = failure.empty() && unwritten.empty() && (s.clock.step >= end || observers.convergence.reached);
  summary.time = s.clock.time();
  summary.steps = s.clock.step - first_step;
  summary.wall_clock = progress.wall_clock();

  try {
    s.measure_energy();
    if (unwritten.empty()) writer.frame(s);
    conclude(s, observers, settings, options, writer, summary, unwritten.empty());
  } catch (const std::exception& error) {
    if (!failure.empty()) throw RunError(fmt::format("The run failed {}. Saving what there was failed too: {}", failure, error.what()));
    if (unwritten.empty()) {
      if (dynamic_cast<const WriteError*>(&error) == nullptr) throw;
      unwritten = error.what();
    }
  }
  if (!unwritten.empty()) throw WriteError(unwritten + aftermath(summary.time, checkpoint_time));
  if (!failure.empty()) {
    throw RunError(
        fmt::format("The run failed {}. Saved in {}: the results up to then ({}).", failure, options.directory, listed(summary.files)));
  }
  if (summary.stopped_by != 0)
    summary.remarks.push_back(fmt::format("Stopped at t = {:.6g} s by {}; {} holds its state, and --resume goes on from it.", summary.time,
                                          summary.stopped_by == SIGINT ? "^C" : std::string("SIG") + sigabbrev_np(summary.stopped_by),
                                          checkpoint_path));
  if (summary.finished) {
    remove_checkpoints(checkpoint_path);
    if (const std::string remark = of_convergence(observers, s.clock.time()); !remark.empty()) summary.remarks.push_back(remark);
  }
  return summary;
}

}  // namespace quern
