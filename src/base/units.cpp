#include "src/base/units.hpp"
#include <fmt/format.h>
#include <udunits2.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include "src/base/error.hpp"

namespace quern {
namespace {

struct UnitDeleter {
  void operator()(ut_unit* unit) const { ut_free(unit); }
};
struct ConverterDeleter {
  void operator()(cv_converter* converter) const { cv_free(converter); }
};
using Unit = std::unique_ptr<ut_unit, UnitDeleter>;
using Converter = std::unique_ptr<cv_converter, ConverterDeleter>;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.remove_suffix(1);
  return text;
}

std::string shown(std::string_view text) {
  constexpr std::size_t most = 60;
  return fmt::format("\"{}{}\"", text.substr(0, most), text.size() > most ? "…" : "");
}

std::string allowed(std::string_view si_unit) {
  if (si_unit == "1") return "a pure number or a percentage, such as " + example_of(si_unit);
  return "a number in " + std::string(si_unit) + " or a text such as " + example_of(si_unit);
}

// UDUNITS takes the radian for a pure number, so that it would read 5 Hz as 5 rad/s and 3 rad as 3.
bool mistaken_angle(std::string_view unit, std::string_view si_unit) {
  if (si_unit == "rad/s") return unit.find("Hz") != unit.npos || unit.find("hertz") != unit.npos || unit.starts_with("1/") || unit == "s-1";
  if (si_unit == "1") return !(unit == "1" || unit == "%" || unit == "percent");
  return false;
}

}  // namespace

struct Units::Database {
  std::unique_ptr<ut_system, decltype(&ut_free_system)> system{nullptr, &ut_free_system};
  Database();
};

Units::Database::Database() {
  ut_set_error_message_handler(ut_ignore);
  system.reset(ut_read_xml(nullptr));
  if (!system) throw RunError("The unit database of UDUNITS-2 cannot be read; is the package libudunits2-0 (with its XML files) installed?");
  constexpr std::array<std::array<const char*, 2>, 4> everyday = {{{"deg", "degree"}, {"rev", "turn"}, {"revs", "turn"}, {"RPM", "rpm"}}};
  for (const auto& [name, meaning] : everyday) {
    const Unit unit(ut_parse(system.get(), meaning, UT_ASCII));
    ut_map_name_to_unit(name, UT_ASCII, unit.get());
  }
}

Units::Units() {
  thread_local const std::shared_ptr<const Database> known = std::make_shared<const Database>();
  database_ = known;
}

double Units::read(std::string_view quantity, std::string_view si_unit) const {
  const std::string_view text = trimmed(quantity);
  const std::string_view digits = !text.empty() && text.front() == '+' ? text.substr(1) : text;
  double number = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const auto refuse = [&](const std::string& why) { throw InputError("found " + shown(text) + why + "; allowed is " + allowed(si_unit)); };
  if (status != std::errc() || !std::isfinite(number)) refuse(", which is not a finite number with a unit");
  const std::string unit_text(trimmed({end, static_cast<std::size_t>(digits.data() + digits.size() - end)}));
  if (unit_text.empty()) return number;
  const auto head = static_cast<unsigned char>(unit_text.front());
  if (!std::isalpha(head) && head != '%' && head < 0x80 && !unit_text.starts_with("1/") && unit_text != "1")
    refuse(", which is not a finite number with a unit");

  constexpr std::size_t longest_unit = 100;
  if (unit_text.size() > longest_unit) refuse(", whose unit is not known");

  const Unit from(ut_parse(database_->system.get(), unit_text.c_str(), UT_UTF8));
  if (!from) refuse(", whose unit " + shown(unit_text) + " is not known");
  const Unit to(ut_parse(database_->system.get(), std::string(si_unit).c_str(), UT_UTF8));
  const Converter converter(to && !mistaken_angle(unit_text, si_unit) ? ut_get_converter(from.get(), to.get()) : nullptr);
  // Reciprocal and logarithmic conversions exist in UDUNITS; a factor is meant.
  const auto convert = [&](double x) { return converter ? cv_convert_double(converter.get(), x) : NAN; };
  const double zero = convert(0), one = convert(1), two = convert(2);
  if (!std::isfinite(zero) || !(std::abs(two - 2 * one + zero) <= 1e-12 * std::abs(one))) refuse(", whose unit is of another kind");
  const double value = convert(number);
  if (!std::isfinite(value)) refuse(", which is too large");
  return value;
}

std::string example_of(std::string_view si_unit) {
  constexpr std::array<std::array<const char*, 2>, 13> examples = {{{"m", "\"54.5 cm\""},
                                                                    {"kg", "\"140 kg\""},
                                                                    {"s", "\"20 ms\""},
                                                                    {"rad/s", "\"250 rpm\""},
                                                                    {"rad", "\"30 degree\""},
                                                                    {"Pa", "\"206 GPa\""},
                                                                    {"1", "0.5 or \"0.5 %\""},
                                                                    {"kg/m3", "\"7.8 g/cm3\""},
                                                                    {"m/s", "\"5 m/s\""},
                                                                    {"m/s2", "\"9.81 m/s2\""},
                                                                    {"N/m", "\"400 kN/m\""},
                                                                    {"Hz", "\"50 Hz\""},
                                                                    {"kg/s", "\"985 kg/s\""}}};
  const auto found = std::find_if(examples.begin(), examples.end(), [&](const auto& pair) { return si_unit == pair[0]; });
  return found == examples.end() ? fmt::format("\"1 {}\"", si_unit) : (*found)[1];
}

}  // namespace quern
