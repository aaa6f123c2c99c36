// What two measured means say about the difference of the things measured.
#pragma once
#include <array>
#include <optional>

namespace quern {

struct Estimate {
  double value = 0;
  std::optional<std::array<double, 2>> ci95;  // holds `value`; it need not be symmetric
};

// second − first. The interval, where both have one, takes each limit's distance from its mean for the error on that side and adds the
// two in squares (MOVER: Zou & Donner 2008, Statist. Med. 27:1693); with normal means this is exact. The two must be independent.
Estimate difference(const Estimate& first, const Estimate& second);

enum class Verdict {
  moves,         // zero lies outside the interval of the difference
  moves_little,  // so it does, and yet the whole interval lies within ± tolerance
  same,          // zero lies inside it, and the whole interval within ± tolerance (equivalence: Schuirmann 1987, with 95 % for 90 %)
  unknown,       // neither: the interval is too wide
};

// `rows`: so many differences are judged together; zero must lie outside an interval widened for all of them (Bonferroni, as if the errors were
// normal), so that with 95 % confidence nothing is said to move that does not. Without an interval the difference is taken to be exact.
Verdict judge(const Estimate& difference, double tolerance, int rows = 1);

// How many times as long the averages must be for two things that are truly the same to be found so within ± tolerance in 90 of 100 cases:
// the error falls with the root of the time.
double longer_by(const Estimate& difference, double tolerance);

}  // namespace quern
