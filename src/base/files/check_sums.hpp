#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace conddp {

/// The SHA-256 of some bytes as 64 hexadecimal digits.
std::string sha256(std::string_view bytes);

/// A checksum that detects torn or overwritten bytes, many times faster than a hash. It protects
/// only against accidents, and depends on the machine's byte order.
std::uint64_t check_sum(std::string_view bytes);

/// A single-line JSON object with its checksum as first member, `{"sum":"01234567",...}`.
std::string with_sum(std::string_view line);

/// True if a line begins with a checksum.
bool has_sum(std::string_view line);

/// The line without its checksum; empty if the checksum is missing or wrong.
std::string without_sum(std::string_view line);

}  // namespace conddp
