// Looking up what observers gave, by name.
#pragma once
#include <catch2/catch.hpp>
#include <string>
#include <vector>
#include "src/observe/table.hpp"

namespace quern {

inline const Table& table_of(const std::vector<Table>& tables, const std::string& name) {
  for (const Table& t : tables)
    if (t.name == name) return t;
  FAIL("no table " << name);
  return tables.front();
}

inline const Column& column(const Table& table, const std::string& name) {
  for (const Column& c : table.columns)
    if (c.name == name) return c;
  FAIL("no column " << name);
  return table.columns.front();
}

inline double value(const std::vector<Headline>& lines, const std::string& key) {
  for (const Headline& line : lines)
    if (line.key == key) return line.value;
  FAIL("no headline " << key);
  return 0;
}

}  // namespace quern
