// Quantities with units, on UDUNITS-2.
#pragma once
#include <memory>
#include <string>
#include <string_view>

namespace quern {

// Knows the units. Each thread reads their database once, which takes some milliseconds; UDUNITS is not safe among threads.
class Units {
 public:
  // Throws RunError where UDUNITS' database cannot be read.
  Units();

  // The value in `si_unit` of a text such as "54.5 cm", "250 rpm", "0.5 %"; a number without a unit is in `si_unit` already.
  // `si_unit` is written as UDUNITS reads it ("m", "rad/s", "kg/m3"; "1" for a pure number, where "%" is allowed).
  // Throws InputError with what was found and what is allowed: the caller says where.
  double read(std::string_view quantity, std::string_view si_unit) const;

 private:
  struct Database;
  std::shared_ptr<const Database> database_;
};

// A quantity in words that everyone knows, to show what is allowed: "54.5 cm" for "m".
std::string example_of(std::string_view si_unit);

}  // namespace quern
