// Charts within a page: what a reader must see is there, and what a user wrote cannot break the page.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <regex>
#include "src/output/svg_chart.hpp"

using namespace quern;

namespace {

// Heights of the points of all drawn ways, downwards.
std::vector<double> heights(const std::string& svg) {
  std::vector<double> all;
  const std::regex point("[ML][-0-9.]+ ([-0-9.]+)(?=[ML]|$)"), way("<path d=\"([^\"]*)\"[^>]*fill=\"none\"");
  for (auto w = std::sregex_iterator(svg.begin(), svg.end(), way); w != std::sregex_iterator(); ++w) {
    const std::string drawn = (*w)[1];
    for (auto p = std::sregex_iterator(drawn.begin(), drawn.end(), point); p != std::sregex_iterator(); ++p) all.push_back(std::stod((*p)[1]));
  }
  return all;
}

}  // namespace

TEST_CASE("one sample of a hundred thousand that stands out is drawn", "[report]") {
  Curve curve{"signal", {}, {}, {}, {}, false};
  for (int k = 0; k < 100'000; ++k) curve.x.push_back(k), curve.y.push_back(k == 31'416 ? 1.0 : 0.001 * std::sin(k));
  const std::string svg = svg_of(Chart{"", "", {{"t [s]", "force [N]", false, false, {curve}}}});
  CHECK(svg.size() < 40'000);
  const std::vector<double> all = heights(svg);
  REQUIRE(all.size() > 100);
  // The frame of the first panel is 160 high, and 4 % of the range stay free above and below. All others lie within a few units of the bottom.
  const auto [highest, lowest] = std::minmax_element(all.begin(), all.end());
  CHECK(*lowest - *highest > 0.9 * 160);
  CHECK(std::count_if(all.begin(), all.end(), [&](double y) { return y < *lowest - 5; }) == 1);
}

TEST_CASE("names of the user's stand in a page as they were written", "[report]") {
  const std::string svg = svg_of(Chart{"", "a \"title\"", {{"t", "<script>", false, false, {{"a & b", {0, 1}, {0, 1}, {}, {}, false}, {"c", {0, 1}, {1, 0}, {}, {}, false}}}}});
  CHECK(svg.find("<script>") == svg.npos);
  CHECK(svg.find("&lt;script&gt;") != svg.npos);
  CHECK(svg.find("a &amp; b") != svg.npos);
  CHECK(svg.find("aria-label=\"a &quot;title&quot;\"") != svg.npos);
}

TEST_CASE("a chart of nothing, or of numbers that are none, is still a picture", "[report]") {
  const double none = std::nan("");
  for (const Curve& curve : {Curve{"empty", {}, {}, {}, {}, false}, Curve{"none", {0, 1}, {none, none}, {}, {}, true}, Curve{"one", {2}, {3}, {}, {}, true}}) {
    const std::string svg = svg_of(Chart{"", "", {{"x", "y", false, false, {curve}}, {"x", "y", false, true, {curve}}}});
    CHECK(svg.find("nan") == svg.npos);
    CHECK(svg.find("inf") == svg.npos);
  }
  const std::string rows = svg_of({{"run", none, 1.0, false}, {"other", 1.2, 1.0, true}}, "misfit", 1);
  CHECK(rows.find("nan") == rows.npos);
}
