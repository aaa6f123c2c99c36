// What the pages do in a browser, as the build made it from report/.
#pragma once
#include <string_view>

namespace quern {

// Plots that zoom and tables that sort; the charge in 3-D. Empty where the program was built without them (QUERN_REPORT=OFF).
std::string_view plots_script();
std::string_view charge_script();

}  // namespace quern
