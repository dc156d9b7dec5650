// libFuzzer entry to the target that CONDDP_FUZZ_TARGET names.
#include <cstdint>
#include <cstdlib>
#include <iostream>

#include "fuzz/targets.hpp"

namespace {

const conddp::FuzzTarget* g_target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("CONDDP_FUZZ_TARGET");
  for (const conddp::FuzzTarget& target : conddp::fuzz_targets())
    if (name != nullptr && target.name == name) g_target = &target;
  if (g_target != nullptr) return 0;
  std::cerr << "CONDDP_FUZZ_TARGET names none of the targets:";
  for (const conddp::FuzzTarget& target : conddp::fuzz_targets()) std::cerr << ' ' << target.name;
  std::cerr << '\n';
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  g_target->run({reinterpret_cast<const char*>(data), size});
  return 0;
}
