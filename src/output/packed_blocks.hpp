// Arrays of numbers for a page: each told of in JSON, all of them in one packed text. report/src/frames.js reads them.
#pragma once
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace quern {

class PackedBlocks {
 public:
  template <class Number>
  nlohmann::ordered_json add(const std::vector<Number>& numbers) {
    const char* sort = std::is_floating_point_v<Number> ? "f" : std::is_signed_v<Number> ? "i" : "u";
    return keep(sort + std::to_string(sizeof(Number)), numbers.size(), reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
  }

  // Rows of `stride` numbers that change little from one to the next: written as differences, low bytes before high ones.
  nlohmann::ordered_json add_rows(const std::vector<std::uint16_t>& numbers, std::size_t stride);

  // Deflated (zlib), in base64.
  std::string text() const;

 private:
  nlohmann::ordered_json keep(const std::string& kind, std::size_t count, const char* data, std::size_t size);
  std::string bytes_;
};

}  // namespace quern
