#include "src/output/results_file.hpp"
#include <fcntl.h>
#include <hdf5.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include "src/base/error.hpp"

namespace quern {
namespace {

// Owns an HDF5 identifier of any kind.
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {
    if (id < 0) throw RunError("results.h5 cannot be written: the disk may be full, or the directory is not writable.");
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
      case H5I_FILE: H5Fclose(id_); break;
      case H5I_GROUP: H5Gclose(id_); break;
      case H5I_DATASET: H5Dclose(id_); break;
      case H5I_DATASPACE: H5Sclose(id_); break;
      case H5I_DATATYPE: H5Tclose(id_); break;
      case H5I_ATTR: H5Aclose(id_); break;
      default: H5Pclose(id_);
    }
    id_ = -1;
  }
  bool open() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

 private:
  hid_t id_ = -1;
};

void must(herr_t status) {
  if (status < 0) throw RunError("results.h5 cannot be written: the disk may be full.");
}

// HDF5 prints a stack of its own at every error; ours are exceptions.
void keep_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

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

// An empty array that can grow in every direction, but for the last where `fixed_last` gives its extent.
Handle growing(hid_t parent, const char* name, hid_t type, const std::vector<hsize_t>& chunk, hsize_t fixed_last, const void* fill) {
  std::vector<hsize_t> dims(chunk.size(), 0), most(chunk.size(), H5S_UNLIMITED);
  if (fixed_last > 0) dims.back() = most.back() = fixed_last;
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), most.data()));
  const Handle made(H5Pcreate(H5P_DATASET_CREATE));
  must(H5Pset_chunk(made, static_cast<int>(chunk.size()), chunk.data()));
  must(H5Pset_fill_value(made, type, fill));
  must(H5Pset_shuffle(made));
  must(H5Pset_deflate(made, 1));
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

// The end of the file as its first block states it (HDF5 file format specification 3.0, superblock version 0). HDF5 writes it
// last, after headers that already point past it: a process killed between the two would leave a file that cannot be read. So a
// later end is stated before a flush, and the true one after it.
class StatedEnd {
 public:
  StatedEnd() = default;
  explicit StatedEnd(const std::string& path) : descriptor_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {
    std::array<unsigned char, 16> head{};
    const bool known = pread(descriptor_, head.data(), head.size(), 0) == static_cast<ssize_t>(head.size()) && head[8] == 0 && head[13] == 8;
    if (!known) close_it();
  }
  StatedEnd(const StatedEnd&) = delete;
  StatedEnd& operator=(StatedEnd&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~StatedEnd() { close_it(); }

  void state(std::uint64_t end) {
    struct stat now {};
    if (descriptor_ < 0 || fstat(descriptor_, &now) != 0) return;
    // Longer than stated is well; shorter is not.
    if (static_cast<std::uint64_t>(now.st_size) < end && ftruncate(descriptor_, static_cast<off_t>(end)) != 0) return;
    std::array<unsigned char, 8> bytes{};
    for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<unsigned char>(end >> (8 * k));
    if (pwrite(descriptor_, bytes.data(), bytes.size(), 40) != static_cast<ssize_t>(bytes.size()))
      throw RunError("results.h5 cannot be written: the disk may be full.");
  }

 private:
  void close_it() {
    if (descriptor_ >= 0) close(descriptor_);
    descriptor_ = -1;
  }
  int descriptor_ = -1;
};

Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS));
  // The old layout, which has no mark of being open for writing: a file whose writer was killed opens like any other.
  must(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18));
  // What describes the arrays goes to disk only with flush(), after the numbers that it describes.
  H5AC_cache_config_t cache{};
  cache.version = H5AC__CURR_CACHE_CONFIG_VERSION;
  must(H5Pget_mdc_config(access, &cache));
  cache.evictions_enabled = false;
  cache.incr_mode = H5C_incr__off;
  cache.flash_incr_mode = H5C_flash_incr__off;
  cache.decr_mode = H5C_decr__off;
  must(H5Pset_mdc_config(access, &cache));
  must(H5Pset_file_locking(access, false, true));  // so that others may read while the run goes on
  return access;
}

Handle dataset(hid_t parent, const char* path) { return Handle(H5Dopen2(parent, path, H5P_DEFAULT)); }

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int32_t absent = -1;

}  // namespace

struct ResultsFile::File {
  Handle file;
  Handle frame_step, frame_time;               // [frame]
  Handle position, velocity, spin, id;         // [frame][particle]
  Handle radius, mass, species, material;      // [particle]
  std::map<std::string, Handle> columns;       // of the observables
  hsize_t frames = 0, particles = 0;
  std::uint64_t waiting = 0;                   // bytes given to HDF5 since the last flush, at most
  StatedEnd end;

  void make_trajectory(const Simulation& s);
};

ResultsFile::ResultsFile(const std::string& path, const Simulation& simulation, const std::string& title, const std::string& case_text)
    : file_(std::make_unique<File>()) {
  keep_quiet();
  file_->file = Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, file_access()));
  const hid_t file = file_->file;

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
  file_->make_trajectory(simulation);
  flush();
  file_->end = StatedEnd(path);
}

ResultsFile::ResultsFile() : file_(std::make_unique<File>()) {}
ResultsFile::ResultsFile(ResultsFile&&) noexcept = default;
ResultsFile::~ResultsFile() = default;

std::uint64_t ResultsFile::frames() const { return file_->frames; }
std::uint64_t ResultsFile::particles() const { return file_->particles; }

ResultsFile ResultsFile::reopen(const std::string& path, std::uint64_t frames, std::uint64_t particles) {
  keep_quiet();
  const hid_t opened = H5Fopen(path.c_str(), H5F_ACC_RDWR, file_access());
  if (opened < 0) throw InputError(path + " cannot be opened to go on with it: it is missing, locked or cut. Run without --resume to begin anew.");
  ResultsFile results;
  File& f = *results.file_;
  f.file = Handle(opened);
  const Handle balls(H5Gopen2(f.file, "particles/balls", H5P_DEFAULT));
  const auto open = [&](const char* name, std::vector<hsize_t> extent) {
    Handle set = dataset(balls, name);
    must(H5Dset_extent(set, extent.data()));
    return set;
  };
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
  f.frames = frames;
  f.particles = particles;
  must(H5Ldelete(f.file, "observables", H5P_DEFAULT));
  group(f.file, "observables");
  f.end = StatedEnd(path);
  results.flush();
  return results;
}

void ResultsFile::flush() {
  haddr_t end = 0;
  must(H5Fget_eoa(file_->file, &end));
  // Numbers that do not compress grow a little; each array that grows may begin a new chunk and a new page of its index.
  constexpr std::uint64_t index_room = 1 << 20;
  file_->end.state(end + file_->waiting + file_->waiting / 8 + index_room);
  must(H5Fflush(file_->file, H5F_SCOPE_GLOBAL));
  file_->waiting = 0;
  must(H5Fget_eoa(file_->file, &end));
  file_->end.state(end);
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
    Handle value = growing(element, "value", H5T_IEEE_F64LE, {1, row, 3}, 3, &nan);
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
    frame_step = growing(element, "step", H5T_STD_I64LE, {256}, 0, &no_step);
    frame_time = growing(element, "time", H5T_IEEE_F64LE, {256}, 0, &nan);
    text_attribute(frame_time, "unit", "s");
    id = growing(element, "value", H5T_STD_I32LE, {1, row}, 0, &absent);
    text_attribute(id, "description", "the row's own number, -1 where the particle is not there");
  }
  position = moving("position", "m", "centre of the particle");
  velocity = moving("velocity", "m s-1", "of the centre");
  spin = moving("angular_velocity", "rad s-1", "in the fixed frame");

  const auto fixed = [&](const char* name, hid_t type, const void* fill, const char* unit, const char* description) {
    Handle set = growing(balls, name, type, {row}, 0, fill);
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

void ResultsFile::append_frame(const Simulation& s) {
  File& f = *file_;
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
  put_numbers(f.radius, H5T_NATIVE_DOUBLE, [&](std::size_t i) { return p.position[i].w; }, nan);
  put_numbers(f.mass, H5T_NATIVE_DOUBLE, [&](std::size_t i) { return p.velocity[i].w; }, nan);
  put_numbers(f.species, H5T_NATIVE_INT32, [&](std::size_t i) { return p.species[i]; }, absent);
  put_numbers(f.material, H5T_NATIVE_INT32, [&](std::size_t i) { return p.material[i]; }, absent);

  const std::int64_t step = s.clock.step;
  const double time = s.clock.time();
  put(f.frame_step, H5T_NATIVE_INT64, {f.frames}, {1}, &step);
  put(f.frame_time, H5T_NATIVE_DOUBLE, {f.frames}, {1}, &time);
  ++f.frames;
  f.particles = rows;
  f.waiting += 256 * rows;  // more than one frame's rows take, newcomers included
  flush();
}

void ResultsFile::append_rows(const Table& table, std::size_t first_row) {
  const Handle observables = group(file_->file, "observables"), home = group(observables, table.name);
  if (!table.description.empty()) text_attribute(home, "description", table.description);
  for (const Column& column : table.columns) {
    Handle& set = file_->columns[table.name + "/" + column.name];
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
      set = growing(home, column.name.c_str(), H5T_IEEE_F64LE, {1024}, 0, &nan);
      text_attribute(set, "unit", column.unit);
      text_attribute(set, "description", column.description);
    }
    file_->waiting += 8 * column.values.size();
    if (first_row < column.values.size())
      put(set, H5T_NATIVE_DOUBLE, {first_row}, {column.values.size() - first_row}, column.values.data() + first_row);
  }
}

void ResultsFile::write_headlines(const std::vector<Headline>& headlines) {
  const Handle observables = group(file_->file, "observables"), summary = group(observables, "summary");
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
