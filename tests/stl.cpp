#include "src/wall/stl.hpp"

#include <catch2/catch.hpp>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "src/base/error.hpp"
#include "src/wall/mesh_shapes.hpp"
#include "tests/random_plane.hpp"

using namespace quern;

namespace {

// A file that goes when the test ends.
struct Scratch {
  std::filesystem::path path;
  explicit Scratch(const std::string& bytes = "") {
    static int count = 0;
    path =
        std::filesystem::temp_directory_path() / ("quern_stl_test_" + std::to_string(::getpid()) + "_" + std::to_string(count++) + ".stl");
    std::ofstream(path, std::ios::binary) << bytes;
  }
  ~Scratch() { std::filesystem::remove(path); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
};

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string facet(const std::string& a, const std::string& b, const std::string& c) {
  return "facet normal 0 0 1\n outer loop\n vertex " + a + "\n vertex " + b + "\n vertex " + c + "\n endloop\nendfacet\n";
}

// What reading says about bad bytes; it must name the file.
std::string complaint(const std::string& bytes) {
  const Scratch file(bytes);
  StlReport report;
  try {
    read_stl(file.path, 1, report);
  } catch (const InputError& error) {
    const std::string text = error.what();
    CHECK(text.find(file.path.string()) == 0);
    CHECK(text.size() < 500);
    return text;
  }
  FAIL("no error for bad input");
  return "";
}

std::string binary_box() {
  const Scratch file;
  write_stl(file.path, box_mesh({0, 0, 0}, {1, 2, 3}, FreeSide::outside), StlFormat::binary);
  return bytes_of(file.path);
}

using Catch::Matchers::Contains;

}  // namespace

TEST_CASE("a closed mesh survives writing and reading, as text to the last digit and in binary to floats") {
  const Mesh box = box_mesh({-0.1, 0.2, 1.0 / 3}, {0.7, 1, 2}, FreeSide::outside);
  for (const StlFormat format : {StlFormat::text, StlFormat::binary}) {
    const Scratch file;
    write_stl(file.path, box, format);
    StlReport report;
    const Mesh back = read_stl(file.path, 1, report);
    CHECK(report.triangles == 12);
    CHECK(report.merged_vertices == 28);
    CHECK(report.degenerate == 0);
    CHECK(report.duplicate == 0);
    CHECK(report.turned == 0);
    CHECK(report.closed);
    CHECK(report.oriented);
    CHECK(report.open_edges == 0);
    CHECK(report.crossings == 0);
    REQUIRE(back.triangles.size() == 12);
    CHECK(back.vertices.size() == 8);
    for (std::size_t t = 0; t < 12; ++t)
      for (int k = 0; k < 3; ++k)
        CHECK((back.facets[t].corner[k] - box.facets[t].corner[k]).norm() <= (format == StlFormat::text ? 0 : 2e-7));
  }
}

TEST_CASE("the scale takes the file's unit to metres") {
  const Scratch file(binary_box());
  StlReport report;
  CHECK(read_stl(file.path, 1e-3, report).reach() == Approx(std::sqrt(14.0) * 1e-3).epsilon(1e-12));
  CHECK_THROWS_AS(read_stl(file.path, 0, report), InputError);
  CHECK_THROWS_AS(read_stl(file.path, -1, report), InputError);
  CHECK_THROWS_AS(read_stl(file.path, std::nan(""), report), InputError);
}

TEST_CASE("a binary file whose header begins with the word solid is read as binary") {
  std::string bytes = binary_box();
  bytes.replace(0, 20, "solid box made by me");
  const Scratch file(bytes);
  StlReport report;
  CHECK(read_stl(file.path, 1, report).triangles.size() == 12);
  // The same, cut off: the zeros behind the header tell that it is no text.
  CHECK_THAT(complaint(bytes.substr(0, bytes.size() - 7)), Contains("announces 12 triangles"));
}

TEST_CASE("text is read with any case, spacing and line ends, several solids and numbers with a plus") {
  const std::string text = "\r\n  SOLID two words\r\n" + facet("0 0 0", "+1 0 0", "0 1e0 0") + "endsolid two words\r\nsolid\n" +
                           "Facet Normal nan nan nan Outer Loop Vertex 1 0 0\tVertex 1 1 0 vertex 0 1 0 EndLoop EndFacet EndSolid\n\n";
  const Scratch file(text);
  StlReport report;
  CHECK(read_stl(file.path, 1, report).triangles.size() == 2);
  CHECK(report.open_edges == 4);
  CHECK_FALSE(report.closed);
  CHECK(report.merged_vertices == 2);
  CHECK_THAT(describe(report), Contains("open at 4 edges"));
}

TEST_CASE("degenerate, duplicate and wrongly turned triangles are counted and repaired") {
  // A box with one triangle turned over, one twice (once the other way round), one on a point and one on a line.
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1}, FreeSide::outside);
  std::vector<std::array<Index, 3>> triangles = box.triangles;
  std::swap(triangles[5][0], triangles[5][1]);
  triangles.push_back({triangles[0][1], triangles[0][0], triangles[0][2]});
  triangles.push_back({0, 0, 1});
  std::vector<Vec3> vertices = box.vertices;
  vertices.emplace_back(0.5, 0, 0);
  triangles.push_back({0, 8, 1});
  const Scratch file;
  write_stl(file.path, make_mesh(vertices, triangles), StlFormat::text);
  StlReport report;
  const Mesh back = read_stl(file.path, 1, report);
  CHECK(report.triangles == 15);
  CHECK(report.duplicate == 1);
  CHECK(report.degenerate == 2);
  CHECK(report.turned == 1);
  CHECK(report.oriented);
  REQUIRE(back.triangles.size() == 12);
  for (const Facet& f : back.facets) CHECK((f.corner[0] - Vec3(0.5, 0.5, 0.5)).dot(f.normal) > 0);
}

TEST_CASE("an open tube, a strip with one side only and parts that cross are reported") {
  StlReport report;
  const auto read = [&](const Mesh& mesh) {
    const Scratch file;
    write_stl(file.path, mesh, StlFormat::text);
    read_stl(file.path, 1, report);
  };
  read(cylinder_jacket(1, 0, 1, 24, FreeSide::inside));
  CHECK(report.open_edges == 48);
  CHECK(report.oriented);
  CHECK(report.turned == 0);

  const int pieces = 9;  // a Möbius strip
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> triangles;
  for (Index k = 0; k < pieces; ++k) {
    const double angle = 2 * M_PI * k / pieces;
    const Vec3 out(std::cos(angle), std::sin(angle), 0), across = 0.2 * (std::cos(angle / 2) * out + std::sin(angle / 2) * Vec3::UnitZ());
    vertices.push_back(out - across);
    vertices.push_back(out + across);
    const bool last = k == pieces - 1;
    const Index a = 2 * k, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    triangles.push_back({a, b, c});
    triangles.push_back({b, d, c});
  }
  read(make_mesh(vertices, triangles));
  CHECK_FALSE(report.oriented);
  CHECK(report.triangles == 18);

  read(joined(box_mesh({0, 0, 0}, {1, 1, 1}, FreeSide::outside), box_mesh({0.5, 0.4, 0.3}, {2, 2, 2}, FreeSide::outside)));
  CHECK(report.closed);
  CHECK(report.self_intersecting());
  read(joined(box_mesh({0, 0, 0}, {1, 1, 1}, FreeSide::outside), box_mesh({1.5, 0, 0}, {2, 2, 2}, FreeSide::outside)));
  CHECK_FALSE(report.self_intersecting());
}

TEST_CASE("ten thousand triangles come back as they were") {
  const Mesh plane = random_plane(1, 10000, 2);
  const Scratch file;
  write_stl(file.path, plane, StlFormat::text);
  StlReport report;
  const Mesh back = read_stl(file.path, 1, report);
  CHECK(back.triangles.size() == 10000);
  CHECK(back.vertices.size() == plane.vertices.size());
  CHECK(report.open_edges == 200);
  CHECK(report.oriented);
  CHECK(report.crossings == 0);
}

TEST_CASE("bad files are refused in one sentence that names the file and what is wrong") {
  StlReport report;
  CHECK_THROWS_WITH(read_stl("/nowhere/lifter.stl", 1, report), Contains("/nowhere/lifter.stl") && Contains("no such file"));
  CHECK_THROWS_WITH(read_stl(std::filesystem::temp_directory_path(), 1, report), Contains("not a file"));
  CHECK_THAT(complaint(""), Contains("empty"));
  CHECK_THAT(complaint("hello\n"), Contains("not an STL file"));
  CHECK_THAT(complaint("solid nothing\nendsolid nothing\n"), Contains("no triangles"));

  const std::string binary = binary_box();
  CHECK_THAT(complaint(binary.substr(0, 60)), Contains("not an STL file"));
  CHECK_THAT(complaint(binary.substr(0, binary.size() - 1)), Contains("announces 12 triangles") && Contains("cut off"));
  CHECK_THAT(complaint(binary + "x"), Contains("684"));
  CHECK_THAT(complaint(std::string(84, '\0')), Contains("no triangles"));
  std::string poisoned = binary;
  const float nan = std::nanf("");
  std::memcpy(&poisoned[84 + 50 * 3 + 12 + 8], &nan, 4);
  CHECK_THAT(complaint(poisoned), Contains("triangle 4 of 12") && Contains("nan"));

  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "nan 0 0", "0 1 0") + "endsolid a\n"),
             Contains("line 5") && Contains("nan") && Contains("finite"));
  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "1e400 0 0", "0 1 0") + "endsolid a\n"), Contains("line 5") && Contains("1e400"));
  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "1 0", "0 1 0") + "endsolid a\n"),
             Contains("line 6") && Contains("vertex") && Contains("a number"));
  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "1 0 x", "0 1 0") + "endsolid a\n"), Contains("line 5") && Contains("\"x\""));
  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "1 0 0", "0 1 0\n vertex 1 1 0") + "endsolid a\n"), Contains("only triangles"));
  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "1 0 0", "0 1 0")), Contains("the file ends here") && Contains("endsolid"));
  CHECK_THAT(complaint("solid a\nfacet normal 0 0 1\n outer loop\n vertex 0 0"), Contains("the file ends here"));
  CHECK_THAT(complaint("solid a\n" + facet("0 0 0", "1 1 1", "2 2 2") + "endsolid a\n"), Contains("has an area"));
  CHECK_THAT(complaint("solid a\nfacets\n"), Contains("line 2") && Contains("facets"));
}

TEST_CASE("noise of any length is refused") {
  RandomStream random(77);
  for (const std::size_t size : {1u, 10u, 83u, 84u, 85u, 1000u, 1000000u}) {
    std::string noise(size, ' ');
    for (char& c : noise) c = static_cast<char>(random.next());
    complaint(noise);
    complaint("solid" + noise);
  }
}
