#pragma once

#include <cstdint>
#include <string_view>

namespace conddp {

/// A sum that tells bytes that are torn or overwritten from whole ones, many times faster than a
/// hash. It protects from accidents alone, and depends on the byte order of the machine.
std::uint64_t check_sum(std::string_view bytes);

}  // namespace conddp
