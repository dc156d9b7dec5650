#pragma once

#include <string_view>

namespace conddp {

/// Writes a whole text to a descriptor that blocks, also where signals interrupt it. False where it
/// cannot be written, with the reason in errno; a part of it may have been.
bool write_all(int descriptor, std::string_view text);

}  // namespace conddp
