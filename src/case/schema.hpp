// The keys of a case as a JSON schema, for editors.
#pragma once
#include <string>

namespace quern {

// JSON schema (draft 2020-12) of a case file, made from the table of all keys: what editors complete, explain and underline.
std::string case_schema();

}  // namespace quern
