// The size that a fraction of a sample passes: D80, D50.
#pragma once
#include <vector>

namespace quern {

// sizes ascending, finer: the fraction that passes each, not falling. Between two sizes the fraction is taken to rise with the logarithm of
// the size. NaN where the fraction lies outside what was sieved.
double passing_size(const std::vector<double>& sizes, const std::vector<double>& finer, double fraction);

// The same from the amounts in classes around the sizes (ascending, more than 0), on any scale; classes meet halfway in the logarithm.
double passing_size_of_classes(const std::vector<double>& sizes, const std::vector<double>& amounts, double fraction);

}  // namespace quern
