#include "src/output/committed_file.hpp"
#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <new>
#include <vector>
#include "src/base/archive.hpp"
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"

namespace quern {
namespace {

thread_local int system_error = 0;

bool refused() {
  system_error = errno;
  return false;
}

struct Change {
  std::uint64_t at = 0;
  std::string bytes;
  template <class Archive>
  void archive(Archive& a) {
    a(at, bytes);
  }
};

std::string journal_of(const std::string& path) { return path + ".journal"; }

std::uint32_t checksum_of(const std::string& bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

bool write_at(int file, std::uint64_t at, const char* from, std::size_t count) {
  while (count > 0) {
    const ssize_t written = pwrite(file, from, count, static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) return refused();
    from += written, at += static_cast<std::uint64_t>(written), count -= static_cast<std::size_t>(written);
  }
  return true;
}

// The first block comes first, which says where the file ends: what is still old may be read with a later end, but not the other way round.
bool make(int file, std::vector<Change>& changes, std::uint64_t end) {
  std::sort(changes.begin(), changes.end(), [](const Change& a, const Change& b) { return a.at < b.at; });
  for (const Change& change : changes)
    if (change.at < end && !write_at(file, change.at, change.bytes.data(), std::min<std::uint64_t>(change.bytes.size(), end - change.at))) return false;
  return ftruncate(file, static_cast<off_t>(end)) == 0 || refused();
}

// False where it is none, or of a longer file: one has its full length before a journal is written.
bool read_journal(const std::string& bytes, int file, std::uint64_t& end, std::vector<Change>& changes) {
  try {
    ArchiveReader archive(bytes);
    archive(end, changes);
  } catch (const UnfitData&) {
    return false;
  }
  struct stat now {};
  return fstat(file, &now) == 0 && end <= static_cast<std::uint64_t>(now.st_size);
}

// HDF5's handle of an open file.
struct CommittedFile {
  H5FD_t head;  // HDF5's own part comes first
  std::string path;
  int descriptor = -1;
  bool lost = false;
  haddr_t allocated = 0;        // by HDF5: its "end of allocation"
  std::uint64_t committed = 0;  // where the committed state ends: nobody points beyond
  std::uint64_t written = 0;    // where the file ends for HDF5
  std::vector<Change> waiting;  // in the order written; they do not overlap

  ~CommittedFile() {
    if (descriptor >= 0) close(descriptor);
  }

  bool read(std::uint64_t at, std::size_t count, char* to) const {
    for (std::size_t got = 0; got < count;) {
      const ssize_t part = pread(descriptor, to + got, count - got, static_cast<off_t>(at + got));
      if (part < 0 && errno == EINTR) continue;
      if (part < 0) return refused();
      if (part == 0) {  // beyond the end there are zeros
        std::memset(to + got, 0, count - got);
        break;
      }
      got += static_cast<std::size_t>(part);
    }
    for (const Change& change : waiting) {
      const std::uint64_t from = std::max(at, change.at), until = std::min(at + count, change.at + change.bytes.size());
      if (from < until) std::memcpy(to + (from - at), change.bytes.data() + (from - change.at), until - from);
    }
    return true;
  }

  bool write(std::uint64_t at, std::size_t count, const char* from) {
    if (at < committed || lost)
      keep_back({at, std::string(from, count)});
    else if (!write_at(descriptor, at, from, count))
      return false;
    written = std::max(written, at + count);
    return true;
  }

  void keep_back(Change fresh) {
    const std::uint64_t first = fresh.at, last = fresh.at + fresh.bytes.size();
    std::vector<Change> cut;
    for (Change& old : waiting) {
      const std::uint64_t begin = old.at, end = old.at + old.bytes.size();
      if (end <= first || begin >= last) {
        cut.push_back(std::move(old));
        continue;
      }
      if (begin < first) cut.push_back({begin, old.bytes.substr(0, first - begin)});
      if (end > last) cut.push_back({last, old.bytes.substr(last - begin)});
    }
    cut.push_back(std::move(fresh));
    waiting = std::move(cut);
  }

  bool commit() {
    if (lost) return true;
    struct stat now {};
    if (fstat(descriptor, &now) != 0) return refused();
    // A file must not be shorter than it says of itself.
    const off_t missing = static_cast<off_t>(allocated) - now.st_size;
    if (missing > 0 && fallocate(descriptor, 0, now.st_size, missing) != 0) {
      const bool unknown_here = errno == EOPNOTSUPP || errno == ENOSYS;
      if (!unknown_here || ftruncate(descriptor, static_cast<off_t>(allocated)) != 0) return refused();
    }
    if (waiting.empty()) {
      committed = allocated;
      return true;
    }
    try {
      ArchiveWriter archive;
      std::uint64_t end = allocated;
      archive(end, waiting);
      std::uint32_t checksum = checksum_of(archive.bytes);
      errno = 0;
      write_whole_file(journal_of(path), {std::string_view(reinterpret_cast<const char*>(&checksum), sizeof checksum), archive.bytes});
    } catch (const WriteError&) {
      return refused();
    }
    if (!make(descriptor, waiting, allocated)) return false;
    unlink(journal_of(path).c_str());
    waiting.clear();
    committed = allocated;
    return true;
  }
};

CommittedFile& of(H5FD_t* file) { return *reinterpret_cast<CommittedFile*>(file); }
const CommittedFile& of(const H5FD_t* file) { return *reinterpret_cast<const CommittedFile*>(file); }
herr_t verdict(bool good) { return good ? 0 : -1; }

H5FD_t* open_file(const char* path, unsigned flags, hid_t, haddr_t) {
  const int how = (flags & H5F_ACC_RDWR ? O_RDWR : O_RDONLY) | (flags & H5F_ACC_TRUNC ? O_TRUNC : 0) |
                  (flags & H5F_ACC_CREAT ? O_CREAT : 0) | (flags & H5F_ACC_EXCL ? O_EXCL : 0) | O_CLOEXEC;
  auto file = std::make_unique<CommittedFile>();
  std::memset(&file->head, 0, sizeof file->head);
  file->path = path;
  file->descriptor = open(path, how, 0666);
  struct stat now {};
  if (file->descriptor < 0 || fstat(file->descriptor, &now) != 0) {
    refused();
    return nullptr;
  }
  file->committed = file->written = static_cast<std::uint64_t>(now.st_size);
  return &file.release()->head;
}

herr_t close_file(H5FD_t* head) {
  const std::unique_ptr<CommittedFile> file(&of(head));
  return verdict(file->commit());
}

H5FD_class_t driver_class() {
  H5FD_class_t c{};
#ifdef H5FD_CLASS_VERSION
  c.version = H5FD_CLASS_VERSION;
  c.value = static_cast<H5FD_class_value_t>(600);  // of those free for anybody's use
#endif
  c.name = "quern";
  c.maxaddr = (haddr_t{1} << 62) - 1;
  c.fc_degree = H5F_CLOSE_WEAK;
  c.open = open_file;
  c.close = close_file;
  c.query = [](const H5FD_t*, unsigned long* flags) -> herr_t {
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA |
             H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    return 0;
  };
  c.get_eoa = [](const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; };
  c.set_eoa = [](H5FD_t* file, H5FD_mem_t, haddr_t end) -> herr_t {
    of(file).allocated = end;
    return 0;
  };
  c.get_eof = [](const H5FD_t* file, H5FD_mem_t) -> haddr_t { return of(file).written; };
  c.get_handle = [](H5FD_t* file, hid_t, void** handle) -> herr_t {
    *handle = file;
    return 0;
  };
  c.read = [](H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, void* to) -> herr_t {
    return verdict(of(file).read(at, count, static_cast<char*>(to)));
  };
  c.write = [](H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, const void* from) -> herr_t {
    try {
      return verdict(of(file).write(at, count, static_cast<const char*>(from)));
    } catch (const std::bad_alloc&) {
      system_error = ENOMEM;
      return -1;
    }
  };
  // The file gets its length with the commit.
  c.truncate = [](H5FD_t* file, hid_t, hbool_t) -> herr_t {
    of(file).written = of(file).allocated;
    return 0;
  };
  const H5FD_mem_t dichotomy[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(dichotomy), std::end(dichotomy), c.fl_map);
  return c;
}

CommittedFile* handle_of(hid_t file) {
  void* handle = nullptr;
  return H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0 ? nullptr : static_cast<CommittedFile*>(handle);
}

}  // namespace

void use_commits(std::int64_t access) {
  static const H5FD_class_t kind = driver_class();
  static const hid_t driver = H5FDregister(&kind);
  H5Pset_driver(access, driver, nullptr);
}

bool commit(std::int64_t file) {
  CommittedFile* handle = handle_of(file);
  return handle != nullptr && handle->commit();
}

bool commit_and_sync(std::int64_t file) {
  CommittedFile* handle = handle_of(file);
  return handle != nullptr && handle->commit() && (handle->lost || fsync(handle->descriptor) == 0 || refused());
}

void abandon(std::int64_t file) {
  if (CommittedFile* handle = handle_of(file)) handle->lost = true;
}

int last_system_error() { return system_error; }
void forget_system_error() { system_error = 0; }

void recover(const std::string& path) {
  std::ifstream stream(journal_of(path), std::ios::binary);
  if (!stream) return;
  const std::string all{std::istreambuf_iterator<char>(stream), {}};
  std::uint32_t checksum = 0;
  if (all.size() > sizeof checksum) {
    std::memcpy(&checksum, all.data(), sizeof checksum);
    const std::string bytes = all.substr(sizeof checksum);
    if (checksum_of(bytes) == checksum) {
      std::uint64_t end = 0;
      std::vector<Change> changes;
      const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
      if (file >= 0 && !read_journal(bytes, file, end, changes)) {
        close(file);
        throw InputError("The file " + journal_of(path) + " is not the journal of " + path + "; delete it, and what is missing there is lost.");
      }
      const bool good = file >= 0 ? make(file, changes, end) : refused();
      if (file >= 0) close(file);
      if (!good) throw WriteError("The file " + path + " cannot be written: " + std::strerror(system_error) + ".");
    }
  }
  unlink(journal_of(path).c_str());
}

}  // namespace quern
