#include "src/output/ledger_table.hpp"
#include <algorithm>

namespace quern {
namespace {

struct Entry {
  const char *name, *description;
  double (*of)(const Ledger&);
};

constexpr Entry entries[] = {
    {"kinetic", "kinetic energy of the particles, translation and rotation", [](const Ledger& l) { return l.kinetic; }},
    {"potential", "potential energy of gravity", [](const Ledger& l) { return l.potential; }},
    {"elastic", "stored in the springs of the contacts", [](const Ledger& l) { return l.elastic; }},
    {"bond_energy", "stored in bonds", [](const Ledger& l) { return l.bond_energy; }},
    {"wall_work", "done by moving walls on the particles since the start", [](const Ledger& l) { return l.wall_work; }},
    {"field_work", "done by fields other than gravity since the start", [](const Ledger& l) { return l.field_work; }},
    {"normal_loss", "dissipated by contact damping along the normal since the start", [](const Ledger& l) { return l.normal_loss; }},
    {"sliding_loss", "dissipated by friction and tangential damping since the start", [](const Ledger& l) { return l.sliding_loss; }},
    {"rolling_loss", "dissipated by rolling resistance since the start", [](const Ledger& l) { return l.rolling_loss; }},
    {"bond_loss", "dissipated by the damping of bonds since the start", [](const Ledger& l) { return l.bond_loss; }},
    {"bond_failure", "released by bonds that failed since the start", [](const Ledger& l) { return l.bond_failure; }},
    {"gap", "work done − stored − dissipated: what the bookkeeping misses", [](const Ledger& l) { return l.gap(); }},
};

}  // namespace

Table empty_ledger_table() {
  Table table{"energy", "the energy ledger against time", {{"time", "s", "simulated time", {}, {}}}};
  for (const Entry& entry : entries) table.columns.push_back({entry.name, "J", entry.description, {}, {}});
  return table;
}

bool same_columns(const Table& table, const Table& other) {
  return std::equal(table.columns.begin(), table.columns.end(), other.columns.begin(), other.columns.end(), [&](const Column& a, const Column& b) {
    return a.name == b.name && a.labels.empty() && a.values.size() == table.columns.front().values.size();
  });
}

void append_row(Table& table, double time, const Ledger& ledger) {
  auto column = table.columns.begin();
  (column++)->values.push_back(time);
  for (const Entry& entry : entries) (column++)->values.push_back(entry.of(ledger));
}

}  // namespace quern
