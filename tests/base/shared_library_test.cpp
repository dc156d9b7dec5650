#include "base/shared_library.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(SharedLibrary, LoadsTheFirstFileThatExists) {
  const SharedLibrary library("mathematics", {"$ORIGIN/libm.so.6", "libm.so.6"});
  const auto cube_root = reinterpret_cast<double (*)(double)>(library.symbol("cbrt"));
  EXPECT_NEAR(cube_root(27), 3, 1e-15);
}

TEST(SharedLibrary, ReportsWhatIsMissingAndWhy) {
  const auto message = [](const auto& load) -> std::string {
    try {
      load();
    } catch (const LibraryError& error) {
      return error.what();
    }
    return {};
  };
  const std::string file = message([] {
    SharedLibrary("telepathy", {"libtelepathy.so.6", "libtelepathy.so.7"});
  });
  EXPECT_EQ(file.find("telepathy cannot be loaded: libtelepathy.so.7: "), 0u) << file;
  const std::string name =
      message([] { SharedLibrary("mathematics", {"libm.so.6"}).symbol("squared_circle"); });
  EXPECT_EQ(name.find("mathematics cannot be loaded: "), 0u) << name;
  EXPECT_NE(name.find("squared_circle"), std::string::npos) << name;
}

}  // namespace
}  // namespace conddp
