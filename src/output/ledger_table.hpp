// The energy ledger against time, as a table.
#pragma once
#include "src/engine/ledger.hpp"
#include "src/observe/table.hpp"

namespace quern {

// Table `energy` without rows: time [s] and every entry of the ledger [J].
Table empty_ledger_table();

// Whether a table has the columns of another, each of one length.
bool same_columns(const Table& table, const Table& other);

// Adds a row. `time` [s].
void append_row(Table& table, double time, const Ledger& ledger);

}  // namespace quern
