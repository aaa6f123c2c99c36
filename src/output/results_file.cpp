#include "src/output/results_file.hpp"
#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <utility>
#include "src/base/error.hpp"
#include "src/output/committed_file.hpp"

namespace quern {
namespace {

// A call of HDF5 failed; why.
struct Hdf5Failure {
  std::string reason = last_system_error() != 0 ? std::strerror(last_system_error()) : words_of_hdf5();

 private:
  // Of HDF5's stack of errors, the innermost.
  static std::string words_of_hdf5() {
    std::string cause;
    const H5E_walk2_t look = [](unsigned, const H5E_error2_t* entry, void* found) -> herr_t {
      std::string& words = *static_cast<std::string*>(found);
      if (words.empty() && entry->desc) words = std::string("HDF5 says: ") + entry->desc;
      return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, look, &cause);
    return cause.empty() ? "the system gives no reason" : cause;
  }
};

// Owns an HDF5 identifier of any kind.
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {
    if (id < 0) throw Hdf5Failure{};
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() { close(); }
  void close() {
    if (id_ < 0) return;
    switch (H5Iget_type(id_)) {
      case H5I_FILE:
        H5Fclose(id_);
        break;
      case H5I_GROUP:
        H5Gclose(id_);
        break;
      case H5I_DATASET:
        H5Dclose(id_);
        break;
      case H5I_DATASPACE:
        H5Sclose(id_);
        break;
      case H5I_DATATYPE:
        H5Tclose(id_);
        break;
      case H5I_ATTR:
        H5Aclose(id_);
        break;
      default:
        H5Pclose(id_);
    }
    id_ = -1;
  }
  bool open() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

 private:
  hid_t id_ = -1;
};

void must(herr_t status) {
  if (status < 0) throw Hdf5Failure{};
}

// HDF5 prints a stack of its own at every error; ours are exceptions. And we close our files ourselves: at the end of the program HDF5 1.10
// would crash over one that could not be opened or closed well.
void keep_quiet() {
  static const herr_t once = H5dont_atexit();
  static_cast<void>(once);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

// Whether a process of its own survives something: the library crashes on some damaged files.
template <class Do>
bool survived(Do&& rehearse) {
  constexpr unsigned patience = 60;  // [s]
  const pid_t child = fork();
  if (child < 0) return true;  // no room for one: as well as can be
  if (child == 0) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL, SIGALRM}) std::signal(signal, SIG_DFL);
    if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    alarm(patience);
    try {
      rehearse();
    } catch (...) {
    }  // a refusal, which the caller will hear
    _exit(0);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

Handle text_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1));
  must(H5Tset_size(type, std::max<std::size_t>(length, 1)));
  must(H5Tset_cset(type, H5T_CSET_UTF8));
  must(H5Tset_strpad(type, H5T_STR_NULLPAD));
  return type;
}

Handle group(hid_t parent, const std::string& path) {
  if (H5Lexists(parent, path.c_str(), H5P_DEFAULT) > 0) return Handle(H5Gopen2(parent, path.c_str(), H5P_DEFAULT));
  return Handle(H5Gcreate2(parent, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

void attribute(hid_t on, const char* name, hid_t type, hid_t space, const void* data) {
  if (H5Aexists(on, name) > 0) must(H5Adelete(on, name));
  Handle attribute(H5Acreate2(on, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
  must(H5Awrite(attribute, type, data));
}

void text_attribute(hid_t on, const char* name, const std::string& text) {
  attribute(on, name, text_type(text.size()), Handle(H5Screate(H5S_SCALAR)), text.c_str());
}

void text_dataset(hid_t parent, const char* name, const std::string& text) {
  const Handle type = text_type(text.size()), space(H5Screate(H5S_SCALAR));
  const Handle set(H5Dcreate2(parent, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  must(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()));
}

// A chunk that is written again keeps its place only if it is not packed; packed, it would wander and leave holes.
enum class Chunks { written_once, written_again };

// An empty array that can grow in every direction, but for the last where `fixed_last` gives its extent.
Handle growing(hid_t parent, const char* name, hid_t type, const std::vector<hsize_t>& chunk, hsize_t fixed_last, const void* fill,
               Chunks chunks) {
  std::vector<hsize_t> dims(chunk.size(), 0), most(chunk.size(), H5S_UNLIMITED);
  if (fixed_last > 0) dims.back() = most.back() = fixed_last;
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), most.data()));
  const Handle made(H5Pcreate(H5P_DATASET_CREATE));
  must(H5Pset_chunk(made, static_cast<int>(chunk.size()), chunk.data()));
  must(H5Pset_fill_value(made, type, fill));
  if (chunks == Chunks::written_once) {
    must(H5Pset_shuffle(made));
    must(H5Pset_deflate(made, 1));
  }
  return Handle(H5Dcreate2(parent, name, type, space, H5P_DEFAULT, made, H5P_DEFAULT));
}

// Writes `data` at `start`, growing the array to hold it.
void put(hid_t set, hid_t memory_type, const std::vector<hsize_t>& start, const std::vector<hsize_t>& count, const void* data) {
  if (std::find(count.begin(), count.end(), hsize_t{0}) != count.end()) return;
  Handle space(H5Dget_space(set));
  std::vector<hsize_t> extent(start.size());
  must(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  bool grows = false;
  for (std::size_t d = 0; d < start.size(); ++d) {
    if (start[d] + count[d] > extent[d]) extent[d] = start[d] + count[d], grows = true;
  }
  if (grows) {
    must(H5Dset_extent(set, extent.data()));
    space = Handle(H5Dget_space(set));
  }
  must(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
  const Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr));
  must(H5Dwrite(set, memory_type, memory, space, H5P_DEFAULT, data));
}

std::string author() {
  const passwd* user = getpwuid(geteuid());
  return user && user->pw_name ? user->pw_name : "unknown";
}

Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS));
  // The old layout, which has no mark of being open for writing: a file whose writer was killed opens like any other.
  must(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18));
  use_commits(access);
  return access;
}

Handle dataset(hid_t parent, const char* path) { return Handle(H5Dopen2(parent, path, H5P_DEFAULT)); }

// A text that text_dataset() wrote.
std::string text_of(hid_t parent, const char* path) {
  const Handle set = dataset(parent, path), type(H5Dget_type(set)), space(H5Dget_space(set));
  // One text of a fixed length, as it was written.
  constexpr std::size_t longest = 64 << 20;  // [bytes]
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || H5Tget_size(type) > longest || H5Sget_simple_extent_npoints(space) != 1) throw Hdf5Failure{};
  std::string text(H5Tget_size(type), '\0');
  must(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()));
  text.erase(std::min(text.size(), text.find_last_not_of('\0') + 1));
  return text;
}

// Whether an array is at least that large.
bool holds(hid_t set, const std::vector<hsize_t>& least) {
  const Handle space(H5Dget_space(set));
  std::vector<hsize_t> extent(least.size());
  if (H5Sget_simple_extent_ndims(space) != static_cast<int>(least.size())) return false;
  must(H5Sget_simple_extent_dims(space, extent.data(), nullptr));
  return std::equal(least.begin(), least.end(), extent.begin(), std::less_equal<>());
}

// HDF5 locks a file that it writes (flock, exclusive), and so do other programs. Whoever only reads it is no hindrance.
void must_be_free(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  const bool locked = flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(file);
  if (locked)
    throw InputError("The file " + path +
                     " is locked: another program has it open for writing. Close it there, or choose another directory with --out.");
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int32_t absent = -1;

}  // namespace

struct ResultsFile::File {
  std::string path;
  bool lost = false;
  Handle file;
  Handle frame_step, frame_time;           // [frame]
  Handle position, velocity, spin, id;     // [frame][particle]
  Handle radius, mass, species, material;  // [particle]
  std::map<std::string, Handle> columns;   // of the observables
  hsize_t frames = 0, particles = 0;

  void make_trajectory(const Simulation& s);
  void append_frame(const Simulation& s);
  void append_rows(const Table& table, std::size_t first_row, Chunks chunks);
  void write_headlines(const std::vector<Headline>& headlines);
  void flush();

  // HDF5 would go on writing what it holds in memory when the file is closed, and a part of that may still fit.
  void give_up() {
    lost = true;
    if (file.open()) abandon(file);
  }

  // Does a piece of writing, or leaves the file on disk as the last flush left it, and says why.
  template <class Work>
  void attempt(Work&& work) {
    if (lost) return;
    try {
      forget_system_error();
      work();
    } catch (const Hdf5Failure& failure) {
      give_up();
      throw WriteError("The file " + path + " cannot be written: " + failure.reason + ".");
    }
  }
};

ResultsFile::ResultsFile(const std::string& path, const Simulation& simulation, const std::string& title, const std::string& case_text)
    : file_(std::make_unique<File>()) {
  keep_quiet();
  must_be_free(path);
  recover(path);
  File& f = *file_;
  f.path = path;
  f.attempt([&] {
    f.file = Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, file_access()));
    const hid_t file = f.file;

    const Handle h5md = group(file, "h5md"), writer = group(h5md, "author"), creator = group(h5md, "creator");
    const hsize_t two = 2;
    const std::array<std::int32_t, 2> version{1, 1}, units_version{1, 0};
    const Handle pair(H5Screate_simple(1, &two, nullptr));
    attribute(h5md, "version", H5T_NATIVE_INT32, pair, version.data());
    text_attribute(writer, "name", author());
    text_attribute(creator, "name", "quern");
    text_attribute(creator, "version", "0.1.0");
    const Handle modules = group(h5md, "modules"), units = group(modules, "units");
    attribute(units, "version", H5T_NATIVE_INT32, pair, units_version.data());
    text_attribute(units, "system", "SI");

    group(file, "observables");
    const Handle parameters = group(file, "parameters");
    text_dataset(parameters, "case", case_text);
    text_attribute(parameters, "title", title);
    f.make_trajectory(simulation);
    f.flush();
  });
}

ResultsFile::ResultsFile() : file_(std::make_unique<File>()) {}
ResultsFile::ResultsFile(ResultsFile&&) noexcept = default;
ResultsFile::~ResultsFile() = default;

std::uint64_t ResultsFile::frames() const { return file_->frames; }
std::uint64_t ResultsFile::particles() const { return file_->particles; }
void ResultsFile::append_frame(const Simulation& s) {
  file_->attempt([&] { file_->append_frame(s); });
}
void ResultsFile::append_rows(const Table& table, std::size_t first_row) {
  file_->attempt([&] { file_->append_rows(table, first_row, Chunks::written_again); });
}
void ResultsFile::write_table(const Table& table) {
  file_->attempt([&] { file_->append_rows(table, 0, Chunks::written_once); });
}
void ResultsFile::write_headlines(const std::vector<Headline>& headlines) {
  file_->attempt([&] { file_->write_headlines(headlines); });
}
void ResultsFile::flush() {
  file_->attempt([&] { file_->flush(); });
}
void ResultsFile::sync() {
  file_->attempt([&] {
    file_->flush();
    if (!commit_and_sync(file_->file)) throw Hdf5Failure{};
  });
}

ResultsFile ResultsFile::reopen(const std::string& path, const std::string& case_text, std::uint64_t frames, std::uint64_t particles) {
  keep_quiet();
  const auto refuse = [&](const std::string& why) {
    return InputError("The file " + path + " " + why + ", and the run cannot go on without it; run without --resume to begin anew.");
  };
  if (access(path.c_str(), F_OK) != 0) throw refuse("is missing");
  must_be_free(path);
  if (access(path.c_str(), R_OK | W_OK) != 0) throw refuse(std::string("cannot be opened (") + std::strerror(errno) + ")");
  recover(path);
  // Asked first: HDF5 1.10 crashes when the program ends after an attempt to open an empty file.
  if (H5Fis_hdf5(path.c_str()) <= 0) throw refuse("is no HDF5 file");
  if (!survived([&] { go_on(path, case_text, frames, particles, refuse, true); })) throw refuse("is damaged");
  return go_on(path, case_text, frames, particles, refuse, false);
}

ResultsFile ResultsFile::go_on(const std::string& path, const std::string& case_text, std::uint64_t frames, std::uint64_t particles,
                               const std::function<InputError(const std::string&)>& refuse, bool rehearsal) {
  ResultsFile results;
  File& f = *results.file_;
  f.path = path;
  try {
    f.file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDWR, file_access()));
    if (rehearsal) abandon(f.file);
    if (text_of(f.file, "parameters/case") != case_text) throw refuse("belongs to another case");
  } catch (const Hdf5Failure&) {
    f.give_up();
    throw refuse("is cut short or damaged");
  }
  Handle balls;
  const auto open = [&](const char* name, const std::vector<hsize_t>& extent) {
    Handle set = dataset(balls, name);
    if (!holds(set, extent)) throw refuse(fmt::format("holds less than the {} frames that the checkpoint counts", frames));
    return set;
  };
  try {
    balls = Handle(H5Gopen2(f.file, "particles/balls", H5P_DEFAULT));
    f.frame_step = open("id/step", {frames});
    f.frame_time = open("id/time", {frames});
    f.id = open("id/value", {frames, particles});
    f.position = open("position/value", {frames, particles, 3});
    f.velocity = open("velocity/value", {frames, particles, 3});
    f.spin = open("angular_velocity/value", {frames, particles, 3});
    f.radius = open("radius", {particles});
    f.mass = open("mass", {particles});
    f.species = open("species", {particles});
    f.material = open("material", {particles});
  } catch (const Hdf5Failure&) {
    f.give_up();
    throw refuse("is damaged");
  } catch (...) {
    f.give_up();
    throw;
  }
  f.frames = frames;
  f.particles = particles;
  // Nothing above has changed the file; from here on what was written after the checkpoint is dropped.
  try {
    f.attempt([&] {
      const std::vector<hsize_t> rows{frames}, all{frames, particles}, vectors{frames, particles, 3}, each{particles};
      for (const Handle* set : {&f.frame_step, &f.frame_time}) must(H5Dset_extent(*set, rows.data()));
      for (const Handle* set : {&f.position, &f.velocity, &f.spin}) must(H5Dset_extent(*set, vectors.data()));
      for (const Handle* set : {&f.radius, &f.mass, &f.species, &f.material}) must(H5Dset_extent(*set, each.data()));
      must(H5Dset_extent(f.id, all.data()));
      must(H5Ldelete(f.file, "observables", H5P_DEFAULT));
      group(f.file, "observables");
      f.flush();
    });
  } catch (const WriteError&) {
    if (last_system_error() != 0) throw;
    throw refuse("is damaged");  // nothing hindered the writing
  }
  return results;
}

void ResultsFile::File::flush() {
  must(H5Fflush(file, H5F_SCOPE_GLOBAL));
  if (!commit(file)) throw Hdf5Failure{};
}

void ResultsFile::File::make_trajectory(const Simulation& s) {
  const Handle all = group(file, "particles"), balls = group(all, "balls"), frame_box = group(balls, "box");
  const std::int32_t dimension = 3;
  attribute(frame_box, "dimension", H5T_NATIVE_INT32, Handle(H5Screate(H5S_SCALAR)), &dimension);
  const hsize_t three = 3;
  std::array<char, 24> boundary{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string word = s.domain.period[axis] > 0 ? "periodic" : "none";
    std::copy(word.begin(), word.end(), boundary.begin() + static_cast<std::ptrdiff_t>(8 * axis));
  }
  const Handle vector(H5Screate_simple(1, &three, nullptr));
  attribute(frame_box, "boundary", text_type(8), vector, boundary.data());
  // An open direction has no edge; H5MD asks for a number, and zero says so.
  const Handle edges(H5Dcreate2(frame_box, "edges", H5T_IEEE_F64LE, vector, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  must(H5Dwrite(edges, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, s.domain.period));
  text_attribute(edges, "unit", "m");

  const hsize_t row = static_cast<hsize_t>(std::clamp<std::size_t>(s.particles.position.size(), 64, 16384));
  const auto moving = [&](const char* name, const char* unit, const char* description) {
    const Handle element = group(balls, name);
    Handle value = growing(element, "value", H5T_IEEE_F64LE, {1, row, 3}, 3, &nan, Chunks::written_once);
    text_attribute(value, "unit", unit);
    text_attribute(value, "description", description);
    // All elements share the frames of `id`.
    must(H5Olink(frame_step, element, "step", H5P_DEFAULT, H5P_DEFAULT));
    must(H5Olink(frame_time, element, "time", H5P_DEFAULT, H5P_DEFAULT));
    return value;
  };
  const std::int64_t no_step = 0;
  {
    const Handle element = group(balls, "id");
    frame_step = growing(element, "step", H5T_STD_I64LE, {256}, 0, &no_step, Chunks::written_again);
    frame_time = growing(element, "time", H5T_IEEE_F64LE, {256}, 0, &nan, Chunks::written_again);
    text_attribute(frame_time, "unit", "s");
    id = growing(element, "value", H5T_STD_I32LE, {1, row}, 0, &absent, Chunks::written_once);
    text_attribute(id, "description", "the row's own number, -1 where the particle is not there");
  }
  position = moving("position", "m", "centre of the particle");
  velocity = moving("velocity", "m s-1", "of the centre");
  spin = moving("angular_velocity", "rad s-1", "in the fixed frame");

  const auto fixed = [&](const char* name, hid_t type, const void* fill, const char* unit, const char* description) {
    Handle set = growing(balls, name, type, {row}, 0, fill, Chunks::written_again);
    if (*unit) text_attribute(set, "unit", unit);
    text_attribute(set, "description", description);
    return set;
  };
  radius = fixed("radius", H5T_IEEE_F64LE, &nan, "m", "of the sphere");
  mass = fixed("mass", H5T_IEEE_F64LE, &nan, "kg", "of the particle");
  std::string names, materials;
  for (const Species& kind : s.species) names += (names.empty() ? "" : "\n") + kind.name;
  for (const Material& kind : s.materials) materials += (materials.empty() ? "" : "\n") + kind.name;
  species = fixed("species", H5T_STD_I32LE, &absent, "", "index into the names");
  text_attribute(species, "names", names);
  material = fixed("material", H5T_STD_I32LE, &absent, "", "index into the names");
  text_attribute(material, "names", materials);
}

void ResultsFile::File::append_frame(const Simulation& s) {
  File& f = *this;
  const Particles& p = s.particles;
  const auto owned = static_cast<std::size_t>(p.owned);
  Index last = -1;
  for (std::size_t i = 0; i < owned; ++i) last = std::max(last, p.id[i]);
  const auto rows = std::max(static_cast<std::size_t>(last + 1), static_cast<std::size_t>(f.particles));
  std::vector<Index> row_of(rows, -1);
  for (std::size_t i = 0; i < owned; ++i) row_of[static_cast<std::size_t>(p.id[i])] = static_cast<Index>(i);

  std::vector<double> values(3 * rows);
  const auto put_vectors = [&](hid_t set, const std::vector<Quad>& from) {
    for (std::size_t k = 0; k < rows; ++k) {
      const Quad q = row_of[k] < 0 ? Quad{nan, nan, nan, nan} : from[static_cast<std::size_t>(row_of[k])];
      values[3 * k] = q.x, values[3 * k + 1] = q.y, values[3 * k + 2] = q.z;
    }
    put(set, H5T_NATIVE_DOUBLE, {f.frames, 0, 0}, {1, rows, 3}, values.data());
  };
  put_vectors(f.position, p.position);
  put_vectors(f.velocity, p.velocity);
  put_vectors(f.spin, p.spin);
  std::vector<std::int32_t> numbers(rows);
  for (std::size_t k = 0; k < rows; ++k) numbers[k] = row_of[k] < 0 ? absent : static_cast<std::int32_t>(k);
  put(f.id, H5T_NATIVE_INT32, {f.frames, 0}, {1, rows}, numbers.data());

  // Newcomers bring what does not change.
  const std::size_t known = f.particles, fresh = rows - known;
  const auto put_numbers = [&](hid_t set, hid_t type, auto of, auto none) {
    std::vector<decltype(none)> list(fresh, none);
    for (std::size_t k = 0; k < fresh; ++k)
      if (row_of[known + k] >= 0) list[k] = static_cast<decltype(none)>(of(static_cast<std::size_t>(row_of[known + k])));
    put(set, type, {known}, {fresh}, list.data());
  };
  put_numbers(
      f.radius, H5T_NATIVE_DOUBLE, [&](std::size_t i) { return p.position[i].w; }, nan);
  put_numbers(
      f.mass, H5T_NATIVE_DOUBLE, [&](std::size_t i) { return p.velocity[i].w; }, nan);
  put_numbers(
      f.species, H5T_NATIVE_INT32, [&](std::size_t i) { return p.species[i]; }, absent);
  put_numbers(
      f.material, H5T_NATIVE_INT32, [&](std::size_t i) { return p.material[i]; }, absent);

  const std::int64_t step = s.clock.step;
  const double time = s.clock.time();
  put(f.frame_step, H5T_NATIVE_INT64, {f.frames}, {1}, &step);
  put(f.frame_time, H5T_NATIVE_DOUBLE, {f.frames}, {1}, &time);
  ++f.frames;
  f.particles = rows;
  flush();
}

void ResultsFile::File::append_rows(const Table& table, std::size_t first_row, Chunks chunks) {
  const Handle observables = group(file, "observables"), home = group(observables, table.name);
  if (!table.description.empty()) text_attribute(home, "description", table.description);
  for (const Column& column : table.columns) {
    Handle& set = columns[table.name + "/" + column.name];
    if (!column.labels.empty()) {
      std::size_t longest = 1;
      for (const std::string& label : column.labels) longest = std::max(longest, label.size());
      std::string packed;
      for (const std::string& label : column.labels) packed += label + std::string(longest - label.size(), '\0');
      const hsize_t count = column.labels.size();
      const Handle type = text_type(longest), space(H5Screate_simple(1, &count, nullptr));
      if (set.open()) must(H5Ldelete(home, column.name.c_str(), H5P_DEFAULT));
      set = Handle(H5Dcreate2(home, column.name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
      must(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, packed.data()));
      text_attribute(set, "description", column.description);
      continue;
    }
    if (!set.open()) {
      set = growing(home, column.name.c_str(), H5T_IEEE_F64LE, {1024}, 0, &nan, chunks);
      text_attribute(set, "unit", column.unit);
      text_attribute(set, "description", column.description);
    }
    if (first_row < column.values.size())
      put(set, H5T_NATIVE_DOUBLE, {first_row}, {column.values.size() - first_row}, column.values.data() + first_row);
  }
}

void ResultsFile::File::write_headlines(const std::vector<Headline>& headlines) {
  const Handle observables = group(file, "observables"), summary = group(observables, "summary");
  const Handle scalar(H5Screate(H5S_SCALAR));
  for (const Headline& headline : headlines) {
    if (H5Lexists(summary, headline.key.c_str(), H5P_DEFAULT) > 0) must(H5Ldelete(summary, headline.key.c_str(), H5P_DEFAULT));
    const Handle set(H5Dcreate2(summary, headline.key.c_str(), H5T_IEEE_F64LE, scalar, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    must(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &headline.value));
    text_attribute(set, "unit", headline.unit);
    text_attribute(set, "description", headline.description);
    if (headline.ci95) {
      const hsize_t two = 2;
      attribute(set, "ci95", H5T_NATIVE_DOUBLE, Handle(H5Screate_simple(1, &two, nullptr)), headline.ci95->data());
    }
  }
}

}  // namespace quern
