#include "src/wall/stl.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <compare>
#include <cstring>
#include <fstream>
#include <string_view>

#include "src/base/error.hpp"

namespace quern {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = std::array<std::size_t, 3>;
namespace processing = CGAL::Polygon_mesh_processing;

// Three corners for each triangle, as they stand in the file.
struct Soup {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
};

std::string read_whole(const std::string& name) {
  std::error_code error;
  if (!std::filesystem::exists(name, error)) throw InputError(fmt::format("{}: there is no such file.", name));
  if (!std::filesystem::is_regular_file(name, error)) throw InputError(fmt::format("{}: this is not a file.", name));
  constexpr std::uintmax_t largest = std::uintmax_t{1} << 30;  // [bytes]
  if (const std::uintmax_t size = std::filesystem::file_size(name, error); !error && size > largest)
    throw InputError(fmt::format("{}: this file has {:.1f} GB; an STL file has at most 1 GB, which is 20 million triangles.", name, 1e-9 * static_cast<double>(size)));
  std::ifstream in(name, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in) throw InputError(fmt::format("{}: the file cannot be read.", name));
  if (bytes.empty()) throw InputError(fmt::format("{}: the file is empty; an STL file with at least one triangle is needed.", name));
  return bytes;
}

// What was found, fit for a message: short and printable.
std::string shown(std::string_view word) {
  std::string text;
  for (const char c : word.substr(0, 30)) text += c >= 32 && c < 127 ? c : '?';
  return word.size() > 30 ? text + "..." : text;
}

bool same_word(std::string_view a, std::string_view lower_case) {
  return a.size() == lower_case.size() &&
         std::equal(a.begin(), a.end(), lower_case.begin(), [](char x, char y) { return (x >= 'A' && x <= 'Z' ? x - 'A' + 'a' : x) == y; });
}

class TextReader {
 public:
  TextReader(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  Soup read() {
    while (skip_blank(), at_ < text_.size()) {
      expect("solid");
      skip_line();
      for (std::string_view word = next(); !same_word(word, "endsolid"); word = next()) {
        if (!same_word(word, "facet")) fail(word, "\"facet\" or \"endsolid\"");
        facet();
      }
      skip_line();
    }
    return std::move(soup_);
  }

 private:
  void facet() {
    expect("normal");
    for (int k = 0; k < 3; ++k) next();  // the corners tell the normal better
    expect("outer");
    expect("loop");
    const std::size_t first = soup_.points.size();
    for (int k = 0; k < 3; ++k) {
      expect("vertex");
      const double x = number(), y = number(), z = number();
      soup_.points.emplace_back(x, y, z);
    }
    const std::string_view word = next();
    if (same_word(word, "vertex")) fail(word, "\"endloop\", for only triangles are allowed");
    if (!same_word(word, "endloop")) fail(word, "\"endloop\"");
    expect("endfacet");
    soup_.triangles.push_back({first, first + 1, first + 2});
  }

  static bool blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }

  void skip_blank() {
    for (; at_ < text_.size() && blank(text_[at_]); ++at_) line_ += text_[at_] == '\n';
  }

  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }

  std::string_view next() {
    skip_blank();
    const std::size_t first = at_;
    while (at_ < text_.size() && !blank(text_[at_])) ++at_;
    return text_.substr(first, at_ - first);
  }

  void expect(std::string_view wanted) {
    const std::string_view word = next();
    if (!same_word(word, wanted)) fail(word, fmt::format("\"{}\"", wanted));
  }

  double number() {
    const std::string_view word = next();
    const std::string_view digits = !word.empty() && word.front() == '+' ? word.substr(1) : word;
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || error == std::errc::invalid_argument || end != digits.data() + digits.size()) fail(word, "a number");
    // Out of range: too small is as good as zero, too large is not a coordinate.
    if (error == std::errc::result_out_of_range) value = std::strtod(std::string(digits).c_str(), nullptr);
    if (!std::isfinite(value)) fail(word, "a finite coordinate");
    return value;
  }

  [[noreturn]] void fail(std::string_view word, const std::string& wanted) const {
    const std::string found = word.empty() ? "the file ends here" : fmt::format("found \"{}\"", shown(word));
    throw InputError(fmt::format("{}, line {}: {}; an STL file must have {} here.", name_, line_, found, wanted));
  }

  const std::string& name_;
  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
  Soup soup_;
};

constexpr std::size_t header_bytes = 84, triangle_bytes = 50;

std::size_t announced_triangles(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  return count;
}

Soup read_binary(const std::string& name, std::string_view bytes) {
  if (bytes.size() < header_bytes)
    throw InputError(fmt::format(
        "{}: this is not an STL file: neither text that begins with \"solid\" nor the 84 bytes at least of a binary one ({} found).", name,
        bytes.size()));
  const std::size_t count = announced_triangles(bytes), needed = header_bytes + triangle_bytes * count;
  if (bytes.size() != needed)
    throw InputError(fmt::format(
        "{}: not text that begins with \"solid\", and as a binary STL file it announces {} triangles, which take {} bytes, but has {}; "
        "it is {}.",
        name, count, needed, bytes.size(), bytes.size() < needed ? "cut off or not an STL file" : "not an STL file"));
  Soup soup;
  soup.points.reserve(3 * count);
  soup.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    float corner[9];
    std::memcpy(corner, bytes.data() + header_bytes + triangle_bytes * t + 12, sizeof corner);
    for (std::size_t k = 0; k < 9; k += 3) {
      for (std::size_t axis = k; axis < k + 3; ++axis)
        if (!std::isfinite(corner[axis]))
          throw InputError(
              fmt::format("{}: triangle {} of {} has the coordinate {}; coordinates must be finite.", name, t + 1, count, corner[axis]));
      soup.points.emplace_back(corner[k], corner[k + 1], corner[k + 2]);
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return soup;
}

// Binary files may begin with "solid" too: the length tells, for a text's bytes 80 to 83 would announce 27 gigabytes.
Soup read_soup(const std::string& name, std::string_view bytes) {
  const bool fits_binary = bytes.size() >= header_bytes && bytes.size() == header_bytes + triangle_bytes * announced_triangles(bytes);
  const std::size_t first = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  const bool begins_solid = same_word(bytes.substr(first, 5), "solid");
  const bool has_zeros = bytes.substr(0, 1024).find('\0') != std::string_view::npos;
  if (!fits_binary && begins_solid && !has_zeros) return TextReader(name, bytes).read();
  return read_binary(name, bytes);
}

template <class Condition>
std::size_t remove_triangles(std::vector<Triangle>& triangles, Condition condition) {
  return std::erase_if(triangles, condition);
}

struct EdgeCount {
  std::size_t open = 0;      // with one triangle
  std::size_t disputed = 0;  // with two that do not agree on their side
};

EdgeCount count_edges(const std::vector<Triangle>& triangles) {
  struct Edge {
    std::size_t low, high;
    bool rising;
    auto operator<=>(const Edge&) const = default;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t from = t[k], to = t[(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  std::sort(edges.begin(), edges.end());
  EdgeCount count;
  for (std::size_t k = 0, next = 0; k < edges.size(); k = next) {
    while (next < edges.size() && edges[next].low == edges[k].low && edges[next].high == edges[k].high) ++next;
    count.open += next - k == 1;
    count.disputed += next - k == 2 && edges[k].rising == edges[k + 1].rising;
  }
  return count;
}

// Turns triangles over until neighbours agree, then the whole the way most of it was.
void orient(Soup& soup, StlReport& report) {
  std::vector<std::array<Point, 3>> before;
  for (const Triangle& t : soup.triangles) before.push_back({soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]});
  processing::orient_polygon_soup(soup.points, soup.triangles);
  // Where sheets branch CGAL doubles vertices; they belong together.
  processing::merge_duplicate_points_in_polygon_soup(soup.points, soup.triangles);
  report.oriented = count_edges(soup.triangles).disputed == 0;
  const auto is_turned = [&](std::size_t k) {
    const Triangle& t = soup.triangles[k];
    for (std::size_t first = 0; first < 3; ++first)
      if (before[k][first] == soup.points[t[0]]) return before[k][(first + 1) % 3] != soup.points[t[1]];
    return false;
  };
  for (std::size_t k = 0; k < soup.triangles.size(); ++k) report.turned += is_turned(k);
  if (2 * report.turned <= soup.triangles.size()) return;
  for (Triangle& t : soup.triangles) std::swap(t[1], t[2]);
  report.turned = soup.triangles.size() - report.turned;
}

std::size_t count_crossings(const Soup& soup) {
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::size_t>;
  const auto corner = [&](std::size_t t, std::size_t k) -> const Point& { return soup.points[soup.triangles[t][k]]; };
  std::vector<Box> boxes;
  boxes.reserve(soup.triangles.size());
  for (std::size_t t = 0; t < soup.triangles.size(); ++t)
    boxes.emplace_back(corner(t, 0).bbox() + corner(t, 1).bbox() + corner(t, 2).bbox(), t);
  std::size_t count = 0;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    const Triangle &s = soup.triangles[a.info()], &t = soup.triangles[b.info()];
    if (std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end()) return;
    count += CGAL::do_intersect(Kernel::Triangle_3(corner(a.info(), 0), corner(a.info(), 1), corner(a.info(), 2)),
                                Kernel::Triangle_3(corner(b.info(), 0), corner(b.info(), 1), corner(b.info(), 2)));
  });
  return count;
}

}  // namespace

std::string describe(const StlReport& r) {
  std::string text = fmt::format("{} triangles, {}", r.triangles, r.closed ? "closed" : fmt::format("open at {} edges", r.open_edges));
  if (!r.oriented) text += ", sides cannot be told apart everywhere";
  if (r.degenerate > 0) text += fmt::format("; {} without area removed", r.degenerate);
  if (r.duplicate > 0) text += fmt::format("; {} given twice removed", r.duplicate);
  if (r.turned > 0) text += fmt::format("; {} turned over", r.turned);
  if (r.crossings > 0) text += fmt::format("; {} pairs cross each other", r.crossings);
  return text;
}

Mesh read_stl(const std::filesystem::path& path, double scale, StlReport& report) {
  const std::string name = path.string();
  if (!(std::isfinite(scale) && scale > 0)) throw InputError(fmt::format("{}: the scale is {}; it must be positive.", name, scale));
  Soup soup = read_soup(name, read_whole(name));
  report = {};
  report.triangles = soup.triangles.size();
  if (soup.triangles.empty()) throw InputError(fmt::format("{}: the file holds no triangles; at least one is needed.", name));

  report.merged_vertices = processing::merge_duplicate_points_in_polygon_soup(soup.points, soup.triangles);
  report.degenerate = remove_triangles(soup.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  report.duplicate = processing::merge_duplicate_polygons_in_polygon_soup(soup.points, soup.triangles);
  // Triangles on one line still join their neighbours: they count for closedness and orientation, and go only then.
  report.open_edges = count_edges(soup.triangles).open;
  report.closed = report.open_edges == 0 && !soup.triangles.empty();
  orient(soup, report);
  report.degenerate += remove_triangles(
      soup.triangles, [&](const Triangle& t) { return CGAL::collinear(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]); });
  if (soup.triangles.empty())
    throw InputError(fmt::format("{}: none of the {} triangles has an area; at least one must.", name, report.triangles));
  report.crossings = count_crossings(soup);

  std::vector<Vec3> vertices;
  for (const Point& p : soup.points) vertices.emplace_back(scale * p.x(), scale * p.y(), scale * p.z());
  std::vector<std::array<Index, 3>> triangles;
  for (const Triangle& t : soup.triangles)
    triangles.push_back({static_cast<Index>(t[0]), static_cast<Index>(t[1]), static_cast<Index>(t[2])});
  return make_mesh(std::move(vertices), std::move(triangles));
}

void write_stl(const std::filesystem::path& path, const Mesh& mesh, StlFormat format) {
  std::string bytes;
  if (format == StlFormat::text) {
    bytes = "solid quern\n";
    for (const Facet& f : mesh.facets) {
      bytes += fmt::format("facet normal {} {} {}\n outer loop\n", f.normal.x(), f.normal.y(), f.normal.z());
      for (const Vec3& c : f.corner) bytes += fmt::format("  vertex {} {} {}\n", c.x(), c.y(), c.z());
      bytes += " endloop\nendfacet\n";
    }
    bytes += "endsolid quern\n";
  } else {
    bytes.assign(80, ' ');
    const auto append = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    append(static_cast<std::uint32_t>(mesh.facets.size()));
    for (const Facet& f : mesh.facets) {
      for (const Vec3& v : {f.normal, f.corner[0], f.corner[1], f.corner[2]})
        for (int axis = 0; axis < 3; ++axis) append(static_cast<float>(v[axis]));
      append(std::uint16_t{0});
    }
  }
  std::ofstream out(path, std::ios::binary);
  out << bytes;
  out.close();
  if (!out) throw RunError(fmt::format("{}: the file cannot be written.", path.string()));
}

}  // namespace quern
