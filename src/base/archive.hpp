// Plain data to bytes and back, for checkpoints. A type takes part if its bytes are its value (numbers, enums, structs of them), if it is
// a string, vector, map, optional or array of such, or if it has `template <class A> void archive(A& a) { a(member, …); }`.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>
#include "src/base/error.hpp"

namespace quern {

// The bytes are not what was written: a clause that says why.
struct UnfitData : InputError {
  using InputError::InputError;
};

class ArchiveWriter {
 public:
  std::string bytes;

  // Writes what `write(writer)` writes, into memory of just the length it needs.
  template <class Write>
  static std::string written_by(Write&& write) {
    ArchiveWriter counter, writer;
    counter.counts_ = true;
    write(counter);
    writer.bytes.reserve(counter.length_);
    write(writer);
    return std::move(writer.bytes);
  }

  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }

 private:
  template <class T>
  void put(T& value) {
    if constexpr (requires { value.archive(*this); }) {
      value.archive(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>, "give the type an archive function");
      append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  void append(const char* from, std::size_t count) {
    if (counts_)
      length_ += count;
    else
      bytes.append(from, count);
  }
  void put_size(std::size_t size) {
    auto fixed = static_cast<std::uint64_t>(size);
    put(fixed);
  }
  void put(std::string& text) { put_size(text.size()), append(text.data(), text.size()); }
  void put(std::vector<bool>& flags) {
    put_size(flags.size());
    for (bool flag : flags) {
      const char byte = flag;
      append(&byte, 1);
    }
  }
  template <class T>
  void put(std::vector<T>& values) {
    put_size(values.size());
    if constexpr (std::is_trivially_copyable_v<T>) {
      if (!values.empty()) append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    } else {
      for (T& value : values) put(value);
    }
  }
  template <class K, class V>
  void put(std::map<K, V>& values) {
    put_size(values.size());
    for (auto& [key, value] : values) {
      K copy = key;
      put(copy);
      put(value);
    }
  }
  template <class T>
  void put(std::optional<T>& value) {
    put_size(value ? 1 : 0);
    if (value) put(*value);
  }

  bool counts_ = false;
  std::size_t length_ = 0;
};

class ArchiveReader {
 public:
  // The source must outlive the reader.
  explicit ArchiveReader(std::string_view source) : bytes_(source) {}

  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  const char* take(std::size_t count) {
    if (count > bytes_.size() - at_) throw UnfitData("the data end too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }
  std::size_t get_size() {
    std::uint64_t size = 0;
    get(size);
    if (size > bytes_.size()) throw UnfitData("the data name a length that they do not hold");
    return static_cast<std::size_t>(size);
  }
  template <class T>
  void get(T& value) {
    if constexpr (requires { value.archive(*this); }) {
      value.archive(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T>, "give the type an archive function");
      std::memcpy(&value, take(sizeof value), sizeof value);
    }
  }
  void get(std::string& text) {
    const std::size_t size = get_size();
    text.assign(take(size), size);
  }
  void get(std::vector<bool>& flags) {
    flags.resize(get_size());
    for (std::size_t k = 0; k < flags.size(); ++k) flags[k] = *take(1) != 0;
  }
  template <class T>
  void get(std::vector<T>& values) {
    const std::size_t size = get_size();
    if constexpr (std::is_trivially_copyable_v<T>) {
      const char* from = take(size * sizeof(T));
      values.resize(size);
      if (size > 0) std::memcpy(static_cast<void*>(values.data()), from, size * sizeof(T));
    } else {
      // One by one: the length may be a lie.
      values.clear();
      for (std::size_t k = 0; k < size; ++k) get(values.emplace_back());
    }
  }
  template <class K, class V>
  void get(std::map<K, V>& values) {
    values.clear();
    for (std::size_t k = get_size(); k > 0; --k) {
      K key{};
      get(key);
      get(values[key]);
    }
  }
  template <class T>
  void get(std::optional<T>& value) {
    if (get_size() == 0) {
      value.reset();
    } else {
      get(value.emplace());
    }
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace quern
