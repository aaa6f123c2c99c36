// Pages that are whole in themselves: their look, charts and tables in them, and numbers as people read them. All HTML.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include "src/observe/table.hpp"
#include "src/output/chart.hpp"

namespace quern {

// A page of some HTML. `charge`: with the script for the charge in 3-D.
std::string whole_page(const std::string& title, const std::string& body, bool charge);
// One with a look (CSS) of its own.
std::string page_of(const std::string& title, const std::string& look, const std::string& body, bool charge);

// A chart that stands still, and its numbers, from which the page's script makes one that zooms. `title`: above it; empty: none.
std::string figure_of(const Chart& chart, const std::string& title);
std::string captioned_figure_of(const Chart& chart, const std::string& caption);  // HTML

// JSON (or packed numbers) that the page's script finds by a class.
std::string data_of(const char* kind, const std::string& text);

// "3.71 ± 0.18" with as many digits as the interval deserves; "" for what is not known.
std::string spoken_value(const Headline& headline);
// The same with its unit, in parts or multiples of a thousand where that reads better: "0.46 ± 0.04 mJ".
std::string spoken_with_unit(const Headline& headline);
std::string spoken_interval(const Headline& headline);
std::string unit_symbol(const std::string& unit);
std::string spoken_name(std::string key);

}  // namespace quern
