#include "base/files/sha256.hpp"

#include <sha2.h>

namespace conddp {

std::string sha256(std::string_view bytes) {
  char text[SHA256_DIGEST_STRING_LENGTH];
  SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), text);
  return text;
}

}  // namespace conddp
