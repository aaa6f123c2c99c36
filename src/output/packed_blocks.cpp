#include "src/output/packed_blocks.hpp"
#include <vtkBase64Utilities.h>
#include <vtkNew.h>
#include <vtkZLibDataCompressor.h>
#include "src/base/error.hpp"

namespace quern {

nlohmann::ordered_json PackedBlocks::keep(const std::string& kind, std::size_t count, const char* data, std::size_t size) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);  // where a browser may lay numbers of four bytes over them
  const std::size_t at = bytes_.size();
  bytes_.append(data, size);
  return {{"kind", kind}, {"at", at}, {"count", count}};
}

nlohmann::ordered_json PackedBlocks::add_rows(const std::vector<std::uint16_t>& numbers, std::size_t stride) {
  std::string apart(2 * numbers.size(), '\0');
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto change = static_cast<std::uint16_t>(numbers[k] - (k < stride ? 0 : numbers[k - stride]));
    apart[k] = static_cast<char>(change & 0xff);
    apart[k + numbers.size()] = static_cast<char>(change >> 8);
  }
  nlohmann::ordered_json told = keep("delta", numbers.size(), apart.data(), apart.size());
  told["stride"] = stride;
  return told;
}

std::string PackedBlocks::text() const {
  vtkNew<vtkZLibDataCompressor> zlib;
  zlib->SetCompressionLevel(6);
  std::vector<unsigned char> packed(zlib->GetMaximumCompressionSpace(bytes_.size()));
  const std::size_t size = zlib->Compress(reinterpret_cast<const unsigned char*>(bytes_.data()), bytes_.size(), packed.data(), packed.size());
  if (size == 0) throw RunError("The frames could not be packed for the report.");
  std::string text(size / 3 * 4 + 8, '\0');
  text.resize(vtkBase64Utilities::Encode(packed.data(), static_cast<unsigned long>(size), reinterpret_cast<unsigned char*>(text.data())));
  return text;
}

}  // namespace quern
