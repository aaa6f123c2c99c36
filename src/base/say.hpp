// Words for the person at the keyboard. They never fail: a terminal that was closed must not end a run.
#pragma once
#include <cstdio>
#include <string_view>

namespace quern {

// As it stands, on stderr unless told otherwise.
inline void say(std::string_view words, std::FILE* where = stderr) noexcept { std::fwrite(words.data(), 1, words.size(), where); }

}  // namespace quern
