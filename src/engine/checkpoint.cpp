#include "src/engine/checkpoint.hpp"
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <boost/crc.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include "src/base/archive.hpp"
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/contact/candidates.hpp"
#include "src/engine/soundness.hpp"

namespace quern {
namespace {

constexpr char magic[8] = {'q', 'u', 'e', 'r', 'n', 'c', 'k', 'p'};
constexpr std::uint32_t version = 13;

struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t checksum;  // CRC-32 of what follows
  std::uint64_t length;    // of what follows
};

std::uint32_t checksum_of(std::initializer_list<std::string_view> pieces) {
  boost::crc_32_type crc;
  for (const std::string_view piece : pieces) crc.process_bytes(piece.data(), piece.size());
  return crc.checksum();
}

// What stands between the header and the state: the identity and the state's length.
std::string preamble(const std::string& identity, std::uint64_t length) {
  return ArchiveWriter::written_by([&](ArchiveWriter& a) {
    std::string name = identity;
    a(name, length);
  });
}

template <class Archive>
void archive_block(Archive& a, ContactBlock& b) {
  a(b.first, b.last, b.candidates, b.bonds, b.halo, b.wall_candidates, b.triangles, b.wall_slots, b.wall_normals, b.sliding, b.rolling, b.effects,
    b.shaped, b.record, b.free_slots, b.rolls, b.remembers, b.records, b.shapes);
}

template <class Archive>
void archive_contacts(Archive& a, Contacts& c) {
  a(c.block_size, c.records, c.rolls, c.shapes, c.skin, c.wall_skin, c.motion, c.travelled, c.wall_travelled, c.searches, c.steps_since_search, c.ended, c.sums, c.wall_sums);
}

template <class Archive>
void archive_particles(Archive& a, Particles& p) {
  a(p.position, p.velocity, p.spin, p.acceleration, p.angular_acceleration, p.material, p.species, p.id, p.orientation, p.shape, p.momentum, p.inertia, p.owned);
}

// The line in which two cases differ first, in a few words.
std::string difference(const std::string& there, const std::string& here) {
  std::istringstream a(there), b(here);
  std::string then, now;
  for (int line = 1;; ++line) {
    const bool more = static_cast<bool>(std::getline(a, then)), still = static_cast<bool>(std::getline(b, now));
    if (!more && !still) return "its end";
    if (!more) then = "nothing";
    if (!still) now = "nothing";
    if (then != now) return fmt::format("line {} of its complete case is `{:.60}`, now it is `{:.60}`", line, then, now);
  }
}

struct Reading {
  Checkpoint found;
  std::string complaint;  // a clause that says why there is none
  bool foreign = false;
};

// All of a file, in one piece of memory.
bool read_whole(const std::string& path, std::string& contents) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return false;
  const std::streamoff size = in.tellg();
  if (size < 0) return false;
  contents.resize(static_cast<std::size_t>(size));
  in.seekg(0);
  in.read(contents.data(), size);
  return static_cast<bool>(in);
}

Reading read_one(const std::string& path, const std::string& identity) {
  const auto none = [](std::string complaint, bool foreign = false) { return Reading{{}, std::move(complaint), foreign}; };
  Reading reading;
  if (!read_whole(path, reading.found.file)) return none(fmt::format("{} cannot be read ({})", path, std::strerror(errno)));
  const std::string_view all = reading.found.file;
  Header header;
  if (all.size() < sizeof header || std::memcmp(all.data(), magic, sizeof magic) != 0) return none(fmt::format("{} is not a checkpoint of quern", path));
  std::memcpy(&header, all.data(), sizeof header);
  if (header.version != version) return none(fmt::format("{} has format {}, and this quern reads format {}", path, header.version, version));
  const std::string_view rest = all.substr(sizeof header);
  if (rest.size() != header.length) return none(fmt::format("{} is torn: {} bytes of {}", path, rest.size(), header.length));
  if (checksum_of({rest}) != header.checksum) return none(fmt::format("{} is damaged: its checksum is wrong", path));
  std::string stored_identity;
  std::uint64_t length = 0;
  ArchiveReader reader(rest);
  reader(stored_identity, length);
  if (stored_identity != identity) return none(fmt::format("{} belongs to another case: {}", path, difference(stored_identity, identity)), true);
  if (length > rest.size()) return none(fmt::format("{} is damaged: it names a length that it does not hold", path));
  reading.found.begin = all.size() - static_cast<std::size_t>(length);
  return reading;
}

}  // namespace

void archive_state(ArchiveWriter& a, Simulation& s) {
  std::uint64_t blocks = s.contacts.blocks.size();
  a(s.clock, s.ledger, s.reference_energy, s.extent_of_particles);
  archive_particles(a, s.particles);
  a(s.bonds);
  archive_contacts(a, s.contacts);
  a(blocks);
  for (ContactBlock& block : s.contacts.blocks) archive_block(a, block);
  for (Wall& wall : s.walls) a(wall.force, wall.torque);
}

void archive_state(ArchiveReader& a, Simulation& s) {
  const Extent extent(s);
  std::uint64_t blocks = 0;
  a(s.clock, s.ledger, s.reference_energy, s.extent_of_particles);
  archive_particles(a, s.particles);
  a(s.bonds);
  archive_contacts(a, s.contacts);
  a(blocks);
  if (blocks > extent.particles + 1) throw UnfitData("an index in it leads nowhere");
  s.contacts.blocks.assign(static_cast<std::size_t>(blocks), {});
  for (ContactBlock& block : s.contacts.blocks) archive_block(a, block);
  if (!sound(s, extent)) throw UnfitData("an index in it leads nowhere");
  for (ContactBlock& block : s.contacts.blocks) {
    block.load.resize(static_cast<std::size_t>(block.size()) + block.halo.size() + 2);
    block.walls.resize(s.pair_laws.size());
    if (block.shapes) block.shape_walls.resize(s.pair_laws.size());
    block.wall_sums.resize(s.walls.size());
  }
  link_halos(s.contacts.blocks, s.contacts.block_size);
  for (Wall& wall : s.walls) a(wall.force, wall.torque);
  s.move_walls();
}

void write_checkpoint(const std::string& path, const std::string& identity, std::string_view bytes) {
  const std::string before_state = preamble(identity, bytes.size());
  Header header{};
  std::memcpy(header.magic, magic, sizeof magic);
  header.version = version;
  header.checksum = checksum_of({before_state, bytes});
  header.length = before_state.size() + bytes.size();

  const std::string fresh = path + ".new";
  write_whole_file(fresh, {std::string_view(reinterpret_cast<const char*>(&header), sizeof header), before_state, bytes}, Synced::yes);
  const std::string before = path + ".previous";
  if (::access(path.c_str(), F_OK) != 0) {
    rename_file(fresh, path);
  } else if (::renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, path.c_str(), RENAME_EXCHANGE) == 0) {
    rename_file(fresh, before);
  } else {
    // File systems that cannot exchange: for a moment there is only the one before, and reading takes that.
    rename_file(path, before);
    rename_file(fresh, path);
  }
}

Checkpoint read_checkpoint(const std::string& path, const std::string& identity) {
  const std::string before = path + ".previous";
  if (::access(path.c_str(), F_OK) != 0 && ::access(before.c_str(), F_OK) != 0 && errno == ENOENT)
    throw InputError(fmt::format(
        "There is no checkpoint {} to go on from: the run has ended, or never wrote one. Run without --resume to begin anew.", path));
  Reading newest = read_one(path, identity);
  if (newest.complaint.empty()) return std::move(newest.found);
  Reading older = read_one(before, identity);
  if (older.complaint.empty()) {
    older.found.remark = newest.complaint + "; going on from the one before it";
    return std::move(older.found);
  }
  if (!newest.foreign && ::access(before.c_str(), F_OK) == 0) newest.complaint += "; " + older.complaint;
  throw InputError(newest.complaint + ". There is nothing to go on from; run without --resume to begin anew.");
}

void remove_checkpoints(const std::string& path) {
  for (const char* ending : {"", ".previous", ".new", ".new.part"}) ::unlink((path + ending).c_str());
}

}  // namespace quern
