#include <fmt/format.h>
#include <algorithm>
#include "src/base/error.hpp"
#include "src/case/csv.hpp"
#include "src/convert/converted.hpp"

namespace quern {
namespace {

std::string name_in(const TextTable& table, std::size_t row, int column) {
  std::string name = table.rows[row][static_cast<std::size_t>(column)];
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  if (name.empty() || name.size() > 100) table.refuse(row, column, "allowed is a name of 1 to 100 letters");
  return name;
}

// A number in SI; a column without a unit is in SI.
double si_number(const TextTable& table, std::size_t row, int column, const char* unit) {
  return number_in(table, row, column) * (table.units[static_cast<std::size_t>(column)].empty() ? 1 : unit_of(table, column, {unit}).factor);
}

std::string materials(const TextTable& table) {
  const int name = table.find("material"), density = table.find("density"), shear = table.find("shear_modulus"), young = table.find("young"), poisson = table.find("poisson");
  if (density < 0 || poisson < 0 || (shear < 0) == (young < 0))
    throw InputError(fmt::format("{}:{}: needed are the columns material, density, poisson, and shear_modulus or young.", table.file, table.header_line));
  std::string text;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const double ratio = si_number(table, row, poisson, "1");
    const double modulus = shear >= 0 ? 2 * si_number(table, row, shear, "Pa") * (1 + ratio) : si_number(table, row, young, "Pa");
    text += fmt::format("\n[material.{}]\ndensity = {}\nyoung = {}{}\npoisson = {}\n", name_in(table, row, name), si_number(table, row, density, "kg/m3"), modulus,
                        shear >= 0 ? "  # 2 G (1 + poisson)" : "", ratio);
  }
  return text;
}

std::string pairs(const TextTable& table) {
  const int a = table.find("a"), b = table.find("b"), restitution = table.find("restitution"), friction = table.find("static_friction"), rolling = table.find("rolling_friction");
  if (b < 0 || restitution < 0 || friction < 0) throw InputError(fmt::format("{}:{}: needed are the columns a, b, restitution, static_friction, and possibly rolling_friction.", table.file, table.header_line));
  std::string text;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    text += fmt::format("\n[pair.{}.{}]\nlaw = \"hertz_mindlin\"\nrestitution = {}\nfriction = {}\n", name_in(table, row, a), name_in(table, row, b), number_in(table, row, restitution),
                        number_in(table, row, friction));
    if (rolling >= 0) text += fmt::format("rolling = \"constant_torque\"\nrolling_friction = {}\n", number_in(table, row, rolling));
  }
  return text;
}

}  // namespace

Converted convert_materials(const std::vector<std::string>& files) {
  Converted made;
  made.text = "# Converted by `quern convert`: materials and what they do to each other, for a case.\n";
  for (const std::string& file : files) {
    const TextTable table = read_cells(file);
    if (table.find("material") >= 0) made.text += materials(table);
    else if (table.find("a") >= 0) made.text += pairs(table);
    else throw InputError(fmt::format("{}:{}: needed is a column material, or the columns a and b.", file, table.header_line));
  }
  return made;
}

}  // namespace quern
