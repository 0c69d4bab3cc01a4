#pragma once

#include <iosfwd>
#include <string>
#include <string_view>

namespace phiz {

/// Appends `value` with `decimals` digits after the point, never "-0", independent of the locale.
/// `trim` drops trailing zeros and a bare point. The value must be finite.
void append_fixed(std::string& text, double value, int decimals, bool trim);

/// A whole decimal number, nothing before or after it; false where `token` is none or out of range.
bool parse_number(std::string_view token, double& value);
bool parse_number(std::string_view token, int& value);

/// All that is left in a stream. Throws FormatError where it cannot be read.
std::string read_all(std::istream& in);

/// Throws FormatError where the stream does not take all of it.
void write_all(std::ostream& out, std::string_view bytes);

}  // namespace phiz
