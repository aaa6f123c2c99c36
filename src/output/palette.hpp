// The colours of curves. Okabe & Ito 2008: told apart by every eye.
#pragma once
#include <array>

namespace quern {

using Colour = std::array<double, 3>;
inline constexpr std::array<Colour, 7> palette{{{0.00, 0.45, 0.70}, {0.84, 0.37, 0.00}, {0.00, 0.62, 0.45}, {0.80, 0.47, 0.65},
                                                {0.34, 0.34, 0.36}, {0.90, 0.62, 0.00}, {0.34, 0.71, 0.91}}};

}  // namespace quern
