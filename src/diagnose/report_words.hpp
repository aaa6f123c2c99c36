// How the pages of a comparison say things: their style, and numbers and names as a person reads them, safe within HTML where told.
#pragma once
#include <string>
#include <string_view>
#include <vector>
#include "src/diagnose/finding.hpp"

namespace quern::page {

std::string e(std::string_view text);            // stands in HTML as it is
std::string code(std::string_view text);         // HTML; may be broken after a dot or a dash below
std::string paragraph(const std::string& html);
std::string words_of(std::string name);          // "air_drag" → "air drag"
std::string capital(std::string text);
std::string joined(const std::vector<std::string>& names, const char* between = ", ", const char* last = " and ");
std::string brief(double x, int digits = 4);     // powers of ten as people write them
std::string with_unit(const std::string& number, const std::string& unit);
std::string chance(double p);
std::string percent(double part);                // HTML
std::string ratio(double x);
bool of_instrument(const std::vector<std::string>& effects);

std::string sentence(const Finding& finding);    // the verdict, as it is said first
std::string look_for(Verdict verdict);           // CSS of the whole page, in the colour that goes with it

// A number and its interval with as many digits as the interval deserves.
struct Spoken {
  std::string value, interval;
};
Spoken spoken_of(const Estimate& estimate);

}  // namespace quern::page
