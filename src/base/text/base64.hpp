#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace conddp {

/// Bytes as base64 text, padded with '=' (RFC 4648, section 4).
std::string base64(std::string_view bytes);

/// The bytes of such a text; nothing if it is no such text. Its padding may be missing.
std::optional<std::string> bytes_of_base64(std::string_view text);

}  // namespace conddp
