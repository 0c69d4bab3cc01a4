#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/error.h"

namespace phiz::readers {

/// Throw FormatError with "(line N)" or "(byte N)" behind the fault.
[[noreturn]] void fail_at_line(const std::string& fault, std::uint64_t line, const std::string& hint = {});
[[noreturn]] void fail_at_byte(const std::string& fault, std::uint64_t byte, const std::string& hint = {});

/// A piece of a file as it may stand in a message: quoted, short, printable.
std::string quoted(std::string_view text);

inline constexpr const char* kHintCut = "the file looks cut: copy or export it again";
inline constexpr const char* kHintDamaged = "the file looks damaged: copy or export it again";

}  // namespace phiz::readers
