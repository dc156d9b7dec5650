#pragma once

#include <string>
#include <string_view>

namespace conddp {

/// Bytes as text in base 64, padded with '=' (RFC 4648, section 4).
std::string base64(std::string_view bytes);

}  // namespace conddp
