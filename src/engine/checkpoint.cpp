#include "src/engine/checkpoint.hpp"
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include "src/base/archive.hpp"
#include "src/base/error.hpp"
#include "src/contact/candidates.hpp"

namespace quern {
namespace {

constexpr char magic[8] = {'q', 'u', 'e', 'r', 'n', 'c', 'k', 'p'};
constexpr std::uint32_t version = 2;

struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t checksum;  // CRC-32 of what follows
  std::uint64_t length;    // of what follows
};

std::uint32_t checksum_of(const std::string& bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

template <class Archive>
void archive_block(Archive& a, ContactBlock& b) {
  a(b.first, b.last, b.candidates, b.halo, b.wall_candidates, b.triangles, b.wall_slots, b.wall_normals, b.sliding, b.rolling, b.record,
    b.free_slots, b.rolls, b.records);
}

template <class Archive>
void archive_contacts(Archive& a, Contacts& c) {
  a(c.block_size, c.records, c.rolls, c.skin, c.motion, c.travelled, c.wall_travelled, c.searches, c.steps_since_search, c.ended, c.sums, c.wall_sums);
}

template <class Archive>
void archive_particles(Archive& a, Particles& p) {
  a(p.position, p.velocity, p.spin, p.acceleration, p.angular_acceleration, p.material, p.species, p.id, p.owned);
}

void require(bool good, const std::string& path, const char* what) {
  if (!good) throw RunError(fmt::format("{}: {} ({}); the checkpoint before it is untouched", path, what, std::strerror(errno)));
}

// The payload, or a sentence that says why there is none.
std::string read_one(const std::string& path, const std::string& identity, std::string& complaint) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    complaint = fmt::format("{} cannot be read", path);
    return {};
  }
  std::ostringstream text;
  text << in.rdbuf();
  const std::string all = text.str();
  Header header;
  if (all.size() < sizeof header || std::memcmp(all.data(), magic, sizeof magic) != 0) {
    complaint = fmt::format("{} is not a checkpoint of quern", path);
    return {};
  }
  std::memcpy(&header, all.data(), sizeof header);
  if (header.version != version) {
    complaint = fmt::format("{} has format {}, and this quern reads format {}", path, header.version, version);
    return {};
  }
  std::string rest = all.substr(sizeof header);
  if (rest.size() != header.length || checksum_of(rest) != header.checksum) {
    complaint = fmt::format("{} is torn: {} bytes of {}, or a wrong checksum", path, rest.size(), header.length);
    return {};
  }
  std::string stored_identity, bytes;
  ArchiveReader reader(rest);
  reader(stored_identity, bytes);
  if (stored_identity != identity) {
    complaint = fmt::format("{} belongs to another case", path);
    return {};
  }
  return bytes;
}

}  // namespace

std::string pack_state(Simulation& s) {
  ArchiveWriter a;
  std::uint64_t blocks = s.contacts.blocks.size();
  a(s.clock, s.ledger, s.reference_energy, s.extent_of_particles);
  archive_particles(a, s.particles);
  archive_contacts(a, s.contacts);
  a(blocks);
  for (ContactBlock& block : s.contacts.blocks) archive_block(a, block);
  for (Wall& wall : s.walls) a(wall.force, wall.torque);
  return std::move(a.bytes);
}

void unpack_state(const std::string& bytes, Simulation& s) {
  ArchiveReader a(bytes);
  std::uint64_t blocks = 0;
  a(s.clock, s.ledger, s.reference_energy, s.extent_of_particles);
  archive_particles(a, s.particles);
  archive_contacts(a, s.contacts);
  a(blocks);
  s.contacts.blocks.assign(static_cast<std::size_t>(blocks), {});
  for (ContactBlock& block : s.contacts.blocks) {
    archive_block(a, block);
    block.load.resize(static_cast<std::size_t>(block.size()) + block.halo.size() + 2);
    block.walls.resize(s.pair_laws.size());
    block.wall_sums.resize(s.walls.size());
  }
  link_halos(s.contacts.blocks, s.contacts.block_size);
  for (Wall& wall : s.walls) a(wall.force, wall.torque);
  if (!a.at_end()) throw InputError("the checkpoint holds more than this case expects");
  s.move_walls();
}

void write_checkpoint(const std::string& path, const std::string& identity, const std::string& bytes) {
  ArchiveWriter a;
  std::string name = identity, copy = bytes;
  a(name, copy);
  Header header{};
  std::memcpy(header.magic, magic, sizeof magic);
  header.version = version;
  header.checksum = checksum_of(a.bytes);
  header.length = a.bytes.size();

  const std::string aside = path + ".new";
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  require(file >= 0, aside, "cannot be written");
  const auto write_all = [&](const char* from, std::size_t count) {
    while (count > 0) {
      const ssize_t written = ::write(file, from, count);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      from += written;
      count -= static_cast<std::size_t>(written);
    }
    return true;
  };
  const bool whole = write_all(reinterpret_cast<const char*>(&header), sizeof header) && write_all(a.bytes.data(), a.bytes.size()) && ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (!whole) {
    ::unlink(aside.c_str());
    errno = error;
    require(false, aside, "cannot be written whole");
  }
  if (::access(path.c_str(), F_OK) == 0) require(::rename(path.c_str(), (path + ".previous").c_str()) == 0, path, "cannot be kept");
  require(::rename(aside.c_str(), path.c_str()) == 0, path, "cannot be put in place");
  // The renames themselves must survive a power cut: sync the directory.
  const std::string folder = path.substr(0, path.find_last_of('/') == std::string::npos ? 0 : path.find_last_of('/'));
  if (const int directory = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
}

Checkpoint read_checkpoint(const std::string& path, const std::string& identity) {
  std::string complaint, older;
  if (std::string bytes = read_one(path, identity, complaint); complaint.empty()) return {std::move(bytes), {}};
  if (std::string bytes = read_one(path + ".previous", identity, older); older.empty())
    return {std::move(bytes), complaint + "; going on from the one before it"};
  throw InputError(complaint + ", and " + older + ". There is nothing to go on from; run without --resume to begin anew.");
}

void remove_checkpoints(const std::string& path) {
  for (const char* ending : {"", ".previous", ".new"}) ::unlink((path + ending).c_str());
}

}  // namespace quern
